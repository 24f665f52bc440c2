"""The plant one control period at a time, for controllers that live outside the simulator."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import ROW
from frictionloop.loop.kernel.tile_compatibility import moves
from frictionloop.loop.simulate import check_seed, is_finite, no_number
from frictionloop.parameters import System, check_system
from frictionloop.physics.finger_step import Motion, heading_step
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.class_help import Brief, brief
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.sensing.finger_tracking import TouchState
from frictionloop.sensing.measurement import Measurement

_UNUSED = np.zeros(BLOCK + 1)  # samples of the set-point, which is the caller's affair
_NONE = np.zeros(0)


@brief
class Movement(NamedTuple):
    """Where a finger is at the time of a sample, how fast it goes and how hard it presses."""

    position_m: float
    speed_m_s: float
    load_n: float


class Stepper(metaclass=Brief):
    """The plant alone: give it an amplitude command, get the measurement one control period later.

    It is the same period function as ``simulate``: fed with the commands of a run it gives that run's measurements,
    bit for bit.

    >>> import frictionloop as fl
    >>> loop = fl.Stepper(fl.paper())
    >>> round(loop.measured.force, 3), loop.tick(1.0).force < loop.measured.force + 1
    (1.2, True)

    Parameters
    ----------
    system : System
        Its plate, friction, sensor, disturbance, rate and delay; set-point and gains are not used.
    seed : int
        Seed of all noise, 0 to 2**64 - 1.

    Raises
    ------
    FrictionloopError
        For what is not a System, a bad seed, or a plant too fast for the control rate.
    """

    def __init__(self, system: System, seed: int = 0) -> None:
        check_system(system)
        self.system, self._seed = system, check_seed(seed)
        self._tile = lower([system], [self._seed], external=True)
        self._period, self._last = 0, round(min(system.disturbance.longest_s, 1e9) * system.controller.rate_hz)
        self._disturbance = _NONE
        self._view = self._tile.slab.data
        self.tells_sampled = self._tile.kernel == "substeps"
        """Whether `force_n` is that at the last sample, as on a bench; else it is the one a period before."""
        # The sensor has settled on the first force, which one period tells: of a bench its sample alone, of the plant
        # of Section 2 all of it, run on a copy.
        probe = self._tile if self.tells_sampled else lower([system], [self._seed], external=True)
        first = probe.disturbance(0, 1)
        probe.advance(0, 1, _UNUSED, first, 0)
        force = probe.slab.view("friction" if self.tells_sampled else "nominal")[0, 0]
        self.force_n = float(force + probe.slab.view("disturbance")[0, 0])
        """Friction force on the finger, which no sensor shows (`tells_sampled`)."""
        self.measured = self._measurement() if self.tells_sampled else Measurement(self.force_n)
        """The last measurement."""

    @property
    def time_s(self) -> float:
        """Time of the last measurement in s."""
        return self._period / self.system.controller.rate_hz

    @property
    def amplitude_um(self) -> float:
        """Vibration amplitude at the time of the last measurement."""
        return float(self._view[ROW["amplitude"]])

    def reset(self, seed: int | None = None) -> Measurement:
        """Begin anew at time 0 and return the first measurement; bit for bit as a new ``Stepper``.

        Parameters
        ----------
        seed : int, optional
            Seed of all noise from now on; the one there is if not given.

        Raises
        ------
        FrictionloopError
            For a bad seed.
        """
        self.__init__(self.system, self._seed if seed is None else seed)  # type: ignore[misc]
        return self.measured

    def _sample(self, k: int, chunk: int) -> None:
        """Take the disturbance of period k: a block ahead, or period by period where a recording ends."""
        if k == chunk:
            try:
                self._disturbance = self._tile.disturbance(chunk, chunk + BLOCK)
            except FrictionloopError:
                self._disturbance = _NONE
        if self._disturbance.size <= BLOCK:
            self._disturbance = self._tile.disturbance(chunk, k + 1)

    def _measurement(self) -> Measurement:
        return Measurement(*(float(value) for value in self._tile.slab.view("measurement")[:, 0]))

    def tick(self, amplitude_command: float, motion: Movement | None = None) -> Measurement:
        """Advance by one control period with this amplitude command (um) and return the measurement at its end.

        Parameters
        ----------
        amplitude_command : float
            Amplitude in um, limited to [0, a_max]; it takes effect ``controller.delay_s`` after the period's start.
        motion : Movement, optional
            Where the finger is at the end of the period, how fast (m/s) and how hard (N) it presses, for a finger that
            is somebody's; by default it goes on with the strokes of its system. Between samples it moves in a line.

        Raises
        ------
        FrictionloopError
            For a command that is not finite, a motion, a disturbance that is over, or friction that is no number.
        """
        if not is_finite(amplitude_command):
            raise must_be("amplitude_command", amplitude_command, "a finite number", "um")
        k, tile = self._period, self._tile
        if motion is not None:
            self._move(motion)
        tile.shared.set(given=motion is not None)
        if k >= self._last:
            raise FrictionloopError(
                f"tick: disturbance.sweep_s = {self._last / self.system.controller.rate_hz:g} s is over"
            )
        self._period += 1
        # A bench's period ends with its sample, which the kernel takes at the beginning of the next.
        k += self.tells_sampled
        chunk = k // BLOCK * BLOCK
        self._sample(k, chunk)
        self._view[ROW["command"]], g = amplitude_command, self._view[ROW["friction"]]
        tile.advance(k, k + 1, _UNUSED, self._disturbance, chunk)
        g = self._view[ROW["friction"]] if self.tells_sampled else g
        self.force_n = float(g + self._view[ROW["disturbance"]])
        self.measured = (
            self._measurement() if self.tells_sampled else Measurement(float(self._view[ROW["measurement"].force]))
        )
        if math.isnan(self.measured.force):
            raise no_number(self.system, f"at {self.time_s:g} s")
        return self.measured

    def _move(self, motion: Movement) -> None:
        if not moves(self.system):
            raise FrictionloopError('motion: needs motion.kind "strokes"')
        if not all(is_finite(value) for value in motion) or motion[2] < 0:
            raise must_be("motion", motion, "finite, load_n from 0")
        fastest = 1e-3 * self.system.touch.position.fastest_mm_s
        if abs(motion[1]) > fastest:
            raise FrictionloopError(
                f"motion.speed_m_s = {motion[1]:g} m/s: at most {fastest:g} m/s (touch.position.fastest_mm_s)"
            )
        position, speed, load = motion
        rows, direction = self._tile.slab.view("motion_next"), heading_step(speed, self._view[ROW["motion"].direction])
        told = {"position": position, "speed": speed, "load": load, "direction": direction, "place": position}
        for name, value in told.items():
            rows[Motion._fields.index(name), 0] = value
        if self._period == 0:  # what was measured before was of the system's own strokes, its skin stretched by these
            known, heading = self._tile.slab.view("touch")[:, 0], heading_step(speed, 1.0)
            before, plays_m = TouchState(*known), 2.0 * self._view[ROW["touch_coefficients"].developed_m]
            missing_m = before.missing if heading == before.direction else plays_m
            known[:] = TouchState(position, speed, load, missing_m, 0.0, heading, abs(speed))
