"""Open a file of signals of any known format, with one line for whatever is wrong with it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.containers import hdf5_contents, mat_contents, npz_contents, wav_contents
from frictionloop.recordings.contents import Contents
from frictionloop.recordings.recorders import RECORDERS
from frictionloop.recordings.text_tables import read_table

READERS: Mapping[str, Callable[[Path], Contents]] = {
    **dict.fromkeys((".csv", ".tsv", ".txt", ".dat", ".asc"), read_table),
    **dict.fromkeys((".h5", ".hdf5", ".nc"), hdf5_contents),
    ".mat": mat_contents,
    ".npz": npz_contents,
    ".wav": wav_contents,
    **RECORDERS,
}


def read_contents(path: str | os.PathLike[str]) -> Contents:
    """Return everything that a file of signals holds.

    Parameters
    ----------
    path : path
        ``.csv .tsv .txt .dat .asc``, ``.h5 .hdf5 .nc``, ``.mat`` (5 and 7.3), ``.npz``, ``.wav``, ``.lvm``, ``.tdms``,
        ``.uff .unv``. The last four need the extra ``identify``.

    Raises
    ------
    FrictionloopError
        In one line: the file is missing, empty, damaged, of an unknown format, or holds no numbers.
    """
    file = Path(path)
    reader = READERS.get(file.suffix.lower())
    if file.is_dir():
        raise FrictionloopError(f"{file}: is a folder; accepted is a file: {' '.join(READERS)}")
    if reader is None:
        raise FrictionloopError(f"{file}: format {file.suffix!r} is unknown; accepted: {' '.join(READERS)}")
    if not file.is_file():
        raise FrictionloopError(f"{file}: there is no such file")
    if not file.stat().st_size:
        raise FrictionloopError(f"{file}: is empty; accepted: {' '.join(READERS)}")
    try:
        found = reader(file)
    except FrictionloopError:
        raise
    except Exception as error:  # on a damaged file the libraries raise anything
        reason = (getattr(error, "strerror", None) or str(error) or type(error).__name__).splitlines()[0]
        raise FrictionloopError(f"{file}: damaged or encrypted ({reason:.120})") from None
    if not found.channels:
        told = "".join(f" ({each})" for each in found.findings)
        raise FrictionloopError(f"{file}: holds no numbers{told}; accepted: two samples or more")
    saved = datetime.fromtimestamp(file.stat().st_mtime, UTC).date().isoformat()
    return replace(found, date=found.date or f"not told, the file is of {saved}")
