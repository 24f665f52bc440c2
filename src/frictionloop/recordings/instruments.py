"""Whole files of recorders: LabVIEW's LVM and TDMS, and UFF of dataset 58."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed
from frictionloop.quantities.units import known_unit
from frictionloop.recordings.contents import Channel, Contents, left_out
from frictionloop.recordings.stored import is_large
from frictionloop.recordings.stored_lines import tdms_line

EXTRA = "identify"


def lvm_contents(path: Path) -> Contents:
    """Return the channels of the first segment of a LabVIEW measurement file, and its times if it has them."""
    lvm = needed("lvm_read", "lvm-read", EXTRA).read(str(path), read_from_pickle=False, dump_file=False)
    segment = lvm[0]
    names = [str(name).strip() for name in segment["Channel names"]]
    units = [str(unit).strip() for unit in segment.get("Y_Unit_Label", [])]
    values = np.asarray(segment["data"], dtype=float)
    timed = bool(names) and names[0] == "X_Value"
    channels = []
    for k, name in enumerate(names[: values.shape[1]]):
        if np.all(np.isnan(values[:, k])):
            continue
        unit = units[k - timed] if 0 <= k - timed < len(units) else None
        channels.append(
            Channel("time", values[:, k], "s") if timed and k == 0 else Channel(name, values[:, k], _unit(unit))
        )
    steps = [step for step in segment.get("Delta_X", []) if np.isfinite(step) and step > 0]
    rates = {"'Delta_X'": 1.0 / float(steps[0])} if steps else {}
    more = lvm["Segments"] - 1
    found = (left_out(f"{more} more segments", "the first is read"),) if more else ()
    return Contents(tuple(channels), rates, found, f"{lvm.get('Date', '')} {lvm.get('Time', '')}".strip())


def tdms_contents(path: Path) -> Contents:
    """Return the channels of a TDMS file as group/channel."""
    nptdms = needed("nptdms", "npTDMS (LGPL)", EXTRA)
    channels, rates, date = [], {}, ""
    with nptdms.TdmsFile.open(path) as file:
        for group in file.groups():
            for each in group.channels():
                if each.dtype is None or np.dtype(each.dtype).kind not in "iufb" or len(each) < 2:
                    continue
                name = each.name if len(file.groups()) == 1 else f"{group.name}/{each.name}"
                large = is_large(path, len(each), np.dtype(each.dtype).itemsize)
                samples = tdms_line(path, group.name, each.name, len(each), each.dtype) if large else each[:]
                channels.append(Channel(name, samples, _unit(each.properties.get("unit_string"))))
                if (step := float(each.properties.get("wf_increment", 0.0) or 0.0)) > 0:
                    rates[f"'wf_increment' of {each.name!r}"] = 1.0 / step
                date = date or str(each.properties.get("wf_start_time", ""))
    return Contents(tuple(channels), rates, date=date)


def uff_contents(path: Path) -> Contents:
    """Return the datasets 58 of a universal file: records in time, and frequency responses as complex channels."""
    sets: Any = needed("pyuff", "pyuff", EXTRA).UFF(str(path)).read_sets()
    sets = [each for each in (sets if isinstance(sets, list) else [sets]) if each.get("type") == 58]
    if not sets:
        raise FrictionloopError(f"{path}: has no dataset 58")
    channels, rates, taken = [], {}, set()
    for k, each in enumerate(sets):
        name = str(each.get("id1", "")).strip()
        name = name if name and name.lower() != "none" and name not in taken else f"{name} {k}".strip()
        taken.add(name)
        channels.append(Channel(name, np.asarray(each["data"]), _unit(each.get("ordinate_axis_units_lab"))))
        step = float(each.get("abscissa_inc", 0.0) or 0.0)
        if int(each.get("func_type", 1)) in (0, 1) and step > 0:
            rates[f"'abscissa_inc' of {name!r}"] = 1.0 / step
        elif k == 0:
            channels.insert(0, Channel("frequency", np.asarray(each["x"], dtype=float), "Hz"))
    return Contents(tuple(channels), rates, date=str(sets[0].get("id3", "")).strip())


def _unit(said: Any) -> str | None:
    text = str(said or "").strip()
    return None if text.lower() in ("", "none") else known_unit(text) or text
