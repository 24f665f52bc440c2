"""Sessions as they lie in folders: which there are, and the rows of their trials."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pandas  # type: ignore[import-untyped]

from frictionloop.experiments.folder import ABOUT, TABLE, read_session
from frictionloop.experiments.table import COLUMNS, read_rows
from frictionloop.quantities import FrictionloopError


def sessions_in(path: Path) -> list[Path]:
    """Return the folders of sessions: the folder itself, or those in it.

    Raises
    ------
    FrictionloopError
        If there is none.
    """
    found = [path] if (path / ABOUT).is_file() else sorted(each.parent for each in path.glob(f"*/{ABOUT}"))
    if not found:
        raise FrictionloopError(f"{path}: has no session")
    return found


def once_each(sessions: Sequence[Path]) -> None:
    """Refuse two sessions of one participant: their rows could not be told apart.

    Raises
    ------
    FrictionloopError
        Naming both folders.
    """
    first: dict[str, Path] = {}
    for each in sessions:
        code = str(read_session(each)[2]["participant"])
        if code in first:
            raise FrictionloopError(f"{each}: is of participant {code}, as is {first[code]}")
        first[code] = each


def read_trials(path: Path) -> pandas.DataFrame:
    """Return the trials of a session's folder, or of all sessions in a folder."""
    rows = [row for each in sessions_in(path) for row in read_rows(each / TABLE)]
    return pandas.DataFrame(rows, columns=list(COLUMNS))
