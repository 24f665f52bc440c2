"""A device as what presents strokes of a person's finger, recorded at its own clock, and that against the host's."""

from __future__ import annotations

import itertools
import math
import time
from collections import deque
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.device.device import Device, connect
from frictionloop.experiments.measured_finger import MOST_N, PLAIN_S, STROKE_S, MeasuredFinger, measured_finger
from frictionloop.experiments.respondent import Live, Presented, Respondent, Response
from frictionloop.experiments.trial_loop import Stroke
from frictionloop.experiments.trial_structure import Timeline
from frictionloop.parameters import System

DRIFT = 2e-4
"""Most by which two clocks run apart, s/s (assumed: crystals of 100 ppm each)."""
KEPT = 256
"""Readings that are kept (assumed)."""
SPAN_S = 5.0
"""Span of readings from which on the rate is told from them; before, it is taken as 1 (assumed)."""


class ClockMap:
    """Times of the host on the device's clock: device = offset + rate host, by least squares over good readings.

    The half of the readings with the shortest round trips counts: what is late was held up on one way. The standard
    deviation of a mapped time is the root of the sum of the squares of

        trip/sqrt(12)   the device read its clock at any time of the shortest round trip
        step/sqrt(12)   its clock counts ticks
        rms             residuals of the line
        drift           2e-4 times the time to the nearest reading over sqrt(3), while the rate is taken as 1

    A reading that lies farther from the line than round trips and drift allow is a jump: of a clock that was set, or of
    a device that began anew. The line then starts afresh behind it.
    """

    def __init__(self, step_s: float) -> None:
        self._step_s = step_s
        self._readings: deque[tuple[float, float, float]] = deque(maxlen=KEPT)

    def add(self, device_s: float, host_s: float, trip_s: float) -> float:
        """Take a reading and return by how much the clocks have jumped against each other before it, 0 if not, in s."""
        jumped_s = 0.0
        if self._readings:
            before = self._readings[-1]
            apart = (device_s - before[0]) - (host_s - before[1])
            if abs(apart) > 0.5 * (trip_s + before[2]) + self._step_s + DRIFT * abs(host_s - before[1]):
                jumped_s = apart
                self._readings.clear()
        self._readings.append((device_s, host_s, trip_s))
        return jumped_s

    def device_s(self, host_s: float) -> tuple[float, float]:
        """Return a time of the host on the device's clock and its standard deviation, in s; NaN without readings."""
        if not self._readings:
            return math.nan, math.nan
        device, host, trip = np.array(self._readings).T
        best = np.argsort(trip, kind="stable")[: max((trip.size + 1) // 2, 1)]
        x, y = host[best] - host[0], device[best]
        rate, drift_s = 1.0, DRIFT * float(np.abs(host[best] - host_s).min()) / math.sqrt(3.0)
        if np.ptp(x) >= SPAN_S:
            rate, drift_s = float(np.polyfit(x, y - y[0], 1)[0]), 0.0
        offset = float(np.mean(y - rate * x))
        rms = float(np.sqrt(np.mean((y - offset - rate * x) ** 2)))
        sd = math.sqrt((float(trip.min()) ** 2 + self._step_s**2) / 12.0 + rms**2 + drift_s**2)
        return offset + rate * (host_s - float(host[0])), sd


VIRTUAL = ("sim:", "emulated:")
"""Devices whose clock runs as fast as they can."""
READINGS = 3
"""Readings of both clocks before and after each stroke, and at each answer (assumed)."""


class DeviceEngine:
    """A device: onset and offset are ticks of its clock, and the force is what it measures.

    It plays the effect of a trial by its own tables (`Device.run`). How far these are from the effect is in the traces,
    as ``setpoint_error_n``.
    """

    def __init__(self, address: str, system: System, keep: Path | None = None) -> None:
        self.source = "simulated" if address.startswith(VIRTUAL) else "device"
        self._waits = not address.startswith(VIRTUAL)
        self._device: Device = connect(address, system)
        self._base, self._keep = system, keep or Path()
        self._loaded: object = None
        self._clock = ClockMap(1.0 / self._device.info.tick_hz)

    def present(self, strokes: Sequence[Stroke], timeline: Timeline, shown: Respondent) -> list[Presented]:
        """Play the strokes of a trial."""
        found: list[Presented] = []
        for interval, stroke in enumerate(strokes, 1):
            is_open = stroke.system.controller.kind == "lookup"
            # The finger moves by itself: which samples count is told by the guide, not by a simulated participant.
            own = stroke.system.model_copy(update={"motion": self._base.motion})
            self._upload(self._base if is_open else own)
            if self._waits:
                time.sleep(timeline.gap_s if found else timeline.cue_s)
            shown.cued(interval, stroke.duration_s)
            jumped = self._look()
            state, tell = "open" if is_open else "closed", partial(_tell, shown, interval)
            run = self._run(stroke.system.setpoint, stroke.duration_s, state, tell)
            onset = float(run.attrs["start_tick"]) / self._device.info.tick_hz
            jumped += self._look()
            found.append(Presented(run, onset, onset + stroke.duration_s, jumped))
            shown.stroked(interval, run)
        return found

    def answered(self, response: Response, presented: Sequence[Presented]) -> tuple[Response, float]:
        """Return an answer with its time on the device clock.

        The host's time of the answer is mapped (`ClockMap`); that of a virtual board counts from when it was asked.
        """
        if response.at_s is None or not self._waits:
            return response, 0.0
        jumped = self._look()
        at_s, sd = self._clock.device_s(response.at_s)
        rt_s, unsure = at_s - presented[-1].offset_s, (sd**2 + response.uncertainty_s**2) ** 0.5
        return response._replace(rt_s=rt_s, uncertainty_s=unsure + abs(jumped)), jumped

    def reach(self, system: System, seed: int) -> MeasuredFinger:
        """Return what the finger can be given, by two plain strokes open loop."""
        self._upload(self._base)
        without = self._run(MOST_N, PLAIN_S, "open")
        largest = self._run(0.0, STROKE_S, "open")
        return measured_finger(without, largest, float(largest["a"].values.max()))

    def close(self) -> None:
        """Let go of the line, the plate switched off."""
        self._device.close()

    def _upload(self, system: System) -> None:
        if system.controller != self._loaded:
            self._device.upload(system)
            self._loaded = system.controller

    def _run(
        self, setpoint: Any, duration_s: float, state: str, live: Callable[[dict[str, float]], Any] | None = None
    ) -> xr.Dataset:
        """Run a stroke; the file stays only if it ends early."""
        path = next(
            each for number in itertools.count(1) if not (each := self._keep / f"interrupted-{number}.h5").exists()
        )
        run = self._device.run(setpoint, duration_s, path=path, state=state, live=live)
        run.load().close()
        path.unlink()
        return run

    def _look(self) -> float:
        """Read both clocks and return their jump since the last readings, s."""
        return sum(self._clock.add(*self._device.clock()) for _ in range(READINGS))


def _tell(shown: Respondent, interval: int, sample: dict[str, float]) -> None:
    forces = sample["f_m"], sample["f_r"]
    shown.live(Live(interval, sample["elapsed_s"], *forces, 1e3 * sample["speed"], sample["load"]))
