"""The table of trials: its columns, what a row says, and reading it back."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from frictionloop.experiments.delivered import Measures
from frictionloop.experiments.protocol import Protocol
from frictionloop.quantities import FrictionloopError

MEASURED = {
    "force_mean_n": "mean delivered force, N",
    "force_sd_n": "standard deviation of it, N",
    "rms_error_n": "rms error of the force, N",
    "felt_index": "index D of the error",
    "saturated_share": "share of clamped periods",
    "speed_mm_s": "mean speed, mm/s",
    "load_n": "mean load, N",
    "contact_share": "share that is scored",
    "lost_samples": "samples that were lost",
}
"""What is measured of each interval; columns end with _1 and _2."""
COLUMNS = {
    "trial": "number from 1",
    "participant": "code",
    "block": "number from 1",
    "condition": "name of the condition",
    "phase": "practice, main or catch",
    "track": "name of the interleaved track",
    "comparison": "interval with the comparison",
    "requested": "level asked for",
    "delivered": "level delivered, same unit",
    "onset_s": "first stroke begins, s",
    "offset_s": "last stroke ends, s",
    **{f"{name}_{k}": f"{text}, interval {k}" for k in (1, 2) for name, text in MEASURED.items()},
    "response": "answer",
    "correct": "1, 0 or none",
    "result": "result for the method",
    "rt_s": "response time from offset_s, s",
    "rt_uncertainty_s": "standard deviation of rt_s, s",
    "valid": "1 if strokes and answer count",
    "reason": "why not, and interval",
    "counted": "1 if the method knows",
    "again": "1 if repeated",
    "repeat_of": "trial that it repeats, 0",
    "method_state": "state before the trial",
    "raw": "file with the traces",
}
"""Columns of ``trials.tsv`` and what they mean."""
NUMBERS = {"magnitude": (0.0, math.inf, "above 0"), "tracking": (0.0, 100.0, "from 0 to 100")}
"""Answers that are numbers, by task: ends, and how they are told; 0 is no magnitude."""
WHOLE = ("trial", "block", "comparison", "valid", "counted", "again", "repeat_of")
TEXT = ("participant", "condition", "phase", "track", "response", "reason", "method_state", "raw")


def scored(protocol: Protocol, level: float, comparison: int, response: str) -> tuple[float, float]:
    """Return whether an answer was right (NaN where none is) and what the method is told of it.

    Raises
    ------
    FrictionloopError
        For an answer that the task does not have.
    """
    task, choices = protocol.task, protocol.choices
    if not choices:
        return math.nan, number_of(task, response)
    if response not in choices:
        raise FrictionloopError(f"answer = {response!r}: accepted: {', '.join(choices)}")
    place = choices.index(response)
    if task in ("2ifc", "2afc"):
        chosen = place == comparison - 1
        right = math.nan if level == 0 else float(chosen == (level > 0))
        return right, float(chosen) if protocol.method.scores == "comparison" or level == 0 else right
    if task == "yes_no":
        return float((place == 0) == (level > 0)), float(place == 0)
    if task == "same_different":
        return float((place == 1) == (level != 0)), float(place == 1)
    return math.nan, (-1.0, 1.0, 0.0)[place]


def number_of(task: str, response: str) -> float:
    """Return an answer that is a number.

    Raises
    ------
    FrictionloopError
        For what is none, or one that the task does not have: a magnitude is above 0, a place on the scale 0 to 100.
    """
    low, high, said = NUMBERS[task]
    try:
        value = float(response)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and low <= value <= high) or (task == "magnitude" and value == 0.0):
        raise FrictionloopError(f"answer = {response!r}: must be a number {said}")
    return value


def delivered_level(protocol: Protocol, level: float, comparison: int, found: Sequence[Measures]) -> float:
    """Return the level that was delivered: of two intervals the difference, so that a common error drops out."""
    stimulus = protocol.stimulus
    if len(found) == 1:
        return found[0].level - (stimulus.standard or 0.0) if stimulus.adds else found[0].level
    apart = found[comparison - 1].level - found[2 - comparison].level
    return apart if stimulus.adds else apart + stimulus.value(None)


def line_of(row: Mapping[str, Any]) -> str:
    """Return a row as a line of the table; numbers so that they are read back as they were."""
    return "\t".join(_text(row.get(name)) for name in COLUMNS) + "\n"


def header() -> str:
    """Return the first line of the table."""
    return "\t".join(COLUMNS) + "\n"


def read_rows(path: Path) -> list[dict[str, Any]]:
    """Return the rows of a table, numbers as numbers and NaN where nothing stands.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or a row that does not fit the header, naming the trial.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None
    if not rows or rows[0] != list(COLUMNS):
        raise FrictionloopError(f"{path}: is no table of trials")
    found = []
    for number, cells in enumerate(rows[1:], 1):
        if len(cells) != len(COLUMNS):
            raise FrictionloopError(f"{path}: trial {number}: must have {len(COLUMNS)} columns")
        found.append({name: _value(path, number, name, cell) for name, cell in zip(COLUMNS, cells, strict=True)})
    return found


def _text(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "n/a"
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    return " ".join(str(value).split()) or "n/a"


def _value(path: Path, trial: int, name: str, cell: str) -> Any:
    if name in TEXT:
        return "" if cell == "n/a" else cell
    try:
        return int(cell) if name in WHOLE else math.nan if cell == "n/a" else float(cell)
    except ValueError:
        raise FrictionloopError(f"{path}: trial {trial}: {name} = {cell!r}: must be a number") from None
