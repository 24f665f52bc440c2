"""Open a file of signals of any known format, with one line for whatever is wrong with it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import lru_cache
from pathlib import Path
from typing import Any

from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.containers import hdf5_contents, mat_contents, numpy_contents
from frictionloop.recordings.contents import Contents
from frictionloop.recordings.instruments import lvm_contents, tdms_contents, uff_contents
from frictionloop.recordings.text_numbers import Decimal
from frictionloop.recordings.text_tables import read_table
from frictionloop.recordings.wav import wav_contents

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
