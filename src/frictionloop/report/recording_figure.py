"""The figure of a recording as it stands in its file: each channel by its lowest and highest value along it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.report.style import BLUE, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from frictionloop.identification.first_look import FirstLook

MOST = 12
"""Channels that are drawn."""


@styled
def recording_figure(look: FirstLook) -> Figure:
    """Return the channels of a file, one below the other, over time, or the number of the sample without a rate."""
    traces = look.traces[:MOST]
    figure = new_figure(8.0, 1.0 + 0.9 * len(traces))
    rows = figure.subplots(len(traces), 1, sharex=True, squeeze=False)[:, 0]
    period_s = 1 / look.rate_hz if look.rate_hz else 1.0
    for axes, trace in zip(rows, traces, strict=True):
        axes.fill_between(period_s * trace.row, trace.low, trace.high, color=BLUE, linewidth=0.6, edgecolor=BLUE)
        axes.set_ylabel(
            f"{trace.name}\n({trace.unit})" if trace.unit else trace.name, rotation=0, ha="right", va="center"
        )
        axes.margins(x=0.0, y=0.1)
    rows[-1].set_xlabel("time (s)" if look.rate_hz else "sample")
    more = f", {len(look.traces) - MOST} more channels are not drawn" if len(look.traces) > MOST else ""
    rows[0].set_title(f"{Path(look.path).name}: {look.said}{more}", loc="left", fontsize="small")
    return figure
