"""The grid that a controller has to hold over: slip lengths, speeds, loads, and values that may be off."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import product
from types import MappingProxyType
from typing import Any, NamedTuple

from frictionloop.analysis.linear import LinearLoop, operating_band
from frictionloop.analysis.operating_point import occlusions
from frictionloop.analysis.sampled_plant import sample
from frictionloop.design.plant_set import shifted
from frictionloop.parameters import Skin, Strokes, SuspendedSensor, System
from frictionloop.parameters.motion import TURN_SHARE, one_stroke_a_contact
from frictionloop.quantities import FrictionloopError, Lti, must_be
from frictionloop.sensing.force_sensor import linearise_sensor

USUAL_UM: float = Skin.model_fields["slip_length_um"].default
"""The other end of the range of a system whose own slip length is 0."""
MOST = 0.5
"""Largest share by which a part may be off."""


class Lean(NamedTuple):
    """Shares by which parts of a loop may be off, 0 to 0.5: half widths of intervals over their values."""

    sensor_error: float = 0.0
    """Of the pole behind the springs."""
    delay_error: float = 0.0
    gain_error: float = 0.0
    """Of the sensor's sensitivity, which is in the gain of the loop."""
    q_error: float = 0.0
    """Of the quality factor of the sensor's resonance, at one end or the other with all else as described."""
    ends: tuple[tuple[str, float], ...] = ()
    """Values that the bench may have instead, by dotted name, one at a time: ends of intervals."""

    @property
    def sides(self) -> list[tuple[float, float]]:
        """Which way a loop leans, in lag and in gain: to either end, 0 where nothing of it is off."""
        lags, gains = self.sensor_error or self.delay_error, self.gain_error
        if not lags and not gains:
            return []
        return [(lag, gain) for lag in ((1.0, -1.0) if lags else (0.0,)) for gain in ((1.0, -1.0) if gains else (0.0,))]

    def ends_of(self, loop: LinearLoop) -> list[tuple[str, float]]:
        """Return the values that a loop may have instead, one at a time."""
        if not self.q_error:
            return [*self.ends]
        sensor = loop.system.sensor
        if not isinstance(sensor, SuspendedSensor):
            raise FrictionloopError(f'q_error = {self.q_error:g}: needs sensor.kind = "suspended"')
        return [*(("sensor.q", sensor.q * factor) for factor in (1.0 - self.q_error, 1.0 + self.q_error)), *self.ends]

    def check(self) -> None:
        """Refuse a share outside 0 to 0.5."""
        for name, share in self._asdict().items():
            if name != "ends" and not 0.0 <= share <= MOST:
                raise must_be(name, share, f"from 0 to {MOST:g}")


class OperatingGrid(NamedTuple):
    """Where a controller has to hold, in all combinations; of what is empty the system's own."""

    slip_lengths_um: tuple[float, ...] | None = ()
    """Ends of their range. None: 0 and that of the system."""
    speeds_mm_s: tuple[float, ...] = ()
    loads_n: tuple[float, ...] = ()
    """Mean loads, N."""
    limits: Mapping[float, float] = MappingProxyType({0.0: math.inf})
    """Largest Ms by the share that the resonance is off."""
    lean: Lean = Lean()

    def lengths_of(self, system: System) -> tuple[float, ...]:
        """Return the slip lengths in um, the longest first; none without a skin."""
        if not isinstance(system.finger, Skin):
            return ()
        own = system.finger.slip_length_um
        ends = (0.0, own or USUAL_UM) if self.slip_lengths_um is None else self.slip_lengths_um
        return tuple(sorted(set(ends or (own,)), reverse=True))

    def systems(self, system: System) -> list[System]:
        """Return the system at every combination.

        Raises
        ------
        FrictionloopError
            Speeds or loads of a finger that does not stroke, or a stroke that cannot be.
        """
        for name, listed in (("speeds_mm_s", self.speeds_mm_s), ("loads_n", self.loads_n)):
            if listed and not isinstance(system.motion, Strokes):
                raise FrictionloopError(f'{name}: motion.kind = "{system.motion.kind}" has none; needs "strokes"')
        given: dict[str, Sequence[Any]] = {
            "finger.slip_length_um": self.lengths_of(system), "motion.speed_mm_s": self.speeds_mm_s,
            "motion.load_n": self.loads_n,
        }  # fmt: skip
        axes = [[(path, value) for value in values] for path, values in given.items() if values]
        return [at_place(system, dict(point)) for point in product(*axes)]

    def loops(self, system: System, states: Sequence[float] = ()) -> list[LinearLoop]:
        """Return the loops at lowest, mean and highest force asked for, at each place, by states of the finger.

        Without any these are `occlusions`.
        """
        return [
            loop
            for there in self.systems(system)
            for loop in operating_band(there, occluded=states or occlusions(there))
        ]

    def cases(self, system: System, states: Sequence[float] = ()) -> list[tuple[LinearLoop, float, float]]:
        """Return `loops`, `leaning` and with the resonance off (`shifted`)."""
        return shifted(leaning(self.loops(system, states), self.lean), self.limits)


ITSELF = OperatingGrid()
"""The system at its own slip length, speed and load, without limits."""


def at_place(system: System, place: Mapping[str, Any]) -> System:
    """Return the system at a slip length, speed and load.

    A reversal too long for a stroke at that speed is shortened to what fits: a linear loop slides, and does not turn.
    """
    speed, motion = place.get("motion.speed_mm_s"), system.motion
    if speed is None or not isinstance(motion, Strokes):
        return system.evolve(dict(place))
    longest_s = motion.stroke_mm / (TURN_SHARE * speed)
    return system.evolve({**place, "motion.reversal_s": min(motion.reversal_s, longest_s)})


def at_speed(system: System, speed_mm_s: float) -> System:
    """Return the system with strokes at a speed; where each contact is one stroke, it is as long as that takes."""
    motion = system.motion
    if not isinstance(motion, Strokes) or not one_stroke_a_contact(motion):
        return at_place(system, {"motion.speed_mm_s": speed_mm_s})
    there = motion.model_copy(update={"speed_mm_s": speed_mm_s, "contact_s": _contact_s(motion, speed_mm_s)})
    return system.evolve({"motion.speed_mm_s": speed_mm_s, "motion.contact_s": there.contact_s, **there.in_contacts()})


def _contact_s(motion: Strokes, speed_mm_s: float) -> float:
    """Return how long a stroke as long as these takes at a speed."""
    return motion.contact_s * motion.speed_mm_s / speed_mm_s


def with_longest_contact(system: System, speeds_mm_s: Sequence[float]) -> System:
    """Return the system with contacts as long as those of the slowest speed, where each contact is one stroke.

    At every speed a finger is then as moist as the slowest strokes leave it. Others stay as they are.
    """
    motion = system.motion
    slowest = min(speeds_mm_s, default=math.inf)
    if not isinstance(motion, Strokes) or not one_stroke_a_contact(motion) or slowest >= motion.speed_mm_s:
        return system
    longer = motion.model_copy(update={"contact_s": _contact_s(motion, slowest)})
    return system.evolve({"motion.contact_s": longer.contact_s, **longer.in_contacts()})


def leaning(points: Sequence[LinearLoop], lean: Lean) -> list[LinearLoop]:
    """Return loops as they are, then slow ones and fast ones, either strong and weak.

        slow: sensor_hz (1 - e_s), delay_s (1 + e_d);   strong: gain (1 + e_g);   fast and weak: the other way round

    More lag takes phase margin, but may turn the sensor's resonance away from -1: no end is always the worst. The law
    does not change, since the controller does not know. Then follow the loops with one value at an end, the resonance's
    Q among them.

    Parameters
    ----------
    points : sequence of LinearLoop
        Loops at their operating points.
    lean : Lean
        Shares, of which all 0 adds nothing; and ends.

    Raises
    ------
    FrictionloopError
        An end whose name or value the System refuses, or a Q that is off of a sensor without a resonance.
    """
    found = list(points)
    found += [_leant(point, lag, gain, lean) for lag, gain in lean.sides for point in points]
    for point in points:
        at = point.elements
        for path, value in lean.ends_of(point):
            found += operating_band(point.system.evolve({path: value}), [at.force_n], [at.occluded])
    return found


def _leant(loop: LinearLoop, lag: float, gain: float, lean: Lean) -> LinearLoop:
    sensor, controller = loop.system.sensor, loop.system.controller
    changes = {"controller.delay_s": controller.delay_s * (1 + lag * lean.delay_error)}
    if hasattr(sensor, "cutoff_hz"):
        changes["sensor.cutoff_hz"] = sensor.cutoff_hz * (1 - lag * lean.sensor_error)
    system = loop.system.evolve(changes)
    there = replace(
        loop.elements,
        delay_s=system.controller.delay_s,
        plate=Lti((1 + gain * lean.gain_error,), (1.0,)) * loop.elements.plate,
        stages=linearise_sensor(system.sensor),
    )
    return LinearLoop(system, there, sample(there, loop.plant.period_s))
