"""What a loop leaves of a disturbance between frequencies that a person names: ``--split-hz 8,50``."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from frictionloop.cli.recorded import WIDTH
from frictionloop.loop.bands import disturbance_left_by_band, rms_by_band
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr


MUCH = 0.5
"""Share of what varies in a band (rms) from which on it is told that it lies close to its end (chosen)."""


def edges_of(text: str | None, rate_hz: float) -> list[float]:
    """Return the ends of the bands in Hz, from 0 to infinity; none where no frequency is named.

    Raises
    ------
    FrictionloopError
        For frequencies that do not rise from above 0 to below half the loop's rate.
    """
    if text is None:
        return []
    try:
        named = [float(each) for each in text.split(",")]
    except ValueError:
        named = []
    ends = [0.0, *named, rate_hz / 2.0]
    if not named or not all(low < high for low, high in itertools.pairwise(ends)):
        raise FrictionloopError(
            f"split_hz = {text!r}: must be frequencies in Hz that rise with commas between, such as 8 or 4,20, "
            f"above 0 and below half the loop's rate, {rate_hz / 2.0:g} Hz"
        )
    return [0.0, *named, math.inf]


def by_band(run: xr.Dataset, mask: np.ndarray, edges_hz: list[float]) -> list[dict[str, Any]]:
    """Return each band with its ends, what varies in it and what is left, by name."""
    if not edges_hz or not mask.any():
        return []
    found = disturbance_left_by_band(run, edges_hz, mask)
    columns = ("low_hz", "high_hz", "disturbance_n", "left_n")
    rows = zip(*(found[each].values.tolist() for each in columns), found.values.tolist(), strict=True)
    return [dict(zip((*columns, "disturbance_left"), row, strict=True)) for row in rows]


def rows(
    bands: list[dict[str, Any]], mask: np.ndarray, ends_hz: float = math.inf, rings: bool = False
) -> list[tuple[str, str, str]]:
    """Return a row a band, behind the metrics, of what ``mask`` scores; ``ends_hz`` is where the recording ends.

    ``rings``: the loop rings by itself, so that they are no shares of the disturbance.
    """
    found = [("by frequency" if k == 0 else "", *_said(each, ends_hz)) for k, each in enumerate(bands)]
    inside = mask[mask.argmax() : mask.size - mask[::-1].argmax()]
    if found and rings:
        found.append(("", "", "no shares to quote: the loop rings by itself, with the disturbance and without"))
    if found and not inside.all():
        found.append(("", "", "these shares are rough: across turns and lifts a straight line was drawn"))
    if not all(math.isnan(each["disturbance_left"]) for each in bands):
        apart = "the mean that is left is in no band, and the ends of the scored part count less"
        found.append(("", "", f"{apart}: bands and whole do not add up"))
    return found


def notes(run: xr.Dataset, mask: np.ndarray, bands: list[dict[str, Any]]) -> list[str]:
    """Return that bands are narrower than the part that is scored can tell apart, and that nothing varies at all."""
    if not bands:
        return []
    if all(math.isnan(each["disturbance_left"]) for each in bands):
        return ["--split-hz: nothing of a disturbance varies where scored, or it is not known what is left."]
    at = run["time"].values[mask]
    apart_hz = 2.0 / float(at[-1] - at[0]) if at[-1] > at[0] else math.inf
    mixed = [edge for band, edge, inside in _edges(bands, apart_hz) if _mixed(run, mask, band, inside)]
    if not mixed:
        return []
    edges = " and ".join(f"{edge:g} Hz" for edge in dict.fromkeys(mixed))
    said = (
        f"What is scored is too short to tell frequencies apart by less than {apart_hz:.2g} Hz, and so near to {edges} "
    )
    return textwrap.wrap(
        said + "lies much of what varies on one side of it: its share holds some of the other's.", WIDTH
    )


def _edges(bands: list[dict[str, Any]], apart_hz: float) -> Iterator[tuple[dict[str, Any], float, list[float]]]:
    """Yield each band, an end of it, and the part of it that is too near to that end."""
    for band in bands:
        low, high = band["low_hz"], band["high_hz"]
        if low > 0.0:
            yield band, low, [low, min(low + apart_hz, high)]
        if math.isfinite(high):
            yield band, high, [max(high - apart_hz, low), high]


def _mixed(run: xr.Dataset, mask: np.ndarray, band: dict[str, Any], inside: list[float]) -> bool:
    """Tell whether much of what varies in a band lies in a part of it."""
    if math.isnan(band["disturbance_left"]):
        return False
    (near_n,) = rms_by_band(run["d"].values, run["time"].values, mask, inside)
    return bool(near_n > MUCH * band["disturbance_n"])


def _said(band: dict[str, Any], ends_hz: float) -> tuple[str, str]:
    low, high = band["low_hz"], band["high_hz"]
    where = (
        f"below {high:g} Hz" if low == 0.0 else f"above {low:g} Hz" if math.isinf(high) else f"{low:g} to {high:g} Hz"
    )
    share = band["disturbance_left"]
    if math.isnan(share):
        return "-", f"{where}, where next to nothing varies"
    where += f" (the file ends at {ends_hz:.3g} Hz)" if ends_hz < high and math.isinf(high) else ""
    return f"{share:.3g}", f"{where}, {1e3 * band['left_n']:.3g} of {1e3 * band['disturbance_n']:.3g} mN rms is left"
