"""Sessions for other programs: BIDS-shaped files, a CSV as PsychoPy writes, or one HDF5."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas  # type: ignore[import-untyped]

from frictionloop.experiments import folder
from frictionloop.experiments.delivered import force_of
from frictionloop.experiments.summary import read_trials, sessions_in
from frictionloop.experiments.table import COLUMNS
from frictionloop.loop.record import load, system_of
from frictionloop.quantities import FrictionloopError, replacing

FORCES = {
    "f_r": "set-point force, N",
    "f_delivered": "delivered force, N",
    "f_m": "measured force, N",
    "load": "load, N",
}
MOTION = {"position": ("POS", "m"), "speed": ("VEL", "m/s")}


def bids(path: Path, out: Path) -> None:
    """Write sessions in the shape of BIDS 1.10: behaviour, events, forces as physiology, motion.

    Parameters
    ----------
    path : path
        A session, or a folder of sessions.
    out : path
        New folder.

    Raises
    ------
    FrictionloopError
        For a folder with something in it, or one that is no session.
    """
    _new(out)
    sessions = sessions_in(path)
    protocol = folder.read(sessions[0])[0]
    _json(out / "dataset_description.json", {"Name": protocol.title or protocol.name, "BIDSVersion": "1.10.0"})
    codes = []
    for each in sessions:
        own, _, about = folder.read(each)
        code, task = str(about["participant"]), own.name.replace("-", "")
        codes.append(code)
        _session(each, out / f"sub-{code}" / "beh", f"sub-{code}_task-{task}", read_trials(each), own.question)
    people = pandas.DataFrame({"participant_id": [f"sub-{code}" for code in codes]})
    people.to_csv(out / "participants.tsv", sep="\t", index=False)


def _session(path: Path, into: Path, stem: str, trials: pandas.DataFrame, question: str) -> None:
    into.mkdir(parents=True)
    trials.to_csv(into / f"{stem}_beh.tsv", sep="\t", index=False, na_rep="n/a")
    told = {name: {"Description": text} for name, text in COLUMNS.items()}
    _json(into / f"{stem}_beh.json", {"TaskName": stem.partition("task-")[2], "Instructions": question, **told})
    first = float(trials["onset_s"].iloc[0]) if len(trials) else 0.0
    events = pandas.DataFrame(
        {
            "onset": trials["onset_s"] - first,
            "duration": trials["offset_s"] - trials["onset_s"],
            "trial_type": trials["condition"] + "/" + trials["phase"],
            "response_time": trials["rt_s"],
            "value": trials["requested"],
        }
    )
    events.to_csv(into / f"{stem}_events.tsv", sep="\t", index=False, na_rep="n/a")
    traces = [(row.trial, path / row.raw) for row in trials.itertuples() if row.raw]
    if traces:
        rate, forces, motion = _traces(traces)
        _json(
            into / f"{stem}_physio.json",
            {
                "SamplingFrequency": rate,
                "StartTime": 0.0,
                "Columns": ["trial", "interval", *FORCES],
                **{name: {"Description": text} for name, text in FORCES.items()},
            },
        )
        forces.to_csv(
            into / f"{stem}_physio.tsv.gz", sep="\t", index=False, header=False, na_rep="n/a", compression="gzip"
        )
        tracked = f"{stem.partition('_')[0]}_{stem.partition('_')[2]}_tracksys-plate"
        motion.to_csv(into / f"{tracked}_motion.tsv", sep="\t", index=False, header=False, na_rep="n/a")
        _json(into / f"{tracked}_motion.json", {"SamplingFrequency": rate, "TrackingSystemName": "plate"})
        channels = pandas.DataFrame(
            {
                "name": list(MOTION),
                "component": "x",
                "type": [each[0] for each in MOTION.values()],
                "tracked_point": "finger",
                "units": [each[1] for each in MOTION.values()],
            }
        )
        channels.to_csv(into / f"{tracked}_channels.tsv", sep="\t", index=False)


def _traces(files: list[tuple[int, Path]]) -> tuple[float, pandas.DataFrame, pandas.DataFrame]:
    """Return the rate, the forces and the motion of all trials, one after the other."""
    forces, motion, rate = [], [], 0.0
    for trial, file in files:
        run = load(file)
        rate = float(system_of(run).controller.rate_hz)
        for interval in range(run.sizes["interval"]):
            part = run.isel(interval=interval)
            names = {"f_delivered": force_of(part)}
            data = {name: part[names.get(name, name)].values for name in FORCES if names.get(name, name) in part}
            forces.append(pandas.DataFrame({"trial": trial, "interval": interval + 1, **data}))
            motion.append(pandas.DataFrame({name: part[name].values for name in MOTION}))
    return rate, pandas.concat(forces, ignore_index=True), pandas.concat(motion, ignore_index=True)


def csv(path: Path, out: Path) -> None:
    """Write the trials of sessions as one CSV, with the columns that PsychoPy's tables begin with."""
    trials = read_trials(path)
    first = {
        "participant": trials["participant"],
        "trials.thisN": trials["trial"] - 1,
        "intensity": trials["requested"],
        "key_resp.keys": trials["response"],
        "key_resp.corr": trials["correct"],
        "key_resp.rt": trials["rt_s"],
    }
    rest = trials.drop(columns=["participant"])
    with replacing(out) as beside:
        pandas.concat([pandas.DataFrame(first), rest], axis=1).to_csv(beside, index=False)


def hdf5(path: Path, out: Path) -> None:
    """Write sessions as one HDF5: a group for each with its table, its protocol and system, and its traces."""
    with replacing(out) as beside, h5py.File(beside, "w") as file:
        for session in sessions_in(path):
            protocol, system, about = folder.read(session)
            group = file.create_group(f"sub-{about['participant']}")
            group.attrs.update(
                protocol=protocol.model_dump_json(), system=system.model_dump_json(), about=json.dumps(about)
            )
            trials = read_trials(session)
            table = group.create_group("trials")
            for name in trials:
                values = trials[name].to_numpy()
                table[name] = values.astype(h5py.string_dtype()) if values.dtype.kind in "OUT" else values
            for row in trials.itertuples():
                if row.raw:
                    run, traces = load(session / row.raw), group.create_group(f"raw/{row.trial:05d}")
                    for name in run.data_vars:
                        traces.create_dataset(str(name), data=np.asarray(run[name].values), compression="gzip")


WRITERS: Mapping[str, Callable[[Path, Path], None]] = {"bids": bids, "csv": csv, "hdf5": hdf5}
"""Exports by name; bids writes a folder, the others a file."""


def _new(out: Path) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FrictionloopError(f"out = {str(out)!r}: has something in it; name a new folder")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"out = {str(out)!r}: cannot be made ({error.strerror})") from None


def _json(path: Path, told: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")
