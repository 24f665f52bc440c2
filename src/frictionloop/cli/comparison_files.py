"""What ``frictionloop compare`` makes of a comparison on request: a table and figures."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli.figure_files import write_figures

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.design.comparison import Comparison


def write_csv(rows: list[dict[str, Any]], path: Path) -> None:
    """Write every score as a table."""
    import csv

    from frictionloop.quantities import replacing

    with replacing(path) as beside, beside.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def draw(ran: Comparison, scored: xr.Dataset, folder: Path) -> None:
    """Draw the figures of a comparison into a folder."""
    from frictionloop.report.figures.comparison import drawings
    from frictionloop.report.style import svg

    write_figures("plots", folder, {name: svg(drawn(), name) for name, _, drawn in drawings(ran, scored)})
