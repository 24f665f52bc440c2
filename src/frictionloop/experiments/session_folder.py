"""Sessions in folders: what is written once, what is only ever appended to and synced, and which there are."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal, Required, Self

import numpy as np
import pandas  # type: ignore[import-untyped]
import xarray as xr
from pydantic import ConfigDict, TypeAdapter, ValidationError
from typing_extensions import TypedDict

from frictionloop.experiments.protocol import Protocol, read_protocol, to_toml
from frictionloop.experiments.trial_records import (
    AMENDED,
    COLUMNS,
    RAW_FILE,
    check_of,
    line_of,
    originals,
    read_rows,
    whole_lines,
    whole_part,
    whole_row,
)
from frictionloop.findings import Finding
from frictionloop.loop.record import save
from frictionloop.parameters import System, read_toml, write_toml
from frictionloop.quantities import FrictionloopError, must_be, replacing
from frictionloop.quantities.code_version import LIBRARIES, package_version, version_of
from frictionloop.quantities.whole_files import alone, json_of, sync

TABLE, LOG, LOCK, RAW = "trials.tsv", "log.jsonl", ".lock", "raw"
ABOUT, PROTOCOL, SYSTEM = "session.json", "protocol.toml", "system.toml"
"""Names in the folder."""
GIVEN_UP = "given up"
"""Name in the log of a condition that ended because too many trials did not count."""


class Simulated(TypedDict):
    """Who answers a session by itself."""

    finger: dict[str, Any]
    seed: int


class About(TypedDict, total=False):
    """What ``session.json`` must have, and may."""

    __pydantic_config__ = ConfigDict(extra="allow")  # type: ignore[misc]
    schema: Required[Literal[2]]
    participant: Required[str]
    source: Required[str]
    address: str
    simulated: Simulated


_ABOUT = TypeAdapter(About)
EVENTS: dict[str, dict[str, Any]] = {GIVEN_UP: {"condition": str, "marked": int}}
"""Types of what is read of events in the log, by name."""


class Folder:
    """An open session; one at a time, by a lock that the system lets go of when the process dies.

    Use it in a ``with`` statement.
    """

    def __init__(self, path: Path, protocol: Protocol, system: System, about: dict[str, Any]) -> None:
        self.path, self.protocol, self.system, self.about = path, protocol, system, about
        try:
            lock = alone(path / LOCK)
        except OSError as error:
            raise FrictionloopError(f"{path}: cannot be written ({error.strerror or error})") from None
        if lock is None:
            raise FrictionloopError(f"{path}: another run goes on")
        self._lock = lock
        try:
            self.cut = _mended(path / TABLE, whole_row)
            _mended(path / LOG, _is_event)
            self._written = read_rows(path / TABLE, self.participant)
            self._table, self._log = (os.open(path / name, os.O_WRONLY | os.O_APPEND) for name in (TABLE, LOG))
        except OSError as error:
            os.close(self._lock)
            raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None
        except BaseException:
            os.close(self._lock)
            raise

    def __enter__(self) -> Self:
        """Return the folder."""
        return self

    def __exit__(self, *error: object) -> None:
        """Close the files and let go of the lock."""
        for handle in (self._table, self._log, self._lock):
            os.close(handle)

    @property
    def participant(self) -> str:
        """Code of the participant."""
        return str(self.about["participant"])

    @property
    def rows(self) -> list[Mapping[str, Any]]:
        """Rows as the method was told them."""
        return originals(self._written)

    def add(self, row: Mapping[str, Any]) -> None:
        """Append a row with its checksum, and have it on the disk."""
        whole = dict(row) | {"check": check_of(row, self._written[-1]["check"] if self._written else "")}
        _append(self._table, line_of(whole), self.path / TABLE, f"trial {row['trial']}")
        self._written.append(whole)

    def amend(self, trial: int, reason: str) -> None:
        """Append a row that takes the place of a trial's, which no longer counts; the method keeps what it was told."""
        if not reason.strip():
            raise must_be("reason", reason, "a few words")
        row = next((each for each in reversed(self._written) if each["trial"] == trial), None)
        if row is None:
            raise must_be("trial", trial, f"from 1 to {len(self.rows)}")
        self.add(dict(row) | {"valid": 0, "counted": 0, "reason": AMENDED + reason})

    def log(self, event: str, **told: Any) -> None:
        """Append what happened, or was adjusted, to the log."""
        _append(self._log, json.dumps({"event": event, **told}, allow_nan=True) + "\n", self.path / LOG, event)

    def logged(self, event: str) -> list[dict[str, Any]]:
        """Return what the log has of an event, in order."""
        return [told for told in logged(self.path) if told["event"] == event]

    def keep(self, trial: int, runs: list[xr.Dataset]) -> str:
        """Write the traces of a trial and return the name of their file; several intervals go along ``interval``.

        After the end of an interval that is shorter than another its numbers are NaN and its flags false.
        """
        name = RAW_FILE.format(trial)
        longest = max((run["time"] for run in runs), key=len)
        parts = [_padded(run.map(_short), longest) for run in runs]
        for part, run in zip(parts, runs, strict=True):
            part.attrs = dict(run.attrs)
        whole = xr.concat(parts, "interval", combine_attrs="drop_conflicts")
        whole.attrs |= {
            "schema": runs[0].attrs["schema"],
            "system": runs[0].attrs["system"],
            "trial": trial,
            "systems": json.dumps([run.attrs["system"] for run in runs]),
        }
        save(whole, self.path / name)
        return name


def new(
    path: Path, protocol: Protocol, system: System, participant: str, source: str, more: Mapping[str, Any]
) -> Folder:
    """Make the folder of a new session and open it.

    Raises
    ------
    FrictionloopError
        For a folder with something in it, or one that cannot be made.
    """
    if not participant or not participant.isalnum() or not participant.isascii():
        raise must_be("participant", participant, "letters and digits")
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise FrictionloopError(f"{path}: must be a new folder, or experiment resume")
    about = {
        "schema": 2,
        "participant": participant,
        "source": source,
        "version": package_version(),
        "python": sys.version.split()[0],
        "libraries": {name: version_of(name) for name in (*LIBRARIES, "xarray", "pydantic", "sweetspot")},
        **more,
    }
    try:
        (path / RAW).mkdir(parents=True, exist_ok=True)
        for name, text in ((TABLE, "\t".join(COLUMNS) + "\n"), (LOG, "")):
            with (path / name).open("x", encoding="utf-8") as file:
                file.write(text)
        (path / PROTOCOL).write_text(to_toml(protocol), encoding="utf-8")
        write_toml(system, path / SYSTEM)
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be written ({error.strerror or error})") from None
    # Last: a folder with this file is a session.
    with replacing(path / ABOUT) as beside:
        beside.write_text(json.dumps(about, indent=2) + "\n", encoding="utf-8")
    sync(path)
    return Folder(path, protocol, system, about)


def opened(path: Path) -> Folder:
    """Open the folder of a session that was begun.

    Raises
    ------
    FrictionloopError
        For a folder that is none, is in use, or was changed.
    """
    return Folder(path, *read_session(path))


def read_session(path: Path) -> tuple[Protocol, System, dict[str, Any]]:
    """Return protocol, system and what else is told of a session, without opening it.

    Raises
    ------
    FrictionloopError
        For a folder that is no session, or one of another schema.
    """
    try:
        about: Any = _ABOUT.validate_python(json_of(path / ABOUT), strict=True)
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, ("", *first["loc"])))
        raise FrictionloopError(f"{path / ABOUT}{where}: {first['msg']}") from None
    return read_protocol(path / PROTOCOL), read_toml(path / SYSTEM), about


def logged(path: Path) -> list[dict[str, Any]]:
    """Return the log of a session, without lines that cannot be read; the last may be half written."""
    return [json.loads(line) for line in whole_lines(path / LOG, _is_event) if _is_event(line)]


def unreadable(sessions: Sequence[Path]) -> list[Finding]:
    """Return how many lines of logs cannot be read, if any."""
    count = sum(not _is_event(line) for each in sessions for line in whole_lines(each / LOG, _is_event))
    return [Finding("STUDY-LOG", value=count)] if count else []


def _is_event(line: str) -> bool:
    try:
        told = json.loads(line)
    except (ValueError, RecursionError):
        return False
    if not isinstance(told, dict):
        return False
    kinds = {"event": str} | EVENTS.get(str(told.get("event")), {})
    return all(isinstance(told.get(name), kind) for name, kind in kinds.items())


def now() -> str:
    """Return the time for a log."""
    return time.strftime("%Y-%m-%dT%H:%M:%S%z")


def _append(handle: int, line: str, path: Path, what: str) -> None:
    """Append one line, whole or not at all, and sync it."""
    before = os.fstat(handle).st_size
    data = line.encode()
    try:
        if os.write(handle, data) != len(data):
            os.ftruncate(handle, before)
            raise OSError(28, "No space left on device")
        os.fsync(handle)
    except OSError as error:
        raise FrictionloopError(f"{path}: {what} cannot be written ({error.strerror or error})") from None


def _mended(path: Path, is_whole: Callable[[str], bool]) -> int:
    """Cut off the part of a line that a killed run has left, end a whole one, and return how many bytes were cut."""
    kept, before = whole_part(path, is_whole), path.stat().st_size
    with path.open("r+b") as file:
        file.write(kept)
        file.truncate()
    return max(before - len(kept), 0)


def _short(values: xr.DataArray) -> xr.DataArray:
    """Return numbers in four bytes, flags as they are."""
    return values.astype("float32") if values.dtype.kind == "f" else values


def _padded(run: xr.Dataset, time: xr.DataArray) -> xr.Dataset:
    """Return a run over as many rows as the longest has."""
    filled = {name: np.nan if line.dtype.kind == "f" else False for name, line in run.data_vars.items()}
    padded = run.pad(time=(0, time.size - run.sizes["time"]), constant_values=filled, keep_attrs=True)
    return padded.assign_coords(time=time)


def sessions_in(path: Path) -> list[Path]:
    """Return the folders of sessions: the folder itself, or those in it."""
    found = [path] if (path / ABOUT).is_file() else sorted(each.parent for each in path.glob(f"*/{ABOUT}"))
    if not found:
        raise FrictionloopError(f"{path}: has no session")
    return found


def once_each(sessions: Sequence[Path]) -> None:
    """Refuse two sessions of one participant: their rows could not be told apart."""
    first: dict[str, Path] = {}
    for each in sessions:
        code = str(read_session(each)[2]["participant"])
        if code in first:
            raise FrictionloopError(f"{each}: is of participant {code}, as is {first[code]}")
        first[code] = each


def read_trials(path: Path) -> pandas.DataFrame:
    """Return the trials of a session's folder, or of all sessions in a folder."""
    rows = [row for each in sessions_in(path) for row in rows_of(each)]
    return pandas.DataFrame(rows, columns=list(COLUMNS))


def rows_of(path: Path) -> list[dict[str, Any]]:
    """Return a row of each trial of a session, the last where one was amended."""
    rows = read_rows(path / TABLE, read_session(path)[2]["participant"])
    return list({row["trial"]: row for row in rows}.values())
