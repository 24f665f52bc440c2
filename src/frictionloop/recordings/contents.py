"""Everything that a file of signals holds, as it stands there: what a reader looks at before it computes."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings.headers import header, is_time
from frictionloop.recordings.stored import Samples

_SAID = re.compile(r"([+-]?[\d.,]+(?:e[+-]?\d+)?)\s*([a-zµμ/1]*)", re.IGNORECASE)
_THOUSANDS = re.compile(r"[1-9]\d{0,2}(,\d{3})+")
_HERTZ = {**dict.fromkeys(("", "hz", "1/s", "s/s", "sa/s", "samples/s"), 1.0), "khz": 1e3, "ks/s": 1e3, "mhz": 1e6}
MOST_LINES = 256
"""An array with more lines than this both ways is a picture, not a set of channels (assumed)."""
_RATES = {"acquisitionrate", "scanrate", "loggingrate", "datarate", "samplefreq", "samplingfreq", "abtastrate"}
_RATES |= {"sr", "fs", "rate", "samplerate", "samplingrate", "samplefrequency", "samplingfrequency", "freqsampling"}
_STEPS = {"dt", "ts", "deltat", "deltax", "sampletime", "samplingtime", "sampleinterval", "samplinginterval"}
_STEPS |= {"interval", "timestep", "sampleperiod", "samplingperiod"}
_STEPS |= {"wfincrement", "abscissainc"}
_DATES = {"date", "wfstarttime", "datetime", "recorded", "starttime"}


@dataclass(frozen=True)
class Channel:
    """One line of samples of a file."""

    name: str
    samples: Samples
    """In the type in which the file has them, shape (samples,); those of a large file stay there (`Stored`)."""
    unit: str | None = None
    """What the file says."""
    full_scale: float | None = None
    """Largest magnitude of the format, where it has one."""


@dataclass(frozen=True)
class Contents:
    """What a file holds."""

    channels: tuple[Channel, ...]
    rates_hz: Mapping[str, float] = field(default_factory=dict)
    """Sampling rate in Hz by where the file says it ("'sr'", "the header of the WAV file")."""
    findings: tuple[Finding, ...] = ()
    """What was left out, and why."""
    date: str = ""
    """When it was recorded, by the file."""
    stamped: tuple[str, ...] = ()
    """Channels that are times whatever they are called: the file has times of the clock on the wall there."""

    def clock(self) -> Channel | None:
        """Return the column of times, None without one."""
        return next(filter(self._is_clock, self.channels), None)

    def signals(self) -> tuple[Channel, ...]:
        """Return the channels but the times."""
        return tuple(each for each in self.channels if not self._is_clock(each))

    def _is_clock(self, channel: Channel) -> bool:
        return channel.name in self.stamped or is_time(channel.name.rpartition("/")[2])


def left_out(name: str, reason: str) -> Finding:
    """Return that something of a file was left out."""
    return Finding("LEFT-OUT", where=Condition(channel=name), more={"reason": reason})


def told_rate(name: str, value: Any) -> float | None:
    """Return the sampling rate in Hz if a name and its value tell one ("fs": 1e4, "dt_ms": 0.1, "rate": "1 kHz")."""
    said = header(name.rpartition("/")[2])
    word = re.sub(r"[^a-z]", "", re.sub(r"(k?hz)$", "", said.name.lower().strip("_ ")))
    if word not in _RATES | _STEPS:
        return None
    number, unit = _number(value)
    in_name = re.search(r"(k?hz)\W*$", name.lower())
    if not (np.isfinite(number) and number > 0):
        return None
    if word in _RATES:
        scale = _HERTZ.get((unit or (in_name[1] if in_name else "")).lower())
        return None if scale is None else number * scale
    of, scale = UNITS.get(known_unit(unit or said.unit or "s") or "", ("", 1.0))
    return 1.0 / (number * scale) if of == "s" else None


def _number(value: Any) -> tuple[float, str]:
    """Return the number in a value, NaN without one, and the unit behind it in a text."""
    one = np.ravel(value)[0] if np.size(value) == 1 else ""
    text = one.decode("utf-8", "replace") if isinstance(one, bytes) else one
    if not isinstance(text, str):
        text = str(one) if isinstance(one, (int, float, np.number)) else ""
    found = _SAID.fullmatch(text.strip())
    if found is None or _THOUSANDS.fullmatch(found[1]):
        return np.nan, ""
    try:
        return float(found[1].replace(",", ".")), found[2]
    except ValueError:
        return np.nan, ""


def told_rates(pairs: Iterable[tuple[str, Any]]) -> dict[str, float]:
    """Return the rates that names and values tell, by the name."""
    return {repr(name): rate for name, value in pairs if (rate := told_rate(name, value)) is not None}


def rate_beside(
    path: str, name: str, attributes: Mapping[str, Mapping[str, Any]], arrays: Mapping[str, Any]
) -> tuple[str, float] | None:
    """Return what tells the sampling rate of an array, and the rate in Hz: of all that do, the nearest.

    An attribute of the array comes first, then one of its group or a number beside it, then those of the group above.
    """
    pairs, folder = list(attributes.get(name, {}).items()), name
    while True:
        told = one_rate(path, told_rates(pairs))
        if told is not None or not folder:
            return told
        folder = folder.rpartition("/")[0]
        beside = [(each, array) for each, array in arrays.items() if each.rpartition("/")[0] == folder]
        pairs = [*attributes.get(folder, {}).items(), *((each.rpartition("/")[2], array) for each, array in beside)]


def one_rate(path: str, told: Mapping[str, float]) -> tuple[str, float] | None:
    """Return what tells the rate, and the rate in Hz; refuse two that differ by more than 0.1 %."""
    first = next(iter(told.items()), None)
    if first is not None and any(abs(rate - first[1]) > 1e-3 * first[1] for rate in told.values()):
        says = ", ".join(f"{where} says {rate:.6g} Hz" for where, rate in told.items())
        raise FrictionloopError(f"{path}: the sampling rate is in doubt: {says}; accepted: one rate")
    return first


def told_date(pairs: Iterable[tuple[str, Any]]) -> str:
    """Return the first date that names and values tell, "" without one."""
    for name, value in pairs:
        if re.sub(r"[^a-z]", "", name.lower()) in _DATES and np.size(value) == 1:
            found = np.ravel(value)[0]
            return (found.decode("utf-8", "replace") if isinstance(found, bytes) else str(found)).strip()
    return ""


def lines_of(name: str, array: NDArray[Any], unit: str | None = None) -> Iterator[Channel]:
    """Yield the channels of an array: itself, or its lines along the longer side as ``name[:, k]`` or ``name[k, :]``.

    Scalars, texts and arrays of more than two dimensions hold no channels.
    """
    plain = name.rpartition("/")[2]
    stated = unit or header(plain).unit
    if array.dtype.kind not in "iufbc" or array.ndim not in (1, 2) or array.size < 2:
        return
    if array.ndim == 1 or 1 in array.shape:
        yield Channel(name, np.ravel(array), stated)
    elif min(array.shape) <= MOST_LINES:
        tall = array.shape[0] >= array.shape[1]
        for k in range(min(array.shape)):
            yield Channel(f"{name}[:, {k}]" if tall else f"{name}[{k}, :]", array[:, k] if tall else array[k], stated)
