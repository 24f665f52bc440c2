"""What a file of signals holds: each a channel with its own rate, unit, scale and times."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings.headers import header, is_time
from frictionloop.recordings.stored import Samples

Array = NDArray[np.float64]
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


@dataclass(frozen=True)
class Channel:
    """One signal of a file."""

    name: str
    """With the groups that it stands in."""
    samples: Samples
    """In the type in which the file has them, shape (samples,); those of a large file stay there (`Stored`)."""
    unit: str | None = None
    """What the file says."""
    full_scale: float | None = None
    """Largest magnitude of the format, where it has one."""
    newtons: tuple[float, float] | None = None
    """Newtons of one unit and of 0, where the file says them."""
    rates_hz: Mapping[str, float] = field(default_factory=dict)
    """Its sampling rate in Hz by where the file says it ("'sr'", "the header of the WAV file")."""
    times: Channel | None = None
    """When its samples were taken."""
    number: int | None = None
    """Its column, where the format counts them."""
    is_clock: bool = False
    """Whether it holds times, whatever it is called."""
    unit_in_doubt: str = ""
    """Why a unit in the file is not taken."""
    row: Callable[[int], str] | None = None
    """Says where sample i stands and what is there, where that is a line of a text."""

    @property
    def leaf(self) -> str:
        """Its name without groups."""
        return self.name.rpartition("/")[2]

    @property
    def tells_time(self) -> bool:
        """Whether it holds times."""
        return self.is_clock or (is_time(self.leaf) and UNITS.get(self.unit or "s", ("s",))[0] == "s")

    def place(self, i: int) -> str:
        """Return where sample i stands, and what is there."""
        return self.row(i) if self.row else f"column {self.name!r} at index {i} is {self.samples[i : i + 1][0]}"


@dataclass(frozen=True)
class Contents:
    """What a file holds."""

    channels: tuple[Channel, ...]
    findings: tuple[Finding, ...] = ()
    """What was left out or taken for granted."""
    date: str = ""
    """When it was recorded, as ISO 8601 writes it."""
    dated: bool = True
    """Whether the file says so; else it is the day on which it was last written."""

    def signals(self) -> tuple[Channel, ...]:
        """Return the channels but the times."""
        return tuple(each for each in self.channels if not each.tells_time)

    def findings_of(self, channels: Iterable[Channel]) -> list[Finding]:
        """Return what counts for some channels: not that others were left out."""
        own = {one.name for each in channels for one in (each, each.times) if one is not None}
        return [each for each in self.findings if each.code != "LEFT-OUT" or each.value or each.where.channel in own]


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


def lines_of(name: str, array: NDArray[Any], unit: str | None = None) -> Iterator[Channel]:
    """Yield the channels of an array: itself, or its lines along the longer side as ``name[:, k]`` or ``name[k, :]``.

    Of a structured array each field is one, as ``name/field``. Scalars and texts hold no channels, nor do arrays of
    more than two dimensions that are longer than 1.
    """
    if array.dtype.names:
        for each in array.dtype.names:
            yield from lines_of(f"{name}/{each}", array[each])
        return
    array = np.squeeze(array)
    stated = unit or header(name.rpartition("/")[2]).unit
    if array.dtype.kind not in "iufbc" or array.ndim not in (1, 2) or array.size < 2:
        return
    if array.ndim == 1:
        yield Channel(name, array, stated)
    elif min(array.shape) <= MOST_LINES:
        tall = array.shape[0] >= array.shape[1]
        for k in range(min(array.shape)):
            yield Channel(f"{name}[:, {k}]" if tall else f"{name}[{k}, :]", array[:, k] if tall else array[k], stated)
