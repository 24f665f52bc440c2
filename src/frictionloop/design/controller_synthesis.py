"""From a System to a controller: one synthesis per law, held over ranges of speeds and loads to the same margins."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from itertools import count

from frictionloop.analysis.disturbance_spectrum import Spectrum, touch_spectrum
from frictionloop.analysis.operating_point import check_reach
from frictionloop.design import hinf
from frictionloop.design.grid_corners import Corner, broken, corners
from frictionloop.design.limit_observer_synthesis import limit_observer
from frictionloop.design.operating_grid import leaning
from frictionloop.design.pi_synthesis import UNFOUND, retune
from frictionloop.design.plant_set import least_gain
from frictionloop.design.population_margins import loop_gains
from frictionloop.design.requirements import (
    CHECKED,
    COARSE,
    NOT_HELD,
    SEARCHED,
    Designed,
    Requirements,
    feedforward,
    springs_told,
    unheld,
)
from frictionloop.design.robust_notch import WIDEST, retune_notch
from frictionloop.findings import Finding
from frictionloop.loop.progress import step
from frictionloop.parameters import FingerFriction, Skin, Strokes, SuspendedSensor, System
from frictionloop.perception.detection_thresholds import LOWEST_HZ
from frictionloop.quantities import FrictionloopError, check_known

LOWERED = 0.95
"""Least factor on the gains of a search whose grid of frequencies missed a peak (chosen); with less, the law fails."""
GAINS = ("controller.kp", "controller.ki")
Synthesis = Callable[[System, Requirements], Designed]


def check_places(system: System, asked: Requirements) -> None:
    """Refuse a speed or a load at which none of the forces can be had; one alone counts as the nearest that can."""
    for there in asked.grid(*COARSE)._replace(slip_lengths_um=()).systems(system):
        check_reach(there)


def held_between(
    system: System, law: str, synthesis: Synthesis, asked: Requirements
) -> tuple[Designed, Sequence[Corner]]:
    """Return a controller, and its corners at closely spaced speeds and loads, all within the limits.

    The search sees few of them; one at which its result does not hold joins them, and it is made again.

    Raises
    ------
    FrictionloopError
        It does not hold where it was searched for: the line says where, and what limits.
    """
    few, close = asked.grid(*SEARCHED), asked.grid(*CHECKED)
    searched = replace(asked, speeds_mm_s=few.speeds_mm_s, loads_n=few.loads_n)
    searches = count(1)
    while True:
        step(f"search {next(searches)}")
        found = _short(synthesis(system, searched))
        at = found.corners or corners(system.evolve(found.overrides), close)
        worst = broken(at)
        if worst is None:
            return found, at
        more = _joined(searched, worst.loop.system)
        if more != searched:
            searched = more
            continue
        factor = least_gain([each.loop for each in at], [each.limit for each in at])
        lower = lowered(found, factor) if factor >= LOWERED else None
        again = corners(system.evolve(lower.overrides), close) if lower else at
        if lower is None or broken(again):
            raise unheld(law, asked, worst)
        return lower, again


def _joined(searched: Requirements, there: System) -> Requirements:
    """Return what is searched for with the speed and the load of a system among those that are."""
    if not isinstance(there.motion, Strokes):
        return searched
    speeds, loads = searched.speeds_mm_s, searched.loads_n
    if speeds and there.motion.speed_mm_s not in speeds:
        speeds = (*speeds, there.motion.speed_mm_s)
    if loads and there.motion.load_n not in loads:
        loads = (*loads, there.motion.load_n)
    return replace(searched, speeds_mm_s=speeds, loads_n=loads)


def lowered(found: Designed, factor: float) -> Designed | None:
    """Return PI gains times a factor, not looked at; None of a law without them."""
    if not set(GAINS) <= set(found.overrides):
        return None
    lower = {path: factor * found.overrides[path] for path in GAINS}
    return _short(found._replace(overrides={**found.overrides, **lower}, corners=()))


def _short(found: Designed) -> Designed:
    """Return a controller with numbers of five digits, before it is looked at; as it is where that was done already."""
    if found.corners:
        return found
    values = {path: float(f"{value:.5g}") if isinstance(value, float) else value
              for path, value in found.overrides.items()}  # fmt: skip
    return found._replace(overrides=values)


LEAST_KI = 2.0 * math.pi * LOWEST_HZ
"""Least ki worth having, 1/s: with less nothing above 1 Hz, where touch begins to count, is lowered."""
MODEL_ERROR = 0.3
"""Share of the set-point that feed-forward leaves to the feedback: spread of tau over fingers (assumed)."""


def notch_pi(system: System, wanted: Requirements) -> Designed:
    """PI and notch with the least residual, behind feed-forward and overdrive (`retune_notch`)."""
    _check_notch(system)
    forward, findings = feedforward(system)
    spectrum, more = _spectrum(system, MODEL_ERROR if forward else 1.0)
    grid = wanted.grid()
    points = leaning(grid.loops(_plain(system)), grid.lean)
    with _in_terms_of(wanted):
        found = retune_notch(points, wanted.limits, disturbance=spectrum, overdrive=True, least_ki=LEAST_KI)
    told = springs_told(system)
    more += (Finding("MODEL-SET", value=told),) if told else ()
    if found.notch_width >= WIDEST:
        more += (Finding("GAIN-BOUND", value="notch_width", limit=WIDEST),)
    return Designed({**found.overrides, "controller.feedforward": forward, **told}, findings + more)


def pi(system: System, wanted: Requirements) -> Designed:
    """PI alone with the largest ki (`retune`)."""
    cases = wanted.grid().cases(_plain(system))
    with _in_terms_of(wanted):
        found = retune([loop for loop, _, _ in cases], [peak for _, _, peak in cases], LEAST_KI)
    return Designed({"controller.kind": "pi", **found.overrides})


SYNTHESES: dict[str, Synthesis] = {
    "notch_pi": notch_pi,
    "pi": pi,
    "limit_observer": limit_observer,
    "hinf": hinf.synthesised,
}
"""Every synthesis by the name of its law; one more is one more line."""


def default_law(system: System) -> str:
    """Return "notch_pi" where the force sensor stands on springs, "pi" where it has no resonance."""
    return "notch_pi" if isinstance(system.sensor, SuspendedSensor) else "pi"


def synthesised(system: System, law: str, asked: Requirements) -> tuple[Designed, Requirements]:
    """Return a controller whose margins hold over forces, a dry and a moist finger, and resonances, and what it holds.

    Where no slip length is named and no controller holds from 0 on, it is for that of the system.

    Raises
    ------
    FrictionloopError
        An unknown law, no force asked for that is in reach of a finger just landed, or no controller of that law
        holds: the line says what limits it.
    """
    check_known("law", [law], SYNTHESES)
    check_places(system, asked)
    try:
        return _for_people(system, law, asked), asked
    except FrictionloopError as error:
        finger = system.finger
        if asked.slip_lengths_um is not None or not isinstance(finger, Skin) or error.code != NOT_HELD:
            raise
        why = Finding("ONE-LENGTH", value=finger.slip_length_um, unit="um", more={"reason": str(error)})
    one = replace(asked, slip_lengths_um=(finger.slip_length_um,))
    alone = _for_people(system, law, one)
    return alone._replace(findings=(*alone.findings, why)), one


def _for_people(system: System, name: str, asked: Requirements) -> Designed:
    """Return a controller that bears the loop gains of other people too."""
    found, at = held_between(system, name, SYNTHESES[name], asked)
    after, gain = system.evolve(found.overrides), asked.gain_of(system)
    people = loop_gains(after, asked.grid(*COARSE))
    lower = lowered(found, people.critical / gain) if people is not None and people.critical < gain else None
    # One of another law, and one that would lower nothing felt any more, stays as it is.
    if lower is not None and float(lower.overrides["controller.ki"]) > LEAST_KI:
        found, at = lower, corners(system.evolve(lower.overrides), asked.grid(*CHECKED))
    return found._replace(corners=tuple(at))


@contextmanager
def _in_terms_of(asked: Requirements) -> Iterator[None]:
    """Say why a least ki is asked for where a search does not get there."""
    try:
        yield
    except FrictionloopError as error:
        if error.code != UNFOUND:
            raise
        why = f"ki above {LEAST_KI:.3g} 1/s lowers what is felt"
        raise FrictionloopError(f"sensitivity_peak = {asked.sensitivity_peak:g}: {error}; {why}", NOT_HELD) from None


def _plain(system: System) -> System:
    """Return the loop with a law whose operating points need no Jacobian."""
    return system.evolve({"controller.kind": "pi"})


def _check_notch(system: System) -> None:
    sensor, nyquist_hz = system.sensor, system.controller.rate_hz / 2.0
    if isinstance(sensor, SuspendedSensor) and not sensor.resonance_hz < nyquist_hz:
        raise FrictionloopError(f"sensor.resonance_hz = {sensor.resonance_hz:g} Hz: must be below {nyquist_hz:g} Hz")


def _spectrum(system: System, share: float) -> tuple[Spectrum | None, tuple[Finding, ...]]:
    """Return the disturbance of a finger that strokes, or None and what to know."""
    if isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes):
        return touch_spectrum(system, share), ()
    return None, (Finding("NO-SPECTRUM"),)
