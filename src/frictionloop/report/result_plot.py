"""The figure of what a call gave: a run over time, or the metrics of a sweep over its parameters."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.quantities import FrictionloopError, must_be, replacing
from frictionloop.quantities.optional_libraries import needed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FORMATS = (".svg", ".pdf", ".png")


def plot(result: Any, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw a run or a sweep and return the figure.

    A run: f_r and f_a over time, f_a in open loop, the disturbance, the amplitude, and the motion of the
    finger. A sweep over one parameter: a curve per metric, with the range over seeds. Over two: a map per metric.
    Over three: a map for each value of the third. Over fingers: a point each, sorted by the metric. Over other listed
    points: the share below each value. A first look at a recording: its channels. The refusal of an analysis: what it
    saw.

    Parameters
    ----------
    result : xarray.Dataset
        From ``simulate``, ``sweep``, ``load`` or a device. ``result[["rms_error"]]`` draws one metric of a sweep.
    path : path, optional
        File to write as well: .svg, .pdf or .png.

    Returns
    -------
    matplotlib.figure.Figure
        To change or to save.

    Raises
    ------
    FrictionloopError
        For what is neither, a sweep over more than three parameters, another ending, or without matplotlib.
    """
    needed("matplotlib", "matplotlib", "report")
    ending = None if path is None else Path(path).suffix
    if ending is not None and ending not in FORMATS:
        raise FrictionloopError(f"path = {str(path)!r}: must end in {' or '.join(FORMATS)}")
    figure = _figure_of(result)
    if path is not None:
        from frictionloop.figures.style import DPI, svg

        with replacing(path) as beside:
            if ending == ".svg":
                beside.write_text(svg(figure, "run"), encoding="utf-8")
            else:
                figure.savefig(beside, format=ending[1:] if ending else None, dpi=DPI)
    return figure


def _figure_of(result: Any) -> Figure:
    from frictionloop.findings import Result
    from frictionloop.identification.file_overview import FirstLook
    from frictionloop.identification.project_entry_result import Refused
    from frictionloop.loop import sweep_figure
    from frictionloop.report import run_figure
    from frictionloop.report.certificate_figures import drawn

    dims = getattr(result, "dims", ())
    if hasattr(result, "data_vars") and "time" in dims and "f_r" in result:
        return run_figure.figure_of(result)
    if hasattr(result, "data_vars") and "seed" in dims:
        return sweep_figure.figure_of(result)
    if isinstance(result, Refused):
        for _, figure in drawn(result.kind, result.curves):
            return figure
    if isinstance(result, (FirstLook, Result)):
        return result.plot()
    raise must_be("result", type(result).__name__, "a run, grid or answer")
