"""What ``frictionloop compare`` makes of a tournament on request: a table, figures, residuals by cause."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

    from frictionloop.design.tournament import Tournament


def write_csv(rows: list[dict[str, Any]], path: Path) -> None:
    """Write every score as a table."""
    import csv

    from frictionloop.quantities import replacing

    with replacing(path) as beside, beside.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def draw(ran: Tournament, scored: xr.Dataset, folder: Path) -> None:
    """Draw the figures of a tournament into a folder."""
    from frictionloop.report.figures.tournament import drawings

    for name, _, drawn in drawings(ran, scored):
        _write_figure(folder, name, drawn())


def _write_figure(folder: Path, name: str, figure: Figure) -> None:
    from frictionloop.quantities import replacing
    from frictionloop.report.style import svg

    folder.mkdir(exist_ok=True)
    with replacing(folder / f"{name}.svg") as beside:
        beside.write_text(svg(figure, name), encoding="utf-8")


def causes(ran: Tournament, laws: list[str], jobs: int | None, folder: Path | None) -> list[dict[str, Any]]:
    """Return the residuals of some laws by cause, drawn into the folder of figures if there is one."""
    if not laws:
        return []
    from frictionloop.design import tournament as rooms

    with screen.waiting("splitting the residual by cause"):
        found = rooms.reasons(ran, laws, n_jobs=jobs)
    if folder is not None:
        from frictionloop.report.figures.why import figure_why

        for speed in ran.speeds_mm_s:
            _write_figure(folder, f"causes-{speed:g}-mm-s", figure_why(found, speed))
    return rooms.reason_rows(found)
