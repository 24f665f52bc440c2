"""From a System to a controller: one synthesis per law, each held to the same margins at the same corners."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace

from frictionloop.analysis.disturbance import Spectrum, touch_spectrum
from frictionloop.design.corners import Corner, band_of, corners
from frictionloop.design.elsewhere import elsewhere
from frictionloop.design.held import CHECKED, ENDS, LOADS, Synthesis, check_places, held_between, lowered
from frictionloop.design.leaning import leaning
from frictionloop.design.loop_gains import loop_gains
from frictionloop.design.notch import retune_notch
from frictionloop.design.plants import shifted
from frictionloop.design.retune import retune
from frictionloop.design.wanted import Designed, Wanted, feedforward, on_one, springs_told
from frictionloop.parameters import FingerFriction, Skin, Strokes, SuspendedSensor, System
from frictionloop.perception.thresholds import LOWEST_HZ
from frictionloop.quantities import FrictionloopError, check_known

LEAST_KI = 2.0 * math.pi * LOWEST_HZ
"""Least ki worth having, 1/s: with less nothing above 1 Hz, where touch begins to count, is lowered."""
MODEL_ERROR = 0.3
"""Share of the set-point that feed-forward leaves to the feedback: spread of tau over fingers (assumed)."""


def notch_pi(system: System, wanted: Wanted) -> Designed:
    """PI and notch with the least residual, behind feed-forward and overdrive (`retune_notch`)."""
    _check_notch(system)
    forward, notes = feedforward(system)
    spectrum, more = _spectrum(system, MODEL_ERROR if forward else 1.0)
    points = leaning(band_of(_plain(system), wanted.places), wanted.lean)
    with _in_terms_of(wanted):
        found = retune_notch(points, wanted.limits, disturbance=spectrum, overdrive=True, least_ki=LEAST_KI)
    told, said = springs_told(system)
    return Designed({**found.overrides, "controller.feedforward": forward, **told}, notes + more + said)


def pi(system: System, wanted: Wanted) -> Designed:
    """PI alone with the largest ki (`retune`)."""
    cases = shifted(leaning(band_of(_plain(system), wanted.places), wanted.lean), wanted.limits)
    with _in_terms_of(wanted):
        found = retune([loop for loop, _, _ in cases], [peak for _, _, peak in cases], LEAST_KI)
    return Designed({"controller.kind": "pi", **found.overrides})


def hinf(system: System, wanted: Wanted) -> Designed:
    """Mixed-sensitivity H-infinity of up to 13 states with feed-forward (`design_hinf`)."""
    from frictionloop.design.hinf import synthesised

    return synthesised(system, wanted)


def limit_observer(system: System, wanted: Wanted) -> Designed:
    """Observer of the friction limit, made to believe what bears other resonances (`limit_synthesis`)."""
    from frictionloop.design.limit_synthesis import limit_observer as synthesised

    return synthesised(system, wanted)


SYNTHESES: dict[str, Synthesis] = {
    "notch_pi": notch_pi,
    "pi": pi,
    "limit_observer": limit_observer,
    "hinf": hinf,
}
"""Every synthesis by the name of its law; one more is one more line."""


def default_law(system: System) -> str:
    """Return "notch_pi" where the force sensor stands on springs, "pi" where it has no resonance."""
    return "notch_pi" if isinstance(system.sensor, SuspendedSensor) else "pi"


def design_controller(system: System, law: str | None = None, wanted: Wanted | None = None) -> Designed:
    """Return a controller whose margins hold over forces, a dry and a moist finger, and resonances.

    Parameters
    ----------
    system
        The bench; of its controller only times and model are used.
    law
        Name in `SYNTHESES`; `default_law` if None.
    wanted
        What must hold. None: `Wanted` as it is. Where it names no slip length and no controller holds from 0 on, the
        answer is for that of the system, and ``one_length`` says why.

    Raises
    ------
    FrictionloopError
        An unknown law, no force asked for that is in reach of a finger just landed, or no controller of that law
        holds: the line says what limits it.
    """
    name, asked = law or default_law(system), wanted or Wanted()
    check_known("law", [name], SYNTHESES)
    check_places(system, asked)
    try:
        return _designed(system, name, asked)
    except FrictionloopError as error:
        finger, why = system.finger, str(error)
        if asked.slip_lengths_um is not None or not isinstance(finger, Skin) or not why.endswith(on_one(asked)):
            raise
    alone = _designed(system, name, replace(asked, slip_lengths_um=(finger.slip_length_um,)))
    return alone._replace(one_length=why.removesuffix(on_one(asked)))


def _designed(system: System, name: str, asked: Wanted) -> Designed:
    found, at = held_between(system, name, SYNTHESES[name], asked)
    after, over = system.evolve(found.overrides), asked.over(ENDS, LOADS)
    people, gain = loop_gains(after, over), asked.gain_of(system)
    if people is not None and people.critical < gain:
        found, at = for_gain(system, found, at, asked, people.critical / gain)
        after = system.evolve(found.overrides)
        people = loop_gains(after, over)
    more, notes = elsewhere(after, asked.limits, over, asked.lean), found.notes
    return found._replace(corners=tuple(at), elsewhere=more, notes=(*notes, *more.unseen), people=people)


def for_gain(
    system: System, found: Designed, at: Sequence[Corner], asked: Wanted, factor: float
) -> tuple[Designed, Sequence[Corner]]:
    """Return a controller with PI gains times a factor, which a finger of larger loop gain bears, and its corners.

    One of another law, and one that would lower nothing felt any more, stays as it is.
    """
    lower = lowered(found, factor)
    if lower is None or float(lower.overrides["controller.ki"]) <= LEAST_KI:
        return found, at
    again = corners(system.evolve(lower.overrides), asked.limits, asked.over(CHECKED, LOADS), asked.lean)
    return lower, again


@contextmanager
def _in_terms_of(wanted: Wanted) -> Iterator[None]:
    """Say why a least ki is asked for where a search does not get there, and for which slip lengths."""
    asked = f"least_ki = {LEAST_KI:g} 1/s: "
    try:
        yield
    except FrictionloopError as error:
        why = f"ki must be above {LEAST_KI:.3g} 1/s to lower anything felt, from {LOWEST_HZ:g} Hz on; "
        said = str(error).replace(asked, f"sensitivity_peak = {wanted.sensitivity_peak:g}: {why}")
        raise FrictionloopError(said + on_one(wanted)) from None


def _plain(system: System) -> System:
    """Return the loop with a law whose operating points need no Jacobian."""
    return system.evolve({"controller.kind": "pi"})


def _check_notch(system: System) -> None:
    sensor, nyquist_hz = system.sensor, system.controller.rate_hz / 2.0
    if isinstance(sensor, SuspendedSensor) and not sensor.resonance_hz < nyquist_hz:
        raise FrictionloopError(
            f"sensor.resonance_hz = {sensor.resonance_hz:g} Hz: a notch must lie below half of controller.rate_hz, "
            f"{nyquist_hz:g} Hz"
        )


def _spectrum(system: System, share: float) -> tuple[Spectrum | None, tuple[str, ...]]:
    """Return the disturbance of a finger that strokes, or None and what to say."""
    if isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes):
        return touch_spectrum(system, share), ()
    return None, ("no finger strokes in this system: ki is the largest, not that of the least residual",)
