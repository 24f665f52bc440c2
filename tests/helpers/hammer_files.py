"""Hammer files as laboratories have them, from sums of damped oscillations: nothing of the package makes them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr


class HammerFile(NamedTuple):
    """A recording and what is true of it."""

    reading: np.ndarray
    hammer: np.ndarray | None
    rate_hz: float
    hits: int
    """Blows of more than a tenth of the last one; a rebound is none."""
    hertz: float
    """Of the strongest mode, undamped."""
    q: float

    def recording(self) -> xr.Dataset:
        """Return it as the package takes it."""
        columns = {"f_m": ("time", self.reading, {"units": "V"})}
        columns |= {} if self.hammer is None else {"hammer": ("time", self.hammer, {"units": "N"})}
        return xr.Dataset(columns, {"time": ("time", np.arange(self.reading.size) / self.rate_hz, {"units": "s"})})


def hammer_file(seed: int) -> HammerFile:
    """Return a file with 2 to 8 modes, up to three of them weak, long and beating, 2 to 61 blows, rebounds and taps."""
    draw = np.random.default_rng([51, seed])
    hertz, q = np.exp(draw.uniform(np.log([120, 8]), np.log([1800, 50])))
    rate_hz = float(draw.choice([16, 32, 64])) * hertz
    modes = [(hertz, q, 1.0), *_others(draw, hertz, q)]
    count = round(np.exp(draw.uniform(np.log(2), np.log(61))))
    ring_s = max(each[1] / (np.pi * each[0]) for each in modes)
    gaps = max(0.5, 8 * q / (np.pi * hertz), 3 * ring_s) * draw.uniform(1.0, 1.6, count + 1)
    blows = list(zip(np.cumsum(gaps)[:-1], draw.uniform(0.4, 1.0, count), strict=True))
    hits = count
    for (at, size), gap in zip(blows[:], gaps[1:], strict=True):
        kind, large = draw.random(), draw.random() < 0.5
        if kind < 0.08:  # a rebound
            blows.append((at + draw.uniform(0.008, 0.04), size * draw.uniform(0.15, 0.5)))
        elif kind < 0.14:  # a tap, later
            blows.append((at + 0.6 * gap, size * (draw.uniform(0.15, 0.3) if large else draw.uniform(0.01, 0.05))))
            hits += large
    total = np.zeros(int(np.sum(gaps) * rate_hz) + 1)
    force, width = np.zeros_like(total), max(int(rate_hz / hertz / draw.uniform(3, 8)), 3)
    pulse = np.sin(np.pi * (np.arange(width) + 0.5) / width)
    spread, time = draw.choice([0.0, 2e-4, 1e-3]), np.arange(int(max(gaps) * rate_hz)) / rate_hz
    for at, size in blows:
        row, moved = int(at * rate_hz), 2 * np.pi * (1 + spread * draw.normal())
        shape = np.zeros(time.size)
        for f, each_q, share in modes:
            decay = np.exp(-0.5 * moved * f / each_q * time) * np.sin(moved * f * (1 - 0.25 / each_q**2) ** 0.5 * time)
            shape += share * draw.uniform(0.8, 1.2) * decay
        shape = np.convolve(shape, pulse)[: min(time.size, total.size - row)] / pulse.sum()
        total[row : row + shape.size] += size * shape
        force[row : row + width] += size * pulse[: force[row : row + width].size]
    total += np.exp(draw.uniform(np.log(1e-4), np.log(2e-3))) * draw.normal(size=total.size)
    hammer = force + 1e-3 * draw.normal(size=total.size) if draw.random() < 0.4 else None
    return HammerFile(total, hammer, rate_hz, int(hits), float(hertz), float(q))


def _others(draw: np.random.Generator, hertz: float, q: float) -> list[tuple[float, float, float]]:
    """Return one to seven further modes: strong ones apart from the first, weak long ones beside it."""
    count, found = int(draw.integers(1, 8)), []
    for _ in range(int(draw.integers(0, min(count, 3) + 1))):
        beside = hertz * (1 + draw.choice([-1, 1]) * draw.uniform(0.01, 0.06))
        found.append((beside, q * draw.uniform(3, 8), draw.uniform(0.005, 0.04)))
    above = hertz
    while len(found) < count and above < 4 * hertz:
        above *= draw.uniform(1.25, 1.7)
        found.append((above, q * draw.uniform(0.7, 2), draw.uniform(0.05, 0.5) * draw.choice([-1, 1])))
    return found
