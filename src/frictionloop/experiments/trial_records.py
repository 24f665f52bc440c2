"""Trials: what was delivered in each stroke, whether it counts, what a row of the table says, and reading it back."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.experiments.protocol import Protocol, Stimulus
from frictionloop.experiments.trial_structure import Validity
from frictionloop.loop.companion_runs import perceptual_index
from frictionloop.loop.record import system_of
from frictionloop.quantities import Array, FrictionloopError, must_be

DECLARED = {
    ("constant", "level_n"): "mean",
    ("grating", "offset_n"): "mean",
    ("grating", "amplitude_n"): "contrast",
    ("chirp", "amplitude_n"): "contrast",
    ("grating", "spacing_mm"): "asked",
}
"""What an effect takes as delivered of a field: the mean force; how much of its pattern arrived; or what was asked for,
where the field is of place, which the plate gives by itself. Other fields are taken as asked for."""


class Measures(NamedTuple):
    """One stroke in numbers, over the periods that are scored."""

    force_mean_n: float
    force_sd_n: float
    rms_error_n: float
    """Of the force against the set-point, N."""
    felt_index: float
    """Index D of that error: felt above 1."""
    saturated_share: float
    speed_mm_s: float
    load_n: float
    contact_share: float
    """Share of the stroke that is scored: the finger slides and is down."""
    lost_samples: int
    level: float
    """The field's value that was delivered."""


def measures(run: xr.Dataset, protocol: Protocol, asked: float) -> Measures:
    """Return one stroke in numbers; ``asked`` is the value of the effect's field that was asked for.

    Of a device the force is the measured one.
    """
    scored = run["scored"].values
    force = run[force_of(run)].values
    lost = int(np.isnan(force).sum())
    keep = scored & np.isfinite(force)
    if not keep.any():
        nan = math.nan
        return Measures(nan, nan, nan, nan, nan, nan, nan, 0.0, lost, nan)
    intended = run["f_r_intended" if "f_r_intended" in run else "f_r"].values
    f, r = force[keep], intended[keep]
    source: Any = system_of(run).setpoint
    wanted = r
    if source.effect.is_static:  # its set-point is drawn into what the finger can be given
        wanted = source.effect.force_of(source.track.touch(1e3 * run["position"].values[keep])) + np.zeros(f.size)
    return Measures(
        float(f.mean()),
        float(f.std()),
        float(np.sqrt(np.mean((f - r) ** 2))),
        perceptual_index(run) if "f_a" in run and not lost else math.nan,
        float(run["saturated"].values[keep].mean()),
        1e3 * float(np.abs(run["speed"].values[keep]).mean()),
        float(run["load"].values[keep].mean()),
        float(keep.mean()),
        lost,
        _level(protocol.stimulus, asked, f, wanted),
    )


def force_of(run: xr.Dataset) -> str:
    """Return the name of the force that was delivered: that on the finger where it is known, else the measured one."""
    return "f_a" if "f_a" in run else "f_m"


def _level(stimulus: Stimulus, asked: float, force: Array, intended: Array) -> float:
    rule = stimulus.delivered
    if rule == "declared":
        rule = DECLARED.get((stimulus.effect.kind, stimulus.field), "asked")  # type: ignore[assignment]
    if rule == "mean":
        return asked + float(force.mean() - intended.mean())
    if rule == "contrast" and np.std(intended) > 1e-6:
        return asked * float(np.cov(intended, force)[0, 1] / np.var(intended, ddof=1))
    return asked


def why_invalid(found: Measures, rules: Validity) -> str:
    """Return why a stroke does not count, empty if it does."""
    if not math.isfinite(found.force_mean_n) or found.contact_share < rules.contact_share:
        return f"contact_share={found.contact_share:.2f}"
    for name, (low, high) in (("speed_mm_s", rules.speed_mm_s), ("load_n", rules.load_n)):
        if not low <= getattr(found, name) <= high:
            return f"{name}={getattr(found, name):.3g}"
    if found.saturated_share > rules.saturated_share:
        return f"saturated_share={found.saturated_share:.2f}"
    if rules.rms_error_n is not None and found.rms_error_n > rules.rms_error_n:
        return f"rms_error_n={found.rms_error_n:.3g}"
    if found.lost_samples > rules.lost_samples:
        return f"lost_samples={found.lost_samples}"
    return ""


def rate_of(run: xr.Dataset) -> float:
    """Return the samples per second of a run."""
    return float(system_of(run).controller.rate_hz)


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
    "delivered": "level delivered",
    "onset_s": "first stroke begins, s",
    "offset_s": "last stroke ends, s",
    **{f"{name}_{k}": f"interval {k}: {text}" for k in (1, 2) for name, text in MEASURED.items()},
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
    "check": "checksum of the row and of the one before",
}
"""Columns of ``trials.tsv`` and what they mean."""
NUMBERS = {"magnitude": (0.0, math.inf, "above 0"), "tracking": (0.0, 100.0, "from 0 to 100")}
"""Answers that are numbers, by task: ends, and how they are told; 0 is no magnitude."""
WHOLE = ("trial", "block", "comparison", "valid", "counted", "again", "repeat_of")
TEXT = ("participant", "condition", "phase", "track", "response", "reason", "method_state", "raw", "check")
RAW_FILE = "raw/trial-{:05d}.h5"
"""File of a trial's traces in the folder of its session."""
AMENDED = "amended: "
"""How the reason begins of a row that takes the place of an earlier one of its trial."""
PRIME = 2**61 - 1
"""Modulus of the two sums of a checksum: a Mersenne prime that a hash of 8 bytes fills."""


def scored(protocol: Protocol, level: float, comparison: int, response: str) -> tuple[float, float]:
    """Return whether an answer was right (NaN where none is) and what the method is told of it."""
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
    """Return an answer that is a number."""
    low, high, said = NUMBERS[task]
    try:
        value = float(response)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and low <= value <= high) or (task == "magnitude" and value == 0.0):
        raise must_be("answer", response, f"a number {said}")
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
    line = io.StringIO()
    csv.writer(line, "excel-tab", lineterminator="\n").writerow([_text(row.get(name)) for name in COLUMNS])
    return line.getvalue()


def check_of(row: Mapping[str, Any], before: str) -> str:
    """Return the checksum of a row's values, chained to that of the row ``before``.

    s = sum h_k and t = sum k h_k modulo 2^61 - 1 in 16 hexadecimal digits each. h_0 is the hash of the checksum before,
    h_k that of column k as it is read back, so that other programs may quote cells and write other ends of lines.
    """
    cells = [before, *(_text(_value(name, _text(row.get(name)))) for name in COLUMNS if name != "check")]
    hashes = [int.from_bytes(sha256(cell.encode()).digest()[:8]) for cell in cells]
    return f"{sum(hashes) % PRIME:016x}{sum(k * each for k, each in enumerate(hashes)) % PRIME:016x}"


def _changed(row: Mapping[str, Any], before: str) -> str:
    """Return the column of a row that was changed, "check" where it is not just one, empty where none was.

    Where h_k alone differs, k is the quotient of the differences of t and s.
    """
    expected, stands = check_of(row, before), row["check"]
    if stands == expected:
        return ""
    s, t = (int(stands[half], 16) - int(expected[half], 16) for half in (slice(16), slice(16, 32)))
    place = t * pow(s, -1, PRIME) % PRIME if s % PRIME else 0
    return list(COLUMNS)[place - 1] if 0 < place < len(COLUMNS) else "check"


def cells_of(line: str) -> list[str]:
    """Return the cells of a line, without the quotes of a spreadsheet."""
    return next(csv.reader([line], "excel-tab"), [])


def whole_row(line: str) -> bool:
    """Return whether a line of the table is all there, though nothing ends it: its last cell is a checksum."""
    cells = cells_of(line)
    return cells == list(COLUMNS) or (len(cells) == len(COLUMNS) and _is_check(cells[-1]))


def _is_check(cell: str) -> bool:
    return re.fullmatch("[0-9a-f]{32}", cell) is not None


def whole_part(path: Path, is_whole: Callable[[str], bool]) -> bytes:
    """Return a file of lines up to the last whole one, its end with it: without what a killed run left of another.

    Zeros at the end are what a lost power supply leaves.
    """
    try:
        data = path.read_bytes().rstrip(b"\0")
    except OSError as error:
        raise FrictionloopError(f"{path}: cannot be read ({error.strerror or error})") from None
    ended, last = data[: data.rfind(b"\n") + 1], data[data.rfind(b"\n") + 1 :]
    return data + b"\n" if is_whole(last.decode("utf-8", "replace")) else ended


def whole_lines(path: Path, is_whole: Callable[[str], bool]) -> list[str]:
    """Return the whole lines of a file, without blank ones."""
    text = whole_part(path, is_whole).decode("utf-8-sig", "replace").replace("\0", "")
    return [line for line in text.splitlines() if line.strip()]


def read_rows(path: Path, participant: str) -> list[dict[str, Any]]:
    """Return the rows of a participant's table as they were written, numbers as numbers and NaN where nothing stands.

    Raises
    ------
    FrictionloopError
        For what is no table, and for a row that was changed, taken away or put in, with its field.
    """
    header, *lines = [cells_of(line) for line in whole_lines(path, whole_row)] or [[]]
    if header != list(COLUMNS):
        raise FrictionloopError(f"{path}: is no table of trials")
    found: list[dict[str, Any]] = []
    trials = 0
    for number, cells in enumerate(lines, 1):
        where = f"{path}: row {number}"
        if len(cells) != len(COLUMNS):
            raise must_be(where, len(cells), str(len(COLUMNS)), "columns")
        row = {name: _read(where, name, cell) for name, cell in zip(COLUMNS, cells, strict=True)}
        if not row["reason"].startswith(AMENDED):
            trials += 1
            if row["trial"] != trials:
                raise must_be(f"{where}: trial", row["trial"], str(trials))
        for name, accepted in (("participant", participant), ("raw", RAW_FILE.format(row["trial"]))):
            if row[name] != accepted:
                raise must_be(f"{where}: {name}", row[name], accepted)
        if changed := _changed(row, found[-1]["check"] if found else ""):
            raise FrictionloopError(f"{where}: {changed} = {row[changed]!r}: is not what was written")
        found.append(row)
    return found


def originals(rows: Iterable[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the rows as the method was told them, without those that amend one."""
    return [row for row in rows if not row["reason"].startswith(AMENDED)]


def _text(value: Any) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return "n/a"
    if isinstance(value, bool):
        return str(int(value))
    if isinstance(value, float):
        return repr(float(value))
    return " ".join(str(value).split()) or "n/a"


def _read(where: str, name: str, cell: str) -> Any:
    try:
        if name == "check" and not _is_check(cell):
            raise ValueError
        return _value(name, cell)
    except ValueError:
        raise must_be(f"{where}: {name}", cell, "32 hexadecimal digits" if name == "check" else "a number") from None


def _value(name: str, cell: str) -> Any:
    if name in TEXT:
        return "" if cell == "n/a" else cell
    return int(cell) if name in WHOLE else math.nan if cell == "n/a" else float(cell)
