"""Sessions for other programs: one CSV as PsychoPy writes, one HDF5, or BIDS (`bids`)."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import h5py
import numpy as np
import pandas  # type: ignore[import-untyped]

from frictionloop.experiments import folder
from frictionloop.experiments.bids import bids
from frictionloop.experiments.kept_sessions import once_each, read_trials, sessions_in
from frictionloop.findings import Result
from frictionloop.loop.record import load
from frictionloop.quantities import check_known, replacing


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
            protocol, system, about = folder.read_session(session)
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


@dataclass(frozen=True, kw_only=True)
class Exported(Result):
    """Sessions that were written for other programs."""

    SCHEMA: ClassVar[str] = "experiments.export/1"
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
