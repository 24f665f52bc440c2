"""Where gains are stable: at the forces of Fig. 5a on its finger, and at the slip lengths and speeds of a design."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from frictionloop.analysis import linearise
from frictionloop.analysis.linear import operating_band
from frictionloop.analysis.operating import reach_at
from frictionloop.design.controller_check import Check, check
from frictionloop.parameters import RETUNED, Sine, System
from frictionloop.report import paper_protocol
from frictionloop.report.other_fingers import the_finger
from frictionloop.report.paper_protocol import CONTROLLERS, IDEAL, RETUNED_GAINS, fit, tracking


class Stability(NamedTuple):
    """Of the linear loop at the forces that the sines ask for."""

    sensitivity_peak: float
    """Largest Ms of a finger that has just landed, at those that it can be given; infinite if unstable at one; NaN if
    it can be given none."""
    sensitivity_peak_moist: float
    """The same at the end of the last stroke; NaN if it can be given none of them."""
    stable_from_n: float | None
    """Lowest of these forces from which on it is stable, just landed; None if it is unstable at the highest."""


def stability(system: System, sines: paper_protocol.Sines = paper_protocol.THE_SINES) -> Stability:
    """Return Ms of a finger's loop over the forces of the sines, and from which of them on it is stable."""
    swing = [sign * sines.amplitude_n for sign in (-1, 0, 1)]
    forces_n = sorted({round(level_n + each, 9) for level_n in sines.levels_n for each in swing})
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


def asked_for(gains: Mapping[str, float], sines: paper_protocol.Sines = paper_protocol.THE_SINES) -> System:
    """Return the bench with these gains under the finger that Fig. 5a draws, asked for all its forces.

    It lifts between strokes as there, so that contact upon contact leaves it as moist as the last stroke does.
    """
    low_n, high_n = min(sines.levels_n) - sines.amplitude_n, max(sines.levels_n) + sines.amplitude_n
    asked = Sine(
        offset_n=round((low_n + high_n) / 2, 9),
        amplitude_n=round((high_n - low_n) / 2, 9),
        frequency_hz=sines.frequency_hz,
    )
    lifts = {
        "motion.contact_s": paper_protocol.STROKE_S,
        "motion.lifted_s": paper_protocol.EVERY_S - paper_protocol.STROKE_S,
    }
    there = paper_protocol.finger_system(the_finger()).evolve({**lifts, **gains, "setpoint": asked})
    motion: Any = there.motion
    strokes = motion.in_contacts()
    plate_mm = max(strokes["motion.stroke_mm"], there.touch.load.length_mm)
    return there.evolve({"touch.load.length_mm": plate_mm, **strokes})


class Places(NamedTuple):
    """At how many slip lengths and speeds gains hold."""

    held: int
    unstable: int
    places: int

    def __str__(self) -> str:
        """Return it as 3 of 6."""
        return f"{self.held} of {self.places}"


def places_of(found: Check) -> Places:
    """Return what a check says of gains."""
    how = [place.how for place in found.places]
    return Places(how.count("within"), how.count("unstable"), len(how))


class Held(NamedTuple):
    """Where the re-tuned gains hold, and the printed ones with an ideal sensor and no delay."""

    sensitivity_peak: float
    """Ms at 0.5 N on a dry finger with the report's slip length, 20 mm/s."""
    of_finger: float
    """The largest at the forces of the sines, on the finger that Fig. 5a shows, just landed."""
    of_finger_moist: float
    """The same at the end of the last stroke."""
    ideal_from_n: float | None
    """Lowest force from which on the printed gains are stable on that finger, with an ideal sensor and no delay."""
    places: Places
    """Of the re-tuned gains on that finger, asked for all forces of the sines."""
    instead: Mapping[str, float]
    """An integral alone that holds at all places, as overrides."""
    instead_n: float
    """Error in N of it."""


def gains_hold() -> Held:
    """Return what the linear analysis says of both pairs of gains, and ``design check`` of the re-tuned ones."""
    system, finger = paper_protocol.the_bench().evolve(RETUNED), paper_protocol.finger_system(the_finger())
    peak = linearise(system, force_n=0.5).margins().sensitivity_peak
    shown, ideal = (stability(finger.evolve(CONTROLLERS[each])) for each in (RETUNED_GAINS, IDEAL))
    found = check(asked_for(RETUNED))
    places, instead = places_of(found), {"controller.kp": 0.0, **found.would_hold}
    instead_n = fit(tracking(finger, instead)).rms_n
    return Held(
        peak, shown.sensitivity_peak, shown.sensitivity_peak_moist, ideal.stable_from_n, places, instead, instead_n
    )  # fmt: skip
