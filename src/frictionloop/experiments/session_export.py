"""Sessions for other programs: one CSV as PsychoPy writes, one HDF5, or BIDS 1.10, checked by its validator."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pandas  # type: ignore[import-untyped]
import xarray as xr

from frictionloop.experiments import session_folder
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.session_folder import once_each, read_trials, sessions_in
from frictionloop.experiments.trial_records import COLUMNS, force_of
from frictionloop.findings import Result
from frictionloop.loop.record import load, system_of
from frictionloop.quantities import FrictionloopError, check_known, must_be, replacing
from frictionloop.quantities.code_version import package_version
from frictionloop.quantities.units import known_unit

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
LEVELS = ("requested", "delivered", "value")
"""Columns that have the unit of the level."""
GZIP = {"method": "gzip", "mtime": 0}
"""Without the time of writing: the same session gives the same bytes."""
README = "Sessions of the experiment {name}, written by frictionloop. Times are of the device's clock.\n"
TRACES = "Strokes stand one after the other in *_physio.tsv.gz and *_motion.tsv.\n"


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
    protocol = session_folder.read_session(sessions[0])[0]
    made = {"Name": "frictionloop", "Version": package_version()}
    about = {"Name": protocol.title or protocol.name, "BIDSVersion": "1.10.0", "DatasetType": "raw"}
    _json(out / "dataset_description.json", {**about, "GeneratedBy": [made]})
    codes = []
    for each in sessions:
        own, _, told = session_folder.read_session(each)
        codes.append(str(told["participant"]))
        _session(each, out / f"sub-{codes[-1]}", f"sub-{codes[-1]}_task-{own.name.replace('-', '')}", own)
    traces = TRACES if any(out.glob("*/motion")) else ""
    (out / "README").write_text(README.format(name=protocol.name) + traces, encoding="utf-8")
    people = pandas.DataFrame({"participant_id": [f"sub-{code}" for code in codes]})
    people.to_csv(out / "participants.tsv", sep="\t", index=False)


def _session(path: Path, into: Path, stem: str, protocol: Protocol) -> None:
    trials, unit = read_trials(path), protocol.level_unit
    beh, motion = into / "beh", into / "motion"
    beh.mkdir(parents=True)
    task = {"TaskName": stem.partition("task-")[2], "Instructions": protocol.question}
    trials.to_csv(beh / f"{stem}_beh.tsv", sep="\t", index=False, na_rep="n/a")
    _json(beh / f"{stem}_beh.json", {**task, **_described(COLUMNS, unit)})
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
    _json(beh / f"{stem}_events.json", {**task, **_described(EVENTS, unit)})
    if trials.empty:
        return
    rate, forces, moved = _traces(path, trials, first_s)
    told = {"SamplingFrequency": rate, "StartTime": 0.0, "Columns": list(forces)}
    _json(beh / f"{stem}_physio.json", {**told, **_described({name: FORCES[name] for name in forces}, unit)})
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


def _described(columns: Mapping[str, str], level_unit: str) -> dict[str, dict[str, str]]:
    """Return descriptions of columns, a unit at their end by itself; a level has the protocol's."""
    found = {}
    for name, text in columns.items():
        said, _, unit = text.rpartition(", ")
        if name in LEVELS:
            said, unit = text, level_unit
        known = bool(said) and (name in LEVELS or known_unit(unit) is not None)
        found[name] = {"Description": said, "Units": unit} if known else {"Description": text}
    return found


def _new(out: Path) -> None:
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise must_be("out", str(out), "a new folder")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{out}: cannot be made ({error.strerror})") from None


def _json(path: Path, told: Mapping[str, Any]) -> None:
    path.write_text(json.dumps(told, indent=2) + "\n", encoding="utf-8")


def csv(path: Path, out: Path) -> None:
    """Write the trials of sessions as one CSV, with the columns that PsychoPy's tables begin with."""
    once_each(sessions_in(path))
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
    once_each(sessions_in(path))
    with replacing(out) as beside, h5py.File(beside, "w") as file:
        for session in sessions_in(path):
            protocol, system, about = session_folder.read_session(session)
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
                run, traces = load(session / row.raw), group.create_group(f"raw/{row.trial:05d}")
                for name in run.data_vars:
                    traces.create_dataset(str(name), data=np.asarray(run[name].values), compression="gzip")


WRITERS: Mapping[str, Callable[[Path, Path], None]] = {"bids": bids, "csv": csv, "hdf5": hdf5}
"""Exports by name; bids writes a folder, the others a file."""


class Exported(Result, schema="experiments.export/1"):
    """Sessions that were written for other programs."""

    sessions: tuple[Path, ...]
    out: Path
    form: str

    def rows(self) -> list[tuple[str, str]]:
        """Return how many sessions, and where they are."""
        return [(self.form, f"{len(self.sessions)} session{'s' * (len(self.sessions) > 1)} in {self.out}")]


def export(path: str | os.PathLike[str], out: str | os.PathLike[str], form: str = "bids") -> Exported:
    """Write sessions for other programs.

    Parameters
    ----------
    path
        A session, or a folder of sessions.
    out
        New folder of bids, or file of another form.
    form
        bids: a folder in the shape of BIDS; csv: one table, as PsychoPy writes; hdf5: one file with all traces.

    Raises
    ------
    FrictionloopError
        For another form, a folder without sessions, or what cannot be written.
    """
    check_known("form", [form], WRITERS)
    WRITERS[form](Path(path), Path(out))
    return Exported(sessions=tuple(sessions_in(Path(path))), out=Path(out), form=form)
