"""The device's clock against the host's: readings of both, a line through them, and jumps that are seen."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

DRIFT = 2e-4
"""Most by which two clocks run apart, s/s (assumed: crystals of 100 ppm each)."""
STEP_S = 2e-4
"""Step of the device's clock: one tick."""
KEPT = 256
"""Readings that are kept (assumed)."""
SPAN_S = 5.0
"""Span of readings from which on the rate is told from them; before, it is taken as 1 (assumed)."""


class ClockMap:
    """Times of the host on the device's clock: device = offset + rate host, by least squares over good readings.

    The half of the readings with the shortest round trips counts: what is late was held up on one way. The standard
    deviation of a mapped time is the root of the sum of the squares of

        trip/sqrt(12)   the device read its clock at any time of the shortest round trip
        step/sqrt(12)   its clock counts ticks of 0.2 ms
        rms             residuals of the line
        drift           2e-4 times the time to the nearest reading over sqrt(3), while the rate is taken as 1

    A reading that lies farther from the line than round trips and drift allow is a jump: of a clock that was set, or of
    a device that began anew. The line then starts afresh behind it.
    """

    def __init__(self) -> None:
        self._readings: deque[tuple[float, float, float]] = deque(maxlen=KEPT)

    def add(self, device_s: float, host_s: float, trip_s: float) -> float:
        """Take a reading and return by how much the clocks have jumped against each other before it, 0 if not, in s.

        Parameters
        ----------
        device_s : float
            Time that the device told.
        host_s : float
            Host's time between asking and hearing.
        trip_s : float
            Time between asking and hearing.
        """
        jumped_s = 0.0
        if self._readings:
            before = self._readings[-1]
            apart = (device_s - before[0]) - (host_s - before[1])
            if abs(apart) > 0.5 * (trip_s + before[2]) + STEP_S + DRIFT * abs(host_s - before[1]):
                jumped_s = apart
                self._readings.clear()
        self._readings.append((device_s, host_s, trip_s))
        return jumped_s

    def device_s(self, host_s: float) -> tuple[float, float]:
        """Return a time of the host on the device's clock, and its standard deviation, both in s; NaN without readings.

        Parameters
        ----------
        host_s : float
            Time of the host.
        """
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
        sd = math.sqrt((float(trip.min()) ** 2 + STEP_S**2) / 12.0 + rms**2 + drift_s**2)
        return offset + rate * (host_s - float(host[0])), sd
