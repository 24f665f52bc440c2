"""Open a file of signals of any known format, LVM, TDMS and UFF of recorders among them; one line for what is wrong."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache, partial
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.containers import hdf5_contents, mat_contents, numpy_contents, with_times
from frictionloop.recordings.contents import Channel, Contents, Samples, Stored, is_large, left_out, told_rates
from frictionloop.recordings.text_numbers import Decimal, iso_date
from frictionloop.recordings.text_tables import read_table
from frictionloop.recordings.wav import wav_contents

EXTRA = "identify"


def lvm_contents(path: Path) -> Contents:
    """Return the channels of the first segment of a LabVIEW measurement file, and its times if it has them."""
    lvm = needed("lvm_read", "lvm-read", EXTRA).read(str(path), read_from_pickle=False, dump_file=False)
    segment = lvm[0]
    names = [str(name).strip() for name in segment["Channel names"]]
    values = np.asarray(segment["data"], dtype=float)
    timed = bool(names) and names[0] == "X_Value"
    channels = [Channel("time", values[:, 0], "s")] if timed and not np.all(np.isnan(values[:, 0])) else []
    told = zip_longest(segment.get("Y_Unit_Label", []), segment.get("Delta_X", []), names[timed:])
    for (unit, step, name), column in zip(told, values.T[timed:], strict=False):
        if name is not None and not np.all(np.isnan(column)):
            channels.append(Channel(name, column, _unit(unit), rates_hz=told_rates([("Delta_X", step)])))
    more = lvm["Segments"] - 1
    found = (left_out(f"{more} more segments", "the first is read"),) if more else ()
    return Contents(tuple(with_times(channels)), found, iso_date(f"{lvm.get('Date', '')} {lvm.get('Time', '')}"))


def tdms_contents(path: Path) -> Contents:
    """Return the channels of a TDMS file as group/channel."""
    nptdms = needed("nptdms", "npTDMS (LGPL)", EXTRA)
    channels, date = [], ""
    with nptdms.TdmsFile.open(path) as file:
        for each in (each for group in file.groups() for each in group.channels()):
            kind = "" if each.dtype is None else np.dtype(each.dtype).kind
            if kind in tuple("iufbM") and len(each) > 1:
                said = each.properties
                name = f"{each.group_name}/{each.name}"
                rates = told_rates([("wf_increment", said.get("wf_increment"))])
                unit = "s" if kind == "M" else _unit(said.get("unit_string"))
                channels.append(Channel(name, _tdms_samples(path, each), unit, rates_hz=rates, is_clock=kind == "M"))
                date = date or iso_date(str(said.get("wf_start_time", "")))
    return Contents(tuple(with_times(channels)), date=date)


def _tdms_samples(path: Path, channel: Any) -> Samples:
    dtype = np.dtype(channel.dtype)
    if dtype.kind == "M":
        return np.asarray((channel[:] - channel[0]) / np.timedelta64(1, "s"), dtype=float)
    if not is_large(path, len(channel), dtype.itemsize):
        return np.asarray(channel[:])
    return Stored(len(channel), dtype, partial(_tdms_rows, path, channel.group_name, channel.name))


def _tdms_rows(path: Path, group: str, channel: str, first: int, stop: int) -> NDArray[Any]:
    with needed("nptdms", "npTDMS (LGPL)", EXTRA).TdmsFile.open(path) as file:
        return np.asarray(file[group][channel].read_data(first, stop - first))


def uff_contents(path: Path) -> Contents:
    """Return the datasets 58 of a universal file: records in time, and frequency responses as complex channels."""
    sets: Any = needed("pyuff", "pyuff", EXTRA).UFF(str(path)).read_sets()
    sets = [each for each in (sets if isinstance(sets, list) else [sets]) if each.get("type") == 58]
    if not sets:
        raise FrictionloopError(f"{path}: has no dataset 58")
    channels, taken = [], set()
    for k, each in enumerate(sets):
        name = str(each.get("id1", "")).strip()
        name = name if name and name.lower() != "none" and name not in taken else f"{name} {k}".strip()
        taken.add(name)
        over_time = int(each.get("func_type", 1)) in (0, 1)
        rates = told_rates([("abscissa_inc", each.get("abscissa_inc"))]) if over_time else {}
        unit = _unit(each.get("ordinate_axis_units_lab"))
        channels.append(Channel(name, np.asarray(each["data"]), unit, rates_hz=rates))
        if not rates and k == 0:
            channels.insert(0, Channel("frequency", np.asarray(each["x"], dtype=float), "Hz"))
    return Contents(tuple(channels), date=iso_date(str(sets[0].get("id3", ""))))


def _unit(said: Any) -> str | None:
    text = str(said or "").strip()
    return None if text.lower() in ("", "none") else known_unit(text) or text


TEXTS = (".csv", ".tsv", ".txt", ".dat", ".asc")
READERS: Mapping[str, Callable[..., Contents]] = {
    **dict.fromkeys(TEXTS, read_table),
    **dict.fromkeys((".h5", ".hdf5", ".nc"), hdf5_contents),
    ".mat": mat_contents,
    **dict.fromkeys((".npy", ".npz"), numpy_contents),
    ".wav": wav_contents,
    ".lvm": lvm_contents,
    ".tdms": tdms_contents,
    **dict.fromkeys((".uff", ".unv"), uff_contents),
}
_WORKBOOKS = (".xlsx", ".xls", ".ods")


def read_contents(path: str | os.PathLike[str], decimal: Decimal | None = None) -> Contents:
    """Return everything that a file of signals holds.

    Parameters
    ----------
    path : path
        ``.csv .tsv .txt .dat .asc``, ``.h5 .hdf5 .nc``, ``.mat`` (5 and 7.3), ``.npy .npz``, ``.wav``, ``.lvm``,
        ``.tdms``, ``.uff .unv``. The last four need the extra ``identify``.
    decimal : str, optional
        Decimal mark of a text, "." or ","; found if not given.

    Raises
    ------
    FrictionloopError
        In one line: the file is missing, empty, damaged, of an unknown format, or holds no numbers.
    """
    file, ending = Path(path), Path(path).suffix.lower()
    if file.is_dir():
        raise FrictionloopError(f"{file}: is a folder; accepted is a file: {' '.join(READERS)}")
    if ending not in READERS:
        way = "; a workbook: save its sheet as .csv" if ending in _WORKBOOKS else ""
        raise FrictionloopError(f"{file}: format {file.suffix!r} is unknown; accepted: {' '.join(READERS)}{way}")
    if not file.is_file():
        raise FrictionloopError(f"{file}: there is no such file")
    there = file.stat()
    if not there.st_size:
        raise FrictionloopError(f"{file}: is empty; accepted: two samples or more")
    found = _read(str(file), Path.cwd(), there.st_mtime_ns, there.st_size, decimal)
    if not any(each.samples.size for each in found.channels):
        told = "".join(f" ({each})" for each in found.findings)
        raise FrictionloopError(f"{file}: holds no numbers{told}; accepted: two samples or more")
    saved = datetime.fromtimestamp(there.st_mtime, UTC).date().isoformat()
    return replace(found, date=found.date or saved, dated=bool(found.date))


@lru_cache(2)
def _read(path: str, _at: Path, _changed: int, _size: int, decimal: Decimal | None) -> Contents:
    """Return what a file holds; the last two stay in memory, so that a run reads its two signals once."""
    file = Path(path)
    options: dict[str, Any] = {"decimal": decimal} if file.suffix.lower() in TEXTS else {}
    try:
        return READERS[file.suffix.lower()](file, **options)
    except FrictionloopError:
        raise
    except Exception as error:  # on a damaged file the libraries raise anything
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).splitlines()[0]
        raise FrictionloopError(f"{path}: damaged or encrypted ({reason:.120})") from None
