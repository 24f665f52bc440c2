"""The plant one control period at a time, for controllers that live outside the simulator."""

from __future__ import annotations

import numpy as np

from frictionloop.loop.kernel import kernel
from frictionloop.loop.lowering import Tile, lower
from frictionloop.loop.simulate import NO_TRACES
from frictionloop.loop.slab import ROW
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.normals import BLOCK
from frictionloop.sensing.measurement import Measurement


class Stepper:
    """The plant alone: give it an amplitude command, get the measurement one control period later.

    It is the same period function as ``simulate``: fed with the commands of a run it gives that run's measurements,
    bit for bit.

    >>> import frictionloop as fl
    >>> loop = fl.Stepper(fl.paper())
    >>> round(loop.measured.force, 3), loop.tick(1.0).force < loop.measured.force + 1
    (1.2, True)
    """

    def __init__(self, system: System, seed: int = 0) -> None:
        self.system = system
        self._tile = lower([system], [seed], external=True)
        self._advance = kernel(1)
        self._period = 0
        self._samples = (0, NO_TRACES, NO_TRACES)
        self._view = self._tile.slab.data
        # The sensor has settled on the first force; one period run on a copy tells which.
        probe = lower([system], [seed], external=True)
        self._advance(probe.slab.data, 1, 0, 1, probe.options, probe.buffers, *self._chunk(probe), 0, NO_TRACES)
        first = float(probe.slab.view("nominal")[0, 0] + probe.slab.view("disturbance")[0, 0])
        self.measured = Measurement(first)
        """The last measurement."""

    @property
    def time_s(self) -> float:
        """Time of the last measurement in s."""
        return self._period / self.system.controller.rate_hz

    @property
    def force_n(self) -> float:
        """Friction force g(a) + d at the beginning of the last period, which no sensor shows."""
        return float(self._view[ROW["friction"]])

    @property
    def amplitude_um(self) -> float:
        """Vibration amplitude at the time of the last measurement."""
        return float(self._view[ROW["amplitude"]])

    def _chunk(self, tile: Tile) -> tuple[np.ndarray, np.ndarray]:
        return tile.setpoint(0, BLOCK), tile.disturbance(0, BLOCK)

    def tick(self, amplitude_command: float, motion: object = None) -> Measurement:
        """Advance by one control period with this amplitude command (um) and return the measurement at its end.

        The command is limited to [0, a_max] and takes effect ``controller.delay_s`` after the period's start.
        ``motion`` (position, speed, load) is for benches with a moving finger; the plant of Section 2 has none.
        """
        if not np.isfinite(amplitude_command):
            raise FrictionloopError(f"amplitude_command = {amplitude_command!r} um: must be a finite number")
        if motion is not None:
            raise FrictionloopError("motion: this plant has no moving finger; leave it out")
        k, tile = self._period, self._tile
        chunk = k // BLOCK * BLOCK
        if k == chunk:
            self._samples = (chunk, tile.setpoint(chunk, chunk + BLOCK), tile.disturbance(chunk, chunk + BLOCK))
        self._view[ROW["command"]] = amplitude_command
        _, setpoint, disturbance = self._samples
        self._advance(self._view, 1, k, k + 1, tile.options, tile.buffers, setpoint, disturbance, chunk, NO_TRACES)
        self._period += 1
        force = self._view[ROW["measurement"]]
        self.measured = Measurement(float(force))
        return self.measured
