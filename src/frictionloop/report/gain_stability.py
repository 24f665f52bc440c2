"""Where gains are stable: at the forces of Fig. 5a on its finger, and at the slip lengths and speeds of a design."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from frictionloop.analysis import linearise
from frictionloop.analysis.linear import operating_band
from frictionloop.analysis.operating_point import reach_at
from frictionloop.design.controller_check import Check, check
from frictionloop.parameters import RETUNED, Sine, System
from frictionloop.report import paper_protocol
from frictionloop.report.other_fingers import the_finger
from frictionloop.report.paper_protocol import AMPLITUDE_N, FREQUENCY_HZ, LEVELS_N, fit, tracking


class Stability(NamedTuple):
    """Of the linear loop at the forces that the sines ask for."""

    sensitivity_peak: float
    """Largest Ms of a finger that has just landed, at those that it can be given; infinite if unstable at one; NaN if
    it can be given none."""
    sensitivity_peak_moist: float
    """The same at the end of the last stroke; NaN if it can be given none of them."""
    stable_from_n: float | None
    """Lowest of these forces from which on it is stable, just landed; None if it is unstable at the highest."""


def stability(system: System) -> Stability:
    """Return Ms of a finger's loop over the forces of the sines, and from which of them on it is stable."""
    swing = [sign * AMPLITUDE_N for sign in (-1, 0, 1)]
    forces_n = sorted({round(level_n + each, 9) for level_n in LEVELS_N for each in swing})
    dry, moist = (_peaks(system, forces_n, w) for w in (0.0, paper_protocol.occlusion_at_end(system)))
    stable = [force_n for k, force_n in enumerate(dry) if all(map(math.isfinite, [*dry.values()][k:]))]
    return Stability(_largest(dry), _largest(moist), min(stable, default=None))


def _peaks(system: System, forces_n: Sequence[float], occluded: float) -> dict[float, float]:
    """Return Ms at those of the forces that a finger so moist can be given at its mean load, by force, rising.

    The sines pass all forces between the ends: that at which the reach begins or stops is looked at too.
    """
    low_n, high_n = reach_at(system, occluded)
    low_n, high_n = max(low_n, forces_n[0]), min(high_n, forces_n[-1])
    there = sorted({low_n, high_n, *(force_n for force_n in forces_n if low_n <= force_n <= high_n)})
    if low_n > high_n:
        return {}
    return {force_n: operating_band(system, [force_n], [occluded])[0].sensitivity_peak() for force_n in there}


def _largest(peaks: Mapping[float, float]) -> float:
    return max(peaks.values(), default=math.nan)


def asked_for(gains: Mapping[str, float]) -> System:
    """Return the bench with these gains under the finger that Fig. 5a draws, asked for all its forces.

    It lifts between strokes as there, so that contact upon contact leaves it as moist as the last stroke does.
    """
    low_n, high_n = LEVELS_N[0] - AMPLITUDE_N, LEVELS_N[-1] + AMPLITUDE_N
    middle_n, swing_n = (round(each / 2, 9) for each in (high_n + low_n, high_n - low_n))
    asked = Sine(offset_n=middle_n, amplitude_n=swing_n, frequency_hz=FREQUENCY_HZ)
    lifts = {
        "motion.contact_s": paper_protocol.STROKE_S,
        "motion.lifted_s": paper_protocol.EVERY_S - paper_protocol.STROKE_S,
    }
    there = paper_protocol.finger_system(the_finger()).evolve({**lifts, **gains, "setpoint": asked})
    motion: Any = there.motion
    strokes = motion.in_contacts()
    plate_mm = max(strokes["motion.stroke_mm"], there.touch.load.length_mm)
    return there.evolve({"touch.load.length_mm": plate_mm, **strokes})


def places_of(found: Check) -> Counter[str]:
    """Return at how many slip lengths and speeds gains hold ("within"), are "unstable", and so on."""
    return Counter(place.how for place in found.places)


class Held(NamedTuple):
    """Where the re-tuned gains hold."""

    sensitivity_peak: float
    """Ms at 0.5 N on a dry finger with the report's slip length, 20 mm/s."""
    places: Counter[str]
    """Of the re-tuned gains on the finger of Fig. 5a, asked for all forces of the sines."""
    instead: Mapping[str, float]
    """An integral alone that holds at all places, as overrides."""
    instead_n: float
    """Error in N of it."""


def gains_hold() -> Held:
    """Return what the linear analysis and ``design check`` say of the re-tuned gains."""
    peak = linearise(paper_protocol.the_bench().evolve(RETUNED), force_n=0.5).margins().sensitivity_peak
    found = check(asked_for(RETUNED))
    instead = {"controller.kp": 0.0, **found.would_hold}
    error_n = fit(tracking(paper_protocol.finger_system(the_finger()), instead)).error_n
    return Held(peak, places_of(found), instead, error_n)
