"""A tuned tracker as a person and as a program is shown it: its schedule, and Ms by contact, speed and row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen
from frictionloop.cli.comparison_text import number
from frictionloop.parameters.tracking import PLACES

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.tracker_tuning import TrackerTuning
    from frictionloop.design.wanted import Designed

Row = tuple[str, ...]
Peaks = Mapping[str, Mapping[float, float]]
"""Ms by a name and by the share that the resonance is off."""


def off_by(off: float) -> str:
    """Return how far a resonance is off, for a person."""
    return f"{100 * off:+.3g} %" if off else "as described"


def schedule_rows(schedule: Sequence[Sequence[float]]) -> list[Row]:
    """Return the rows of a schedule under the names of their gains (`TrackerController.schedule`)."""
    from frictionloop.design.tracker_loop import Row as Gains

    rows = [(f"{place:g}", [f"{gain:.4g}" for gain in row]) for place, row in zip(PLACES, schedule, strict=True)]
    return [
        (name, " ".join(f"{cell:>8}" for cell in cells))
        for name, cells in (("schedule, place", list(Gains._fields)), *rows)
    ]


def tuned_text(designed: Designed) -> list[Any]:
    """Return Ms of a tracker by contact and speed, and by the row of its schedule; nothing of other laws."""
    tuning = designed.tuning
    if tuning is None:
        return []
    left = [f"{1e3 * force:.3g}" for force in tuning.residual_n]
    return [
        screen.wrapped("Ms by contact and speed, worst over forces, dry and moist"),
        screen.table(_table("", _by_stroke(designed.corners))),
        "",
        screen.wrapped(
            "Ms of each row, by its place: the share of the way to its limit that friction goes in a period (1 is a "
            "slider's, 1.25 one's from 40 mm/s on; 1.5, 1.75 and 1.875 are the shares 0.5, 0.25 and 0.125 of strokes "
            "above 70 mm/s), and the residual that is predicted of it at the speed it is for, mN"
        ),
        screen.table(_table("place", _by_place(tuning), ("residual", *left))),
        "",
    ]


def _by_stroke(found: Sequence[Corner]) -> Peaks:
    peaks: dict[str, dict[float, float]] = {}
    for each in found:
        there = peaks.setdefault(each.stroke.removeprefix(", contact "), {})
        there[each.off] = max(there.get(each.off, 0.0), each.margins.sensitivity_peak)
    return peaks


def _by_place(tuning: TrackerTuning) -> Peaks:
    return {f"{place:g}": peaks for place, peaks in zip(PLACES, tuning.peaks, strict=True)}


def _table(name: str, peaks: Peaks, column: Sequence[str] = ()) -> list[Row]:
    """Return rows of Ms over the errors of the resonance, and a further column with its head if there is one."""
    offs = sorted({off for each in peaks.values() for off in each})
    rows: list[Row] = [(name, *map(off_by, offs))]
    rows += [(key, *(number(each[off]) for off in offs)) for key, each in peaks.items()]
    if column:
        rows = [(*row, cell) for row, cell in zip(rows, column, strict=True)]
    return [(*row, "") for row in rows]


def as_json(tuning: TrackerTuning | None) -> list[dict[str, Any]] | None:
    """Return what is predicted of each row; None of other laws."""
    if tuning is None:
        return None
    return [
        {
            "place": place,
            "residual_n": left,
            "sensitivity_peak": {f"{off + 0.0:g}": peak for off, peak in peaks.items()},
        }
        for place, left, peaks in zip(PLACES, tuning.residual_n, tuning.peaks, strict=True)
    ]
