"""A column of a file in the unit, the sign and the time that a map gives it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import shift

from frictionloop.identification.channel_map import USUAL, Channel
from frictionloop.quantities import must_be
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings import contents as found
from frictionloop.recordings.stored import Samples

Array = NDArray[np.float64]


class Place(NamedTuple):
    """Where the rows stand that a column is asked for, and how they are taken."""

    first: int
    stop: int
    rate_hz: float
    dim: str
    mapped: bool
    """Whether a map names the column: then it must hold numbers that are not all alike."""


def variable(where: str, name: str, line: found.Channel, told: Channel, place: Place) -> xr.Variable:
    """Return rows of a column unwrapped, less its zero, scaled, turned and moved as the map says."""
    if line.samples.dtype.kind == "c":
        raise must_be(f"{where}: column {line.name!r}", "complex", "samples in time")
    values = np.asarray(line.samples[place.first : place.stop], dtype=float)
    if place.mapped:
        _refuse_no_numbers(where, line, values, place)
    if told.wrap is not None:
        values = np.unwrap(values, period=told.wrap)
    if told.zero_s is not None:
        values = values - _zero(where, name, line.samples, told, place.rate_hz)
    factor, unit = _factor(where, name, line, told, place.mapped)
    values = (told.sign or 1) * factor * values
    if told.delay_s:
        values = shift(values, -told.delay_s * place.rate_hz, order=3, mode="nearest")
    attributes: dict[str, object] = {"units": unit, "long_name": line.name}
    if told.newtons_per_unit is not None:
        attributes["newtons_per_unit"] = told.newtons_per_unit
    return xr.Variable(place.dim, values, attributes)


def _refuse_no_numbers(where: str, line: found.Channel, values: Array, place: Place) -> None:
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        row = place.first + int(bad[0])
        accepted = f"a number; {bad.size} are none"
        raise must_be(f"{where}: column {line.name!r} at row {row}", float(values[bad[0]]), accepted, "", "DATA-GAPS")
    if line.samples.size == values.size > 1 and np.ptp(values) == 0:
        raise must_be(f"{where}: column {line.name!r}", f"{values[0]:g} throughout", "one that varies")


def _zero(where: str, name: str, samples: Samples, told: Channel, rate_hz: float) -> float:
    window = told.zero_s or (0.0, 0.0)
    first, stop = round(window[0] * rate_hz), round(window[1] * rate_hz)
    if not 0 <= first < stop <= samples.size:
        accepted = f"rising within 0 to {samples.size / rate_hz:g}"
        raise must_be(f"{where}: channels.{name}.zero_s", window, accepted, "s")
    values = np.asarray(samples[first:stop], dtype=float)
    return float(values.mean() if told.wrap is None else np.unwrap(values, period=told.wrap).mean())


def _factor(where: str, name: str, line: found.Channel, told: Channel, mapped: bool) -> tuple[float, str]:
    """Return what a column is multiplied by, and the unit that this gives."""
    stated = told.unit or line.unit
    base = UNITS.get(known_unit(stated or "") or "")
    if told.scale is not None:
        return told.scale, told.gives or USUAL.get(name, "N")
    if base is not None:
        if told.gives is not None and told.gives != base[0]:
            raise must_be(f"{where}: channels.{name}.gives", told.gives, f"{base[0]}, or with a scale")
        return base[1], base[0]
    if told.gives is not None or not mapped:
        return 1.0, told.gives or stated or ""
    # A channel of which nothing is said is in the unit of its kind; counts and the like are kept as they are.
    return 1.0, stated or USUAL.get(name, "N")
