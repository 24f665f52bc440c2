"""A controller that was checked, as a table: Ms over slip lengths, speeds, fingers and resonances."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen
from frictionloop.cli.comparison_text import number
from frictionloop.cli.controller_holds import ends_said
from frictionloop.design.corners import MET

if TYPE_CHECKING:
    from frictionloop.design.checking import Checked
    from frictionloop.design.corners import Corner
    from frictionloop.design.elsewhere import Place
    from frictionloop.design.wanted import Wanted

Row = tuple[str, ...]
LEGEND = (
    "Ms, the largest of all forces, with the resonance off by so much; * is beyond its limit, ∞ unstable.",
    "gain: factor on the gain of the loop up to which all of its place holds, with every smaller one.",
)


def table(found: Checked, wanted: Wanted) -> list[Any]:
    """Return the table of Ms over slip lengths, speeds, fingers and resonances, and what it means."""
    offs = sorted({corner.off for place in found.places for corner in place.corners})
    limits = {round(error, 9): peak for error, peak in wanted.limits.items()}
    asked = [f"{limits[round(abs(off), 9)]:.3g} " for off in offs]
    rows: list[Row] = [("resonance", "finger", *(f"{100 * off:+.3g} % " if off else "0 " for off in offs), "gain", "")]
    rows += [("limit", "", *asked, "", "")]
    alike: dict[tuple[float | None, tuple[Row, ...]], list[Place]] = {}
    for place, gain in zip(found.places, found.gains, strict=True):
        alike.setdefault((place.slip_length_um, _rows(place, gain, offs)), []).append(place)
    for (length, lines), places in alike.items():
        speeds = ", ".join(each.speeds for each in sorted(places, key=lambda each: each.speeds_mm_s))
        skin = "" if length is None else f"{length:g} um"
        where = " ".join(filter(None, (skin, speeds and f"{speeds} mm/s"))) or "this loop"
        rows += [("" if k else where, *line) for k, line in enumerate(lines)]
    return [screen.table(rows), *map(screen.wrapped, [*LEGEND, *ends_said(wanted)])]


def _rows(place: Place, gain: float, offs: Sequence[float]) -> tuple[Row, ...]:
    """Return the lines of a place in the table, without its name."""
    lines = []
    for k, state in enumerate(sorted({corner.loop.elements.occluded for corner in place.corners})):
        here = [corner for corner in place.corners if corner.loop.elements.occluded == state]
        cells = [_cell([corner for corner in here if corner.off == off]) for off in offs]
        lines.append(("moist" if state > 0 else "dry", *cells, "" if k else number(gain), ""))
    return tuple(lines)


def _cell(found: Sequence[Corner]) -> str:
    peak, over = max(each.sensitivity_peak for each in found), any(each.excess > 1.0 + MET for each in found)
    return f"{number(peak)}{'*' if over else ' '}"
