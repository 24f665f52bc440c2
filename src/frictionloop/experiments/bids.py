"""Sessions in the shape of BIDS 1.10: behaviour, events, forces as physiology, motion; checked by its validator."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
import xarray as xr

from frictionloop.experiments import folder
from frictionloop.experiments.delivered import force_of
from frictionloop.experiments.kept_sessions import once_each, read_trials, sessions_in
from frictionloop.experiments.table import COLUMNS
from frictionloop.loop.record import load, system_of
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.version import package_version

FORCES = {
    "time": "time since the first onset, s",
    "trial": "number of the trial",
    "interval": "number of the stroke",
    "f_r": "set-point force, N",
    "f_delivered": "delivered force, N",
    "f_m": "measured force, N",
    "load": "load, N",
}
"""Columns of the physiology."""
MOTION = {"latency": ("LATENCY", "n/a", "s"), "position": ("POS", "x", "m"), "speed": ("VEL", "x", "m/s")}
"""Columns of the motion, with BIDS's type, component and unit; the time is since the first onset."""
EVENTS = {
    "onset": "start, device clock, s",
    "duration": "until the last stroke ends",
    "trial_type": "condition and phase",
    "response_time": "from the last stroke, s",
    "value": "level asked for",
}
GZIP = {"method": "gzip", "mtime": 0}
"""Without the time of writing: the same session gives the same bytes."""
README = """Sessions of the experiment {name}, written by frictionloop.

Strokes stand one after the other in physiology and motion; times are of the device's clock.
"""


def bids(path: Path, out: Path) -> None:
    """Write sessions in the shape of BIDS 1.10.

    Parameters
    ----------
    path : path
        A session, or a folder of sessions.
    out : path
        New folder.

    Raises
    ------
    FrictionloopError
        For a folder with something in it, one that is no session, or two sessions of one participant.
    """
    sessions = sessions_in(path)
    once_each(sessions)
    _new(out)
    protocol = folder.read_session(sessions[0])[0]
    made = {"Name": "frictionloop", "Version": package_version()}
    about = {"Name": protocol.title or protocol.name, "BIDSVersion": "1.10.0", "DatasetType": "raw"}
    _json(out / "dataset_description.json", {**about, "GeneratedBy": [made]})
    (out / "README").write_text(README.format(name=protocol.name), encoding="utf-8")
    codes = []
    for each in sessions:
        own, _, told = folder.read_session(each)
        codes.append(str(told["participant"]))
        _session(each, out / f"sub-{codes[-1]}", f"sub-{codes[-1]}_task-{own.name.replace('-', '')}", own.question)
    people = pandas.DataFrame({"participant_id": [f"sub-{code}" for code in codes]})
    people.to_csv(out / "participants.tsv", sep="\t", index=False)


def _session(path: Path, into: Path, stem: str, question: str) -> None:
    trials = read_trials(path)
    beh, motion = into / "beh", into / "motion"
    beh.mkdir(parents=True)
    task = {"TaskName": stem.partition("task-")[2], "Instructions": question}
    trials.to_csv(beh / f"{stem}_beh.tsv", sep="\t", index=False, na_rep="n/a")
    _json(beh / f"{stem}_beh.json", {**task, **_described(COLUMNS)})
    first_s = float(trials["onset_s"].iloc[0]) if len(trials) else 0.0
    events = pandas.DataFrame(
        {
            "onset": trials["onset_s"] - first_s,
            "duration": trials["offset_s"] - trials["onset_s"],
            "trial_type": trials["condition"] + "/" + trials["phase"],
            "response_time": trials["rt_s"],
            "value": trials["requested"],
        }
    )
    events.to_csv(beh / f"{stem}_events.tsv", sep="\t", index=False, na_rep="n/a")
    _json(beh / f"{stem}_events.json", {**task, **_described(EVENTS)})
    if not (trials["raw"] != "").any():
        return
    rate, forces, moved = _traces(path, trials, first_s)
    told = {"SamplingFrequency": rate, "StartTime": 0.0, "Columns": list(forces)}
    _json(beh / f"{stem}_physio.json", {**told, **_described({name: FORCES[name] for name in forces})})
    forces.to_csv(beh / f"{stem}_physio.tsv.gz", sep="\t", index=False, header=False, na_rep="n/a", compression=GZIP)
    motion.mkdir()
    stem = f"{stem}_tracksys-plate"
    moved.to_csv(motion / f"{stem}_motion.tsv", sep="\t", index=False, header=False, na_rep="n/a")
    counts = {f"{kind}ChannelCount": 1 for kind in ("LATENCY", "POS", "VEL")}
    told = {"SamplingFrequency": rate, "TrackingSystemName": "plate", "TrackedPointsCount": 1, "MotionChannelCount": 3}
    _json(motion / f"{stem}_motion.json", {**task, **told, **counts})
    channels = pandas.DataFrame(
        [(name, component, kind, "finger", unit) for name, (kind, component, unit) in MOTION.items()],
        columns=["name", "component", "type", "tracked_point", "units"],
    )
    channels.to_csv(motion / f"{stem}_channels.tsv", sep="\t", index=False)


def _traces(path: Path, trials: pandas.DataFrame, first_s: float) -> tuple[float, pandas.DataFrame, pandas.DataFrame]:
    """Return the rate, the forces and the motion of all strokes, one after the other."""
    forces, motion, rate = [], [], 0.0
    for row in trials.itertuples():
        if not row.raw:
            continue
        run = load(path / row.raw)
        rate = float(system_of(run).controller.rate_hz)
        for interval in range(run.sizes["interval"]):
            part = _there(run.isel(interval=interval))
            # The first stroke begins with the trial, the last one ends with it.
            start_s = row.onset_s if interval == 0 else row.offset_s - part.sizes["time"] / rate
            time = start_s - first_s + np.arange(part.sizes["time"]) / rate
            data = {"f_r": part["f_r"], "f_delivered": part[force_of(part)], "f_m": part["f_m"], "load": part["load"]}
            values = {name: line.values for name, line in data.items()}
            forces.append(pandas.DataFrame({"time": time, "trial": row.trial, "interval": interval + 1, **values}))
            motion.append(
                pandas.DataFrame({"latency": time, **{name: part[name].values for name in ("position", "speed")}})
            )
    return rate, pandas.concat(forces, ignore_index=True), pandas.concat(motion, ignore_index=True)


def _there(run: xr.Dataset) -> xr.Dataset:
    """Return a stroke without the rows by which it was made as long as another."""
    known = np.flatnonzero(np.isfinite(run["f_r"].values))
    return run.isel(time=slice(0, int(known[-1]) + 1 if known.size else 0))


def _described(columns: Mapping[str, str]) -> dict[str, dict[str, str]]:
    return {name: {"Description": text} for name, text in columns.items()}


def _new(out: Path) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FrictionloopError(f"out = {str(out)!r}: must be a new folder")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"out = {str(out)!r}: cannot be made ({error.strerror})") from None


def _json(path: Path, told: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
