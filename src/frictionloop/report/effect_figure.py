"""The figure of an effect: its map with the path, and asked, delivered open and closed loop over place."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from frictionloop.report.style import BLACK, BLUE, GREEN, SKY, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from frictionloop.preview import Preview

ROOM_MM = 5.0
"""Shown of a map on both sides of the path."""


@styled
def figure_of(shown: Preview) -> Figure:
    """Return the forces over place, forth as lines and back as dots, below the map with the path on it."""
    figure = new_figure(8.0, 5.0)
    top, below = figure.subplots(2, sharex=False, height_ratios=(1, 3))
    _draw_map(top, shown)
    place = shown.place_mm
    below.fill_between(
        place, shown.low_n, shown.high_n, color="#e8f1f8", linewidth=0, label="within reach of the finger"
    )
    below.plot(place, shown.asked_forth_n, color=BLACK, linewidth=2.4, alpha=0.35, label="asked for")
    if not np.allclose(shown.asked_forth_n, shown.asked_back_n, atol=1e-9):
        below.plot(
            place, shown.asked_back_n, color=BLACK, linewidth=1.2, linestyle=":", label="asked for on the way back"
        )
    for ways, colour, label in ((shown.open_loop, VERMILLION, "open loop"), (shown.closed_loop, BLUE, "closed loop")):
        below.plot(place, ways.forth_n, color=colour, linewidth=1.0, label=label)
        below.plot(place, ways.back_n, color=colour, linewidth=0.8, linestyle=":")
    highest = np.nanmax(
        [shown.asked_forth_n.max(), np.nanmax(shown.closed_loop.forth_n), np.nanmax(shown.open_loop.forth_n)]
    )
    below.set(xlabel="place (mm)", ylabel="force (N)", xlim=(place[0], place[-1]), ylim=(0.0, 1.15 * highest))
    figure.suptitle(shown.sentence, fontsize=9)
    figure.legend(*below.get_legend_handles_labels(), loc="outside lower center", ncols=5)
    return figure


def _draw_map(axes: Axes, shown: Preview) -> None:
    """Draw what is asked for around the path, and the path."""
    from frictionloop.rendering.effect import Touch
    from frictionloop.rendering.source import EffectSource

    source = shown.system.setpoint
    assert isinstance(source, EffectSource)
    track = source.track.touch(shown.place_mm[[0, -1]])
    x = np.linspace(min(track.x_mm) - 0.5, max(track.x_mm) + 0.5, 900)
    y = np.linspace(min(track.y_mm) - ROOM_MM, max(track.y_mm) + ROOM_MM, 121)
    grid = np.meshgrid(x, y)
    touch = Touch(*grid, shown.speed_mm_s, 0.5, 1e6, source.track.heading_deg)
    force = np.broadcast_to(source.effect.asked(touch), grid[0].shape)
    image = axes.imshow(force, extent=(x[0], x[-1], y[0], y[-1]), origin="lower", aspect="auto", cmap="viridis")
    axes.plot(track.x_mm, track.y_mm, color=SKY, linewidth=1.2)
    axes.plot(track.x_mm[:1], track.y_mm[:1], color=GREEN, marker="o")
    axes.set(xlabel="x (mm)", ylabel="y (mm)")
    axes.grid(visible=False)
    axes.figure.colorbar(image, ax=axes, label="N", pad=0.01)
