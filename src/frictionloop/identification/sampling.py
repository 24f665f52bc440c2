"""The sampling rate of a file: what it tells, checked against its column of times."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from frictionloop.quantities import must_be
from frictionloop.quantities.checks import ABOVE_0, number
from frictionloop.quantities.timestamp_jitter import MISSING
from frictionloop.quantities.units import UNITS
from frictionloop.recordings.clock import may_be_seconds
from frictionloop.recordings.contents import Contents
from frictionloop.recordings.stored import Samples, blocks_of

AGREE = 1e-3
"""How far two rates may be apart and still be the same, as a share."""
UNEVEN = 0.1
"""A step of time that is off by more than this share, and no gap, is uneven; smaller ones are jitter (assumed)."""


class Sampling(NamedTuple):
    """When the samples of a file were taken."""

    rate_hz: float | None
    """None: the file is a plain table."""
    source: str
    """Where the rate comes from."""
    gaps: tuple[tuple[int, int], ...] = ()
    """Row before each gap in the times, and how many samples are missing there."""
    even: bool = True
    """Whether the times rise in equal steps."""


def sampling_of(path: str, contents: Contents, rate_hz: float | None = None) -> Sampling:
    """Return the rate of a file."""
    if rate_hz is not None:
        number("rate_hz", rate_hz, "Hz", ABOVE_0)
    told = dict(contents.rates_hz)
    clock = contents.clock()
    gaps: tuple[tuple[int, int], ...] = ()
    even = True
    if clock is not None and clock.samples.size > 1:
        step_s, gaps, even = _steps(clock.samples, clock.unit, next(iter(told.values()), rate_hz))
        if step_s is not None:
            told[f"the column {clock.name!r}"] = float(f"{1 / step_s:.9g}")
    if rate_hz is not None:
        # A rate that is given settles what the file leaves open, and is a third opinion otherwise.
        agreeing = [where for where, hertz in told.items() if abs(hertz - rate_hz) <= AGREE * rate_hz]
        if len(told) == 1 and not agreeing and even:
            _disagree(path, {"rate_hz": rate_hz} | told)
        return Sampling(float(rate_hz), "given" + (f", as {agreeing[0]} says" if agreeing else ""), gaps, even)
    if not told:
        return Sampling(None, "told nowhere", gaps, even)
    hertz = next(iter(told.values()))
    if any(abs(other - hertz) > AGREE * hertz for other in told.values()):
        _disagree(path, told)
    return Sampling(hertz, " and ".join(told), gaps, even)


def _disagree(path: str, told: dict[str, float]) -> None:
    says = ", ".join(f"{hertz:.6g} Hz by {where}" for where, hertz in told.items())
    raise must_be(f"{path}: rate_hz", says, "given in the map")


def _steps(
    times: Samples, unit: str | None, near_hz: float | None
) -> tuple[float | None, tuple[tuple[int, int], ...], bool]:
    """Return the usual step in s (None for counts), the gaps, and whether the times are even apart from them."""
    usual, total, inside, row = 0.0, 0.0, 0, 0
    missing: list[tuple[int, int]] = []
    even, last = True, np.zeros(0)
    for block in blocks_of(times):
        steps = np.diff(np.concatenate([last, np.asarray(block, dtype=float)]))
        last, start = np.asarray(block[-1:], dtype=float), max(row - 1, 0)
        row += block.size
        usual = usual or (float(np.nanmedian(steps)) if steps.size else 0.0)
        if not usual > 0:
            return None, (), False
        near = np.abs(steps - usual) <= UNEVEN * usual
        off = np.flatnonzero(~near)
        jumps = steps[off] / usual
        missing += [(start + int(k), round(jump) - 1) for k, jump in zip(off, jumps, strict=True) if jump >= MISSING]
        even = even and not bool(np.any(~(jumps >= MISSING)))
        total, inside = total + float(steps[near].sum()), inside + int(near.sum())
    usual = total / inside if inside else usual
    gaps = tuple(missing)
    if unit in UNITS:
        return usual * UNITS[str(unit)][1], gaps, even
    # Without a unit the times are in s, or in ms or us if only that agrees with the rate told elsewhere.
    for factor in (1.0, 1e-3, 1e-6):
        if near_hz is not None and abs(usual * factor * near_hz - 1) <= AGREE:
            return usual * factor, gaps, even
    return (usual if may_be_seconds(usual) else None), gaps, even
