"""Where a change of Fig. 5a moves the poles of plate and contact, and what the loop's resonance is then, in lines."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from frictionloop.analysis import operating_band
from frictionloop.parameters import ResonantPlate, SuspendedSensor, System
from frictionloop.physics.contact import linearise_slip
from frictionloop.physics.plate import linearise_plate
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.report.device import CONTROLLERS, RETUNED_GAINS
from frictionloop.report.protocol import Sines

SEEN = 0.01
"""Share by which a pole moves for it to be told."""
GAIN = 0.1
"""Share by which the loop gain changes for it to be told (chosen)."""
DAMPS = "damps the sensor's resonance in the loop"
DOES = {
    frozenset({True}): f"a higher one {DAMPS} less",
    frozenset({False}): f"a lower one {DAMPS} more",
    frozenset({True, False}): f"a lower one {DAMPS} more, a higher one less",
}
"""What poles do that go up, down, or one each way."""


def moved(changes: Mapping[str, Any], base: System, sines: Sines, tuned: bool) -> list[str]:
    """Return which poles move, and if ``tuned`` the loop gain of the re-tuned gains at the sensor's resonance.

    The pole of the plate is at f0/(2 Q), that of the contact at v/(2 pi z), without a slip length it has none.
    """
    force_n = sum(sines.levels_n) / len(sines.levels_n)
    before, there = base, base.evolve(changes)
    return [*_poles(before, there, force_n), *(_resonance(before, there, force_n) if tuned else [])]


def _poles(before: System, there: System, force_n: float) -> list[str]:
    plate = there.plate
    rule = f", f0/(2 Q) with Q {plate.q:g}" if isinstance(plate, ResonantPlate) else ""
    found = {
        f"of the plate{rule}": [_pole_hz(linearise_plate(each.plate)) for each in (before, there)],
        f"of the contact at {force_n:g} N": [_contact_hz(each, force_n) for each in (before, there)],
    }
    apart = {name: pair for name, pair in found.items() if not math.isclose(*pair, rel_tol=SEEN)}
    if not apart:
        return []
    said = "; and that ".join(f"{name}, from {_hz(was)} to {_hz(now)}" for name, (was, now) in apart.items())
    does = DOES[frozenset(now > was for was, now in apart.values())]
    return [f"the change moves the pole {said}: {does} (docs/bench-gains.md)"]


def _resonance(before: System, there: System, force_n: float) -> list[str]:
    """Return |G| at the resonance of the sensor: where it is above 1, delay decides whether the loop rings."""
    found = []
    for system in (before, there):
        try:
            (loop,) = operating_band(system.evolve(CONTROLLERS[RETUNED_GAINS]), [force_n], [0.0])
        except FrictionloopError:  # out of reach
            return []
        if not isinstance(system.sensor, SuspendedSensor):
            return []
        found.append(float(abs(loop.responses([system.sensor.resonance_hz])["G"][0])))
    was, now = found
    if math.isclose(was, now, rel_tol=GAIN):
        return []
    return [
        f"loop gain of the {RETUNED_GAINS} at the sensor's resonance, at {force_n:g} N: {now:.3g} (unchanged "
        f"{was:.3g}); whether it rings is told by Ms, which counts the phase too"
    ]


def _contact_hz(system: System, force_n: float) -> float:
    finger: Any = system.finger  # a skin on strokes, by the protocol
    motion: Any = system.motion
    return _pole_hz(linearise_slip(finger, force_n, 1e-3 * motion.speed_mm_s))


def _pole_hz(lag: Lti) -> float:
    """Return the pole of a first-order lag, Hz; infinite where there is none."""
    return lag.den[1] / (2.0 * math.pi * lag.den[0]) if len(lag.den) > 1 else math.inf


def _hz(pole: float) -> str:
    return f"{pole:.3g} Hz" if math.isfinite(pole) else "infinity"
