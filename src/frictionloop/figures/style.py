"""One visual style for every figure, and figures as SVG text that is the same bytes every time."""

from __future__ import annotations

import functools
import io
import re
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any, ParamSpec

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from frictionloop.quantities import replacing

P = ParamSpec("P")

BLACK, GREY, SILVER = "#1a1a1a", "#6b6b6b", "#b3b3b3"
BLUE, VERMILLION, GREEN, ORANGE, SKY, PURPLE = "#0072B2", "#D55E00", "#009E73", "#E69F00", "#56B4E9", "#CC79A7"
"""Colours told apart with any colour vision (Okabe and Ito 2008); lines differ in their dashes too."""

DPI = 200
"""Pixels per inch of figures that are not lines but pixels: sharp in print at the size of a column (chosen)."""
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",  # ships with matplotlib, so the same on every machine
    "font.size": 8.5,
    "axes.titlesize": 9.0,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelcolor": BLACK,
    "axes.edgecolor": GREY,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e6e6e6",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "xtick.color": BLACK,
    "ytick.color": BLACK,
    "xtick.major.width": 0.7,
    "ytick.major.width": 0.7,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.0,
    "legend.frameon": False,
    "legend.fontsize": 8.0,
    "image.cmap": "viridis",  # perceptually uniform, and monotonic in grey
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "mathtext.fontset": "dejavusans",
    "path.simplify_threshold": 0.05,
    "svg.fonttype": "path",  # looks the same without the font
}


def styled(draw: Callable[P, Figure]) -> Callable[P, Figure]:
    """Decorate a function that draws a figure: it then draws in the report's style."""

    @functools.wraps(draw)
    def in_style(*args: P.args, **kwargs: P.kwargs) -> Figure:
        with mpl.rc_context(STYLE):
            return draw(*args, **kwargs)

    return in_style


def new_figure(width_in: float = 4.5, height_in: float = 3.2) -> Figure:
    """Return an empty figure, in inches, whose parts make room for each other."""
    return Figure(figsize=(width_in, height_in), layout="constrained")


def one_panel(width_in: float = 4.5, height_in: float = 3.2) -> tuple[Figure, Axes]:
    """Return an empty figure of one panel."""
    figure = new_figure(width_in, height_in)
    return figure, figure.subplots()


def schematic(
    width_in: float, height_in: float, xlim: tuple[float, float], ylim: tuple[float, float]
) -> tuple[Figure, Axes]:
    """Return an empty figure to draw a scheme in, in units of its own, alike in both directions."""
    figure, axes = one_panel(width_in, height_in)
    axes.set(xlim=xlim, ylim=ylim, aspect="equal")
    axes.set_axis_off()
    return figure, axes


def say(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    """Write words around a place of a scheme."""
    centred: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 7}
    axes.text(x, y, text, **centred | look)


def arrow(axes: Axes, start: tuple[float, float], stop: tuple[float, float], color: str = BLACK) -> None:
    """Draw the arrow of a signal."""
    look = {"arrowstyle": "-|>", "lw": 0.9, "color": color, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", stop, start, arrowprops=look)


def svg(figure: Figure, name: str, source: str = "") -> str:
    """Return a figure as SVG text: no date, ids fixed and starting with ``name`` so that several share a page.

    ``source`` goes into its metadata: version, command and seeds that make it again.
    """
    text = io.StringIO()
    with mpl.rc_context(STYLE | {"svg.hashsalt": name}):
        # Not savefig, which draws once more beforehand to see how large everything is: the layout has seen to that.
        metadata = dict.fromkeys(("Date", "Creator", "Format", "Type")) | ({"Source": source} if source else {})
        FigureCanvasSVG(figure).print_svg(text, metadata=metadata)  # type: ignore[no-untyped-call]
    prefixed = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{name}-", text.getvalue())
    return "\n".join(line.rstrip() for line in prefixed.splitlines()) + "\n"


def write_both(figure: Figure, name: str, path: Path, source: str = "") -> str:
    """Write a figure as SVG, and beside it as PNG for slides; return the SVG text; nobody meets half a file."""
    text = svg(figure, name, source)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    with replacing(path.with_name(f"{path.stem}.png")) as beside:
        beside.write_bytes(png(figure, source))
    return text


def png(figure: Figure, source: str = "") -> bytes:
    """Return a figure as the bytes of a PNG file; ``source`` goes into its metadata, as in `svg`."""
    content = io.BytesIO()
    figure.savefig(content, format="png", dpi=DPI, metadata={"Source": source} if source else None)
    return content.getvalue()


def inline(text: str, label: str) -> str:
    """Return SVG text as an element for a page: without prolog and fixed size, with a label for screen readers.

    The page's style knows how wide it was drawn (``--pt``), and so how small its letters may become.
    """
    element = re.sub(r"<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL)
    width, height = re.findall(r'(?:width|height)="([\d.]+)pt"', element)[:2]
    sized = re.sub(r' (?:width|height)="[\d.]+pt"', "", element, count=2)
    attributes = f'role="img" aria-label="{escape(label)}" style="aspect-ratio:{width}/{height};--pt:{width}"'
    return sized.replace("<svg", f"<svg {attributes}", 1)
