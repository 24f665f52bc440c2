"""From a System to a controller: one synthesis per law, each held to the same margins at the same corners."""

from __future__ import annotations

import difflib
import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple

from frictionloop.design.corners import Corner, band_of, broken, corners, with_shifts
from frictionloop.design.disturbance import Spectrum, touch_spectrum
from frictionloop.design.notch import retune_notch
from frictionloop.design.operating import check_reach
from frictionloop.design.retune import retune
from frictionloop.parameters import FingerFriction, Skin, Strokes, SuspendedSensor, System
from frictionloop.parameters.filtered import LONGEST_DELAY
from frictionloop.perception.thresholds import LOWEST_HZ
from frictionloop.quantities import FrictionloopError

LEAST_KI = 2.0 * math.pi * LOWEST_HZ
"""Least ki worth having, 1/s: with less nothing above 1 Hz, where touch begins to count, is lowered."""
WIDER = (1.0, 10.0 / 7.0, 16.0 / 7.0)
"""How Ms - 1 may grow with the resonance off by 0, e and 2 e: 1.7, 2.0 and 2.6."""
MODEL_ERROR = 0.3
"""Share of the set-point that feed-forward leaves to the feedback: spread of tau over fingers (assumed)."""
TIGHTER = (1.0, 0.8, 0.6, 0.45, 0.3)
"""Shares of Ms - 1 that are tried where a synthesis does not see every corner."""


@dataclass(frozen=True)
class Wanted:
    """What a controller has to hold."""

    sensitivity_peak: float = 1.7
    """Largest Ms with the resonance as described, above 1."""
    resonance_error: float = 0.05
    """Share by which the resonance may be off, either way, 0 to 0.25; at twice that it still has to be calm."""

    def __post_init__(self) -> None:
        if not 1.0 < self.sensitivity_peak <= 10.0:
            raise FrictionloopError(f"sensitivity_peak = {self.sensitivity_peak:g}: must be above 1, up to 10")
        if not 0.0 <= self.resonance_error <= 0.25:
            raise FrictionloopError(f"resonance_error = {self.resonance_error:g}: must be from 0 to 0.25, e.g. 0.05")

    @property
    def limits(self) -> dict[float, float]:
        """Largest Ms by the share that the resonance is off: {0: 1.7, 0.05: 2.0, 0.1: 2.6}."""
        return self.scaled(1.0)

    def scaled(self, share: float) -> dict[float, float]:
        """Return the limits with so much of Ms - 1."""
        room = (self.sensitivity_peak - 1.0) * share
        wider = WIDER if self.resonance_error > 0 else WIDER[:1]
        return {k * self.resonance_error: round(1.0 + room * factor, 12) for k, factor in enumerate(wider)}


class Designed(NamedTuple):
    """A controller, and what a person should know of it."""

    overrides: Mapping[str, Any]
    """For ``System.evolve``."""
    notes: tuple[str, ...] = ()


Synthesis = Callable[[System, Wanted], Designed]


def notch_pi(system: System, wanted: Wanted) -> Designed:
    """PI and notch with the least residual, behind feed-forward and overdrive (`retune_notch`)."""
    _check_notch(system)
    forward, notes = _feedforward(system)
    spectrum, more = _spectrum(system, MODEL_ERROR if forward else 1.0)
    points = band_of(_plain(system))
    with _in_terms_of(wanted):
        found = retune_notch(points, wanted.limits, disturbance=spectrum, overdrive=True, least_ki=LEAST_KI)
    return Designed({**found.overrides, "controller.feedforward": forward}, notes + more)


def pi(system: System, wanted: Wanted) -> Designed:
    """PI alone with the largest ki (`retune`)."""
    cases = with_shifts(_plain(system), wanted.limits)
    with _in_terms_of(wanted):
        found = retune([loop for loop, _, _ in cases], [peak for _, _, peak in cases], LEAST_KI)
    return Designed({"controller.kind": "pi", **found.overrides})


def observer(system: System, wanted: Wanted) -> Designed:
    """Disturbance observer: bandwidth and believed resonance with the least residual."""
    from frictionloop.design.observed import tune_observer

    spectrum, notes = _spectrum(system, MODEL_ERROR)
    return Designed(tune_observer(system, "observer", wanted.limits, spectrum), notes)


def super_twisting(system: System, wanted: Wanted) -> Designed:
    """Super-twisting on the same observer; its small-signal loop is that of the sliding mode reached."""
    from frictionloop.design.observed import tune_observer

    spectrum, notes = _spectrum(system, MODEL_ERROR)
    said = "margins are those of small signals, inside the sliding mode; k1 and k2 stay as they are"
    return Designed(tune_observer(system, "super_twisting", wanted.limits, spectrum), (*notes, said))


def hinf(system: System, wanted: Wanted) -> Designed:
    """Mixed-sensitivity H-infinity of up to 13 states with feed-forward (`design_hinf`)."""
    from frictionloop.design.hinf import design_hinf

    return _synthesised(design_hinf, system, wanted)


def lqg(system: System, wanted: Wanted) -> Designed:
    """LQG on the same weighted plant (`design_lqg`)."""
    from frictionloop.design.hinf import design_lqg

    return _synthesised(design_lqg, system, wanted)


SYNTHESES: dict[str, Synthesis] = {
    "notch_pi": notch_pi,
    "pi": pi,
    "observer": observer,
    "super_twisting": super_twisting,
    "hinf": hinf,
    "lqg": lqg,
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
        What must hold. None: `Wanted` as it is.

    Raises
    ------
    FrictionloopError
        An unknown law, or no controller of that law holds: the line says what limits it.
    """
    name, asked = law or default_law(system), wanted or Wanted()
    if name not in SYNTHESES:
        near = difflib.get_close_matches(name, SYNTHESES, n=3, cutoff=0.4)
        hint = f"; did you mean {' or '.join(near)}?" if near else ""
        raise FrictionloopError(f"law: {name!r} is unknown{hint} Accepted: {', '.join(SYNTHESES)}")
    check_reach(system)
    found = SYNTHESES[name](system, asked)
    worst = broken(corners(system.evolve(found.overrides), asked.limits), asked.limits)
    if worst is not None:
        raise FrictionloopError(_unheld(name, asked, worst))
    return found


@contextmanager
def _in_terms_of(wanted: Wanted) -> Iterator[None]:
    """Say why a least ki is asked for where a search does not get there."""
    asked = f"least_ki = {LEAST_KI:g} 1/s: "
    try:
        yield
    except FrictionloopError as error:
        why = f"ki must be above {LEAST_KI:.3g} 1/s to lower anything felt, from {LOWEST_HZ:g} Hz on; "
        said = str(error).replace(asked, f"sensitivity_peak = {wanted.sensitivity_peak:g}: {why}")
        raise FrictionloopError(said) from None


def _unheld(law: str, wanted: Wanted, worst: Corner) -> str:
    limits = ", ".join(f"{peak:.3g} at +-{off:.0%}" for off, peak in sorted(wanted.limits.items()))
    limit = "the resonance is the limit" if worst.off else "delay and lags of the loop are the limit"
    return (
        f"sensitivity_peak = {wanted.sensitivity_peak:g}: law {law} cannot hold Ms <= {limits}; it gets to "
        f"{worst.margins.sensitivity_peak:.3g} at {worst.where}; {limit}"
    )


def _synthesised(design: Callable[..., Any], system: System, wanted: Wanted) -> Designed:
    """Return the controller of the least tightened limits that holds at every corner, not only on the method's grid."""
    from frictionloop.design import hinf_wanted as room
    from frictionloop.design.noise_model import identify_noise

    forward, notes = _feedforward(system)
    noise = identify_noise(system)
    first = ""
    for share in TIGHTER:
        peaks = tuple(peak for _, peak in sorted(wanted.scaled(share).items()))
        peaks = peaks if len(peaks) == 3 else (peaks[0],) * 3
        asked = room.Wanted(peaks, wanted.resonance_error, contact=_contacts(system))
        try:
            found = design(system, noise, wanted=asked)
        except FrictionloopError as error:
            first = first or str(error)
            continue
        overrides = {**found.overrides, "controller.feedforward": forward}
        worst = broken(corners(system.evolve(overrides), wanted.limits), wanted.limits)
        if worst is None:
            said = (
                f"{found.order} states, reduced from {found.full_order}; holds on contacts {', '.join(asked.contact)}"
            )
            return Designed(overrides, (*notes, said))
        first = first or _unheld(found.method, wanted, worst)
    raise FrictionloopError(first)


def _contacts(system: System) -> tuple[str, ...]:
    own = system.finger.contact if isinstance(system.finger, Skin) else "dahl"
    return tuple(dict.fromkeys((own, "dahl", "slider")))


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


def _feedforward(system: System) -> tuple[bool, tuple[str, ...]]:
    """Return whether feed-forward can follow the delay, and what to say if not."""
    controller = system.controller
    periods = controller.delay_s * controller.rate_hz
    if periods <= LONGEST_DELAY * (1 + 1e-9):
        return True, ()
    return False, (f"no feed-forward: it follows {LONGEST_DELAY} periods of delay at most, here are {periods:.3g}",)


def _spectrum(system: System, share: float) -> tuple[Spectrum | None, tuple[str, ...]]:
    """Return the disturbance of a finger that strokes, or None and what to say."""
    if isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes):
        return touch_spectrum(system, share), ()
    return None, ("no finger strokes in this system: ki is the largest, not that of the least residual",)
