"""Loops that are not quite what was written down: slow or fast, strong or weak, or one value at an end."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from frictionloop.analysis.band import operating_band
from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.sampled import sample
from frictionloop.parameters import SuspendedSensor
from frictionloop.quantities import FrictionloopError, Lti, must_be
from frictionloop.sensing.force_sensor import linearise_sensor

MOST = 0.5


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
    def shares(self) -> dict[str, float]:
        """The shares, by name."""
        return {name: value for name, value in self._asdict().items() if name != "ends"}

    @property
    def loops_each(self) -> int:
        """How many loops come of one."""
        return 1 + len(self.sides) + 2 * bool(self.q_error) + len(self.ends)

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

    def checked(self) -> Lean:
        """Return itself; refuses a share outside 0 to 0.5."""
        for name, share in self.shares.items():
            if not 0.0 <= share <= MOST:
                raise must_be(name, share, f"from 0 to {MOST:g}, e.g. 0.05")
        return self


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
