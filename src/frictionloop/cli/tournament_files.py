"""What ``frictionloop compare`` makes of a tournament on request: a table, figures, residuals by cause."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import screen
from frictionloop.cli.figure_files import write_figures

if TYPE_CHECKING:
    import xarray as xr

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
    from frictionloop.report.style import svg

    write_figures("plots", folder, {name: svg(drawn(), name) for name, _, drawn in drawings(ran, scored)})


def causes(ran: Tournament, laws: list[str], jobs: int | None, folder: Path | None) -> list[dict[str, Any]]:
    """Return the residuals of some laws by cause, drawn into the folder of figures if there is one."""
    if not laws:
        return []
    from frictionloop.design import tournament as rooms

    with screen.waiting("splitting the residual by cause"):
        found = rooms.reasons(ran, laws, n_jobs=jobs)
    if folder is not None:
        from frictionloop.report.figures.why import figure_why
        from frictionloop.report.style import svg

        names = {speed: f"causes-{speed:g}-mm-s" for speed in ran.speeds_mm_s}
        drawn = {name: svg(figure_why(found, speed), name) for speed, name in names.items()}
        write_figures("plots", folder, drawn)
    return rooms.reason_rows(found)
