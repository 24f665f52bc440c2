"""What a file of signals holds: channels, each with rate, unit, scale and times, and which one a name means."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryFile
from typing import Any
from weakref import finalize

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.quantities import Array, FrictionloopError, check_known, must_be
from frictionloop.quantities.units import UNITS, known_unit
from frictionloop.recordings.text_numbers import header, is_time, plain_text

LARGE_BYTES = 2**26
"""A file, or an array unpacked, above this size stays where it is; a smaller one is read whole (64 MiB)."""
BLOCK = 2**17
"""Rows that are read at once: of eight channels in double precision 8 MiB."""


@dataclass(frozen=True)
class Stored:
    """One line of samples in a file: ``stored[a:b]`` reads rows a to b, ``np.asarray(stored)`` all of them."""

    size: int
    dtype: np.dtype[Any]
    fetch: Callable[[int, int], NDArray[Any]]
    """Returns rows a to b of one block."""

    def __getitem__(self, rows: slice) -> NDArray[Any]:
        first, stop, step = rows.indices(self.size)
        if stop <= first or first // BLOCK == (stop - 1) // BLOCK:
            return self.fetch(first, max(stop, first))[::step]
        found = np.empty(stop - first, self.dtype)
        for start in range(first // BLOCK * BLOCK, stop, BLOCK):
            inside = slice(max(first - start, 0), min(stop - start, BLOCK))
            block = self.fetch(start, min(start + BLOCK, self.size))[inside]
            found[start + inside.start - first :][: block.size] = block
        return found[::step]

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        return np.asarray(self[:], dtype)


Samples = NDArray[Any] | Stored


def is_large(path: Path, size: int, itemsize: int = 8) -> bool:
    """Return whether an array of a file is to stay there."""
    return size > BLOCK and max(path.stat().st_size, size * itemsize) > LARGE_BYTES


def blocks_of(samples: Samples) -> Iterator[NDArray[Any]]:
    """Yield samples in blocks; of an array that is in the memory anyway, one."""
    if isinstance(samples, Stored):
        for start in range(0, samples.size, BLOCK):
            yield samples[start : start + BLOCK]
    else:
        yield samples


def count_blocks(samples: Samples) -> int:
    """Return how many blocks `blocks_of` yields."""
    return -(-samples.size // BLOCK) if isinstance(samples, Stored) else 1


class Spool:
    """Rows of numbers in a file without a name: a text that is too large for the memory is parsed once."""

    def __init__(self, width: int) -> None:
        self._file, self._width, self._rows = TemporaryFile(), width, 0  # noqa: SIM115
        finalize(self, self._file.close)

    def add(self, rows: Array) -> None:
        """Keep rows, shape (rows, columns)."""
        rows.tofile(self._file)
        self._rows += len(rows)

    def columns(self) -> list[Stored]:
        """Return each column of what was kept."""
        self._file.flush()
        return [Stored(self._rows, np.dtype(float), partial(self._read, k)) for k in range(self._width)]

    def _read(self, k: int, first: int, stop: int) -> Array:
        self._file.seek(8 * first * self._width)
        return np.fromfile(self._file, float, (stop - first) * self._width).reshape(-1, self._width)[:, k]


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
    found = _SAID.fullmatch(plain_text(value).strip())
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

    Of a structured array each field is one, as ``name/field``, in the array's unit if it says no other. Scalars and
    texts hold no channels, nor do arrays of more than two dimensions that are longer than 1.
    """
    if array.dtype.names:
        for each in array.dtype.names:
            yield from lines_of(f"{name}/{each}", array[each], None if is_time(each) or header(each).unit else unit)
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


SHOWN = 12
"""Channels that an error lists."""
_LINE = re.compile(r"(.*?)\s*\[\s*(?::\s*,\s*(\d+)|(\d+)\s*,\s*:)\s*\]", re.DOTALL)


def find_channel(where: str, contents: Contents, wanted: str | int) -> Channel:
    """Return a channel by its path, by its column's number, by its name in any case with or without its unit, or group.

    Numbers count from 0: the columns of a text, the channels of a sound, elsewhere what `identify channels` lists.
    ``name[:, k]`` and ``name[k, :]`` are lines of an array.

    Raises
    ------
    FrictionloopError
        For a channel that is not there, or is there more than once; what is there is listed.
    """
    text = str(wanted).strip().strip("\"'").strip().lstrip("/")
    there = contents.channels
    if (line := _LINE.fullmatch(text)) is not None:
        return _line_of(where, there, *line.groups())
    if exact := [each for each in there if each.name == text]:
        return exact[0]
    if text.isdecimal() and (numbered := _numbered(there, int(text))):
        return numbered[0]
    for candidates in _spelt(there, text):
        if len(candidates) > 1:
            raise must_be(f"{where}: column {text!r}", f"{len(candidates)} times there", _listed(candidates))
        if candidates:
            return candidates[0]
    if lines := [each.name for each in there if each.name.partition("[")[0] == text]:
        every = lines[0].replace("0", "*", 1)
        raise must_be(f"{where}: column", text, f"{lines[0]!r} to {lines[-1]!r}, or {every!r} for all")
    names = [each.name for each in there]
    check_known(f"{where}: column", [text], names if len(names) <= SHOWN else [*names[:SHOWN], f"{len(names)} in all"])
    raise AssertionError(text)


def _listed(channels: Sequence[Channel]) -> str:
    names = [repr(each.name) for each in channels]
    return ", ".join(names[:SHOWN]) + (f" and {len(names) - SHOWN} more" if len(names) > SHOWN else "")


def refuse_column(where: str, wanted: str, why: str, others: Sequence[Channel]) -> FrictionloopError:
    """Return the error that a channel is not what is wanted, with those that may be."""
    return FrictionloopError(f"{where}: column = {wanted!r} {why}; accepted: {_listed(others) or 'a force'}")


def _numbered(channels: Sequence[Channel], number: int) -> list[Channel]:
    if any(each.number is not None for each in channels):
        return [each for each in channels if each.number == number]
    return list(channels[number : number + 1])


def _spelt(channels: Sequence[Channel], text: str) -> list[list[Channel]]:
    """Return those that are spelt so, from the strictest way to the loosest."""
    channels = [each for each in channels if not _LINE.fullmatch(each.name)]
    name, unit = _plain(text)
    groups = [each for each in channels if each.name.endswith(f"/{text}")]
    headed = [each for each in channels if (each.leaf, each.unit) == header(text)]
    loose = [
        each
        for each in channels
        if _plain(each.leaf)[0] in (name, *([text.casefold()] if "/" in text else []))
        and unit in ("", (each.unit or "").casefold())
    ]
    doubled = [each for each in channels if each.number is not None and each.name == f"{text} {each.number}"]
    return [groups, headed, doubled, loose]


def _plain(text: str) -> tuple[str, str]:
    """Return the name and the unit of a header as people copy them: in any case, with any brackets."""
    found = header(text)
    return " ".join(found.name.split()).casefold(), (found.unit or "").casefold()


def _line_of(where: str, channels: Sequence[Channel], name: str, column: str | None, row: str | None) -> Channel:
    """Return a line of an array, which the file may have the other way round."""
    shown = f"{name}[:, {column}]" if row is None else f"{name}[{row}, :]"
    lines = [each for each in channels if each.name.partition("[")[0] == name and each.name != name]
    if found := [each for each in lines if each.name == shown]:
        return found[0]
    k = int(row or column or 0)
    across = lines and (row is None) == lines[0].name.endswith(":]")
    if not across or k >= lines[0].samples.size:
        accepted = f"{lines[0].name!r} to {lines[-1].name!r}" if lines else _listed(channels)
        raise must_be(f"{where}: column", shown, accepted)
    samples = np.array([each.samples[k : k + 1][0] for each in lines])
    return replace(lines[0], name=shown, samples=samples, times=None)
