"""Files of recorders: LabVIEW's LVM and TDMS, and UFF of dataset 58."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.containers import with_times
from frictionloop.recordings.contents import Channel, Contents, left_out, told_rates
from frictionloop.recordings.dates import iso_date
from frictionloop.recordings.stored import Samples, Stored, is_large

EXTRA = "identify"


def lvm_contents(path: Path) -> Contents:
    """Return the channels of the first segment of a LabVIEW measurement file, and its times if it has them."""
    lvm = needed("lvm_read", "lvm-read", EXTRA).read(str(path), read_from_pickle=False, dump_file=False)
    segment = lvm[0]
    names = [str(name).strip() for name in segment["Channel names"]]
    values = np.asarray(segment["data"], dtype=float)
    timed = bool(names) and names[0] == "X_Value"
    channels = [Channel("time", values[:, 0], "s")] if timed and not np.all(np.isnan(values[:, 0])) else []
    units, steps = (_of_each(segment, name, names) for name in ("Y_Unit_Label", "Delta_X"))
    for k, (unit, step) in enumerate(zip(units, steps, strict=True)):
        at = k + timed
        if at < min(len(names), values.shape[1]) and not np.all(np.isnan(values[:, at])):
            channels.append(Channel(names[at], values[:, at], _unit(unit), rates_hz=told_rates([("Delta_X", step)])))
    more = lvm["Segments"] - 1
    found = (left_out(f"{more} more segments", "the first is read"),) if more else ()
    return Contents(tuple(with_times(channels)), found, iso_date(f"{lvm.get('Date', '')} {lvm.get('Time', '')}"))


def _of_each(segment: Any, name: str, names: list[str]) -> list[Any]:
    """Return what the head of a segment says of each channel."""
    return [*segment.get(name, []), *[None] * len(names)][: len(names)]


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
