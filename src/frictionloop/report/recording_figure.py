"""The figure of a recording as it stands in its file: each channel by its lowest and highest value along it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from frictionloop.figures.style import BLUE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from frictionloop.identification.first_look import FirstLook, Trace

MOST = 24
"""Channels that are drawn."""


@styled
def recording_figure(look: FirstLook) -> Figure:
    """Return the channels of a file that vary, one below the other.

    They stand over time, or over the number of the sample where nothing tells a rate.
    """
    traces = _drawn(look)
    figure = new_figure(8.0, 1.0 + 0.9 * len(traces))
    rows = figure.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    for axes, trace in zip(rows, traces, strict=True):
        axes.fill_between(_along(look, trace.row), trace.low, trace.high, color=BLUE, linewidth=0.6, edgecolor=BLUE)
        axes.set_ylabel(
            f"{trace.name}\n({trace.unit})" if trace.unit else trace.name, rotation=0, ha="right", va="center"
        )
        axes.margins(x=0.0, y=0.1)
    rows[-1].set_xlabel("time (s)" if look.rate_hz else look.clock[0] if look.clock else "sample")
    rows[0].set_title(f"{Path(look.path).name}: {look.said}", loc="left", fontsize="small")
    return figure


def left_out(look: FirstLook) -> str:
    """Return the names of the channels that are not drawn, in a sentence; empty where all are."""
    drawn = _drawn(look)
    names = [trace.name for trace in look.traces if not any(trace is each for each in drawn)]
    same = [trace.name for trace in look.traces if trace.name in names and _is_constant(trace)]
    others = [name for name in names if name not in same]
    said = [f"{', '.join(same)} (always the same)"] * bool(same)
    said += [f"{', '.join(others)} (behind the first {MOST})"] * bool(others)
    return f"not drawn: {', '.join(said)}" if said else ""


def _drawn(look: FirstLook) -> list[Trace]:
    """Return the first of the channels that vary, of all where none does."""
    return ([trace for trace in look.traces if not _is_constant(trace)] or list(look.traces))[:MOST]


def _is_constant(trace: Trace) -> bool:
    ends = np.concatenate([trace.low, trace.high])
    known = ends[np.isfinite(ends)]
    return not known.size or bool(known.min() == known.max())


def _along(look: FirstLook, row: np.ndarray) -> np.ndarray:
    """Return where rows stand on the horizontal axis."""
    if look.rate_hz:
        return row / look.rate_hz
    return row if look.clock is None else np.interp(row, np.arange(look.clock[1].size), look.clock[1])
