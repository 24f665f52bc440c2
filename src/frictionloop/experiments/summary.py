"""What a study or a session found: a fit per participant and condition, of the group, and what became of each trial."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from scipy.stats import t as student

from frictionloop.experiments.fit import fit, jnd
from frictionloop.experiments.folder import ABOUT, TABLE
from frictionloop.experiments.protocol import Protocol
from frictionloop.experiments.table import COLUMNS, read_rows
from frictionloop.quantities import FrictionloopError

COVERAGE = 0.95
LEVELS = ("requested", "delivered")
"""The two levels that a function is fitted over."""


def fits(protocol: Protocol, trials: pandas.DataFrame) -> pandas.DataFrame:
    """Return one row per participant, condition and kind of level; one without a fit says why.

    Parameters
    ----------
    protocol : Protocol
        What was asked.
    trials : pandas.DataFrame
        Rows as in ``trials.tsv``.
    """
    rows = []
    guess = protocol.guess if protocol.task in ("2ifc", "2afc") and protocol.method.scores == "correct" else None
    for (participant, condition), some in trials.groupby(["participant", "condition"], sort=False):
        counted = some[(some["counted"] == 1) & np.isfinite(some["result"])]
        for over in LEVELS:
            row: dict[str, Any] = {"participant": participant, "condition": condition, "level": over}
            row |= {"trials": len(counted), "why": ""}
            try:
                found = fit(counted[over], counted["result"], guess, low=0.0 if guess == 0.5 else None)
                row |= found._asdict() | {"jnd": jnd(found, protocol.method.scores)}
            except FrictionloopError as error:
                row["why"] = str(error)
            rows.append(row)
    table = pandas.DataFrame(rows)
    for name in ("threshold", "spread", "jnd", "lapse", "guess", "dispersion"):
        if name not in table:
            table[name] = math.nan
    if protocol.stimulus.standard:
        table["weber"] = table["jnd"] / protocol.stimulus.standard
    return table


def groups(fitted: pandas.DataFrame) -> pandas.DataFrame:
    """Return mean, standard deviation and 95 % interval of the JND over participants, by condition and level."""
    rows = []
    for (condition, over), some in fitted.groupby(["condition", "level"], sort=False):
        values = some["jnd"].dropna().to_numpy()
        n = values.size
        sd = float(values.std(ddof=1)) if n > 1 else math.nan
        half = float(student.ppf(0.5 + 0.5 * COVERAGE, n - 1)) * sd / math.sqrt(n) if n > 1 else math.nan
        mean = float(values.mean()) if n else math.nan
        rows.append(
            {
                "condition": condition,
                "level": over,
                "participants": n,
                "without_fit": len(some) - n,
                "jnd_mean": mean,
                "jnd_sd": sd,
                "jnd_low": mean - half,
                "jnd_high": mean + half,
            }
        )
    return pandas.DataFrame(rows)


def funnel(trials: pandas.DataFrame) -> pandas.DataFrame:
    """Return what became of the trials of each condition: a row for every way in which one did not count."""
    rows = []
    for condition, some in trials.groupby("condition", sort=False):
        rows.append((condition, "presented", len(some)))
        rows += [(condition, phase, int((some["phase"] == phase).sum())) for phase in ("practice", "catch")]
        main = some[some["phase"] == "main"]
        bad = main[main["valid"] == 0]
        kinds = bad["reason"].str.replace(r"=[^ ;]*", "", regex=True).str.replace(r" in \d", "", regex=True)
        kinds = kinds.str.split("; ").map(lambda parts: "; ".join(dict.fromkeys(parts)))
        for again, what in ((1, "repeated"), (0, "kept with a mark")):
            counts = kinds[bad["again"] == again].value_counts()
            rows += [(condition, f"{what}: {reason}", int(n)) for reason, n in counts.items()]
        rows.append((condition, "counted", int(main["counted"].sum())))
    return pandas.DataFrame(rows, columns=["condition", "what", "trials"])


def sessions_in(path: Path) -> list[Path]:
    """Return the folders of sessions: the folder itself, or those in it.

    Raises
    ------
    FrictionloopError
        If there is none.
    """
    found = [path] if (path / ABOUT).is_file() else sorted(each.parent for each in path.glob(f"*/{ABOUT}"))
    if not found:
        raise FrictionloopError(f"{path}: is no session, and has none in it")
    return found


def read_trials(path: Path) -> pandas.DataFrame:
    """Return the trials of a session's folder, or of all sessions in a folder."""
    rows = [row for each in sessions_in(path) for row in read_rows(each / TABLE)]
    return pandas.DataFrame(rows, columns=list(COLUMNS))
