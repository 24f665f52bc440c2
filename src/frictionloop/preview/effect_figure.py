"""The figure of an effect: its map with the path, what arrives open and closed loop over place, and what is felt."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.lines import Line2D

from frictionloop.figures.style import BLACK, BLUE, GREY, VERMILLION, new_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from frictionloop.preview.effect_preview import Preview

ROOM_MM = 5.0
"""Shown of a map on both sides of the path."""
LAWS = (("open loop", VERMILLION), ("closed loop", BLUE))


@styled
def figure_of(shown: Preview) -> Figure:
    """Return the map with the path on it, forces over place, forth as lines and back as dots, and what is felt."""
    figure = new_figure(8.0, 6.0)
    grid = figure.subplots(3, 2, height_ratios=(1, 3, 1.2), width_ratios=(70, 1))
    _draw_map(grid[0, 0], grid[0, 1], shown)
    _draw_forces(grid[1, 0], shown)
    _draw_felt(grid[2, 0], shown)
    for axes in grid[1:, 1]:
        axes.set_axis_off()
    for axes in grid[1:, 0]:
        axes.set_xlim(shown.place_mm[0], shown.place_mm[-1])
    grid[1, 0].tick_params(labelbottom=False)
    grid[2, 0].set_xlabel("place along the path (mm)")
    figure.suptitle(f"{shown.rows()[0][1]}: {' '.join(shown.arriving)}", fontsize=9)
    handles, labels = grid[1, 0].get_legend_handles_labels()
    handles.append(Line2D([], [], color=BLACK, linewidth=1.0, linestyle=":"))
    figure.legend(handles, [*labels, "dotted: the way back"], loc="outside lower center", ncols=5)
    return figure


def _draw_forces(axes: Axes, shown: Preview) -> None:
    place = shown.place_mm
    asked = np.array([shown.asked_forth_n, shown.asked_back_n])
    axes.fill_between(
        place, shown.low_n, shown.high_n, color="#e8f1f8", linewidth=0, label="within reach of the finger"
    )
    axes.plot(place, asked[0], color=BLACK, linewidth=2.4, alpha=0.35, label="asked for")
    if not np.allclose(asked[0], asked[1], atol=1e-9):
        axes.plot(place, asked[1], color=BLACK, linewidth=1.2, linestyle=":")
    given = [asked]
    for ways, (label, colour) in zip((shown.open_loop, shown.closed_loop), LAWS, strict=True):
        axes.plot(place, ways.forth_n, color=colour, linewidth=1.0, label=label)
        axes.plot(place, ways.back_n, color=colour, linewidth=0.8, linestyle=":")
        given.append(np.array([ways.forth_n, ways.back_n]))
    low, high = (end([end(each) for each in given]) for end in (np.nanmin, np.nanmax))
    room = max(0.1 * (high - low), 0.03)
    axes.set(ylabel="force (N)", ylim=(max(low - room, 0.0), high + room))


def _draw_felt(axes: Axes, shown: Preview) -> None:
    """Draw pattern and error over place in thresholds of touch; the pattern is drawn as it arrives closed loop."""
    axes.axhline(1.0, color=GREY, linewidth=0.8)
    axes.plot(shown.place_mm, np.maximum(shown.closed_loop.pattern_over, 1e-3), color=BLACK, linewidth=1.4)
    for ways, (_, colour) in zip((shown.open_loop, shown.closed_loop), LAWS, strict=True):
        axes.plot(shown.place_mm, ways.error_over, color=colour, linewidth=0.8)
    axes.set(yscale="log", ylim=(0.3, None), ylabel="felt (× threshold)")
    axes.yaxis.set_major_formatter("{x:g}")
    axes.set_title("pattern as it arrives closed loop (black), and the error", fontweight="normal", fontsize=8.0)


def _draw_map(axes: Axes, scale: Axes, shown: Preview) -> None:
    """Draw what is asked for around the path, and the path."""
    from frictionloop.rendering.effect import Touch
    from frictionloop.rendering.effect_setpoint import EffectSource

    source = shown.system.setpoint
    assert isinstance(source, EffectSource)
    track = source.track.touch(shown.place_mm[[0, -1]])
    beside = ROOM_MM if np.ptp(track.x_mm) < ROOM_MM else 0.0
    x = np.linspace(min(track.x_mm) - beside, max(track.x_mm) + beside, 900)
    y = np.linspace(min(track.y_mm) - ROOM_MM, max(track.y_mm) + ROOM_MM, 121)
    grid = np.meshgrid(x, y)
    touch = Touch(*grid, shown.speed_mm_s, 0.5, 1e6, source.track.heading_deg)
    force = np.broadcast_to(source.effect.force_of(touch), grid[0].shape)
    image = axes.imshow(force, extent=(x[0], x[-1], y[0], y[-1]), origin="lower", aspect="auto", cmap="viridis")
    for colour, width in ((BLACK, 2.6), ("white", 1.2)):
        axes.plot(track.x_mm, track.y_mm, color=colour, linewidth=width)
    axes.plot(track.x_mm[:1], track.y_mm[:1], color="white", marker="o", markeredgecolor=BLACK, clip_on=False)
    axes.set(xlabel="x (mm)", ylabel="y (mm)", xlim=(x[0], x[-1]))
    axes.grid(visible=False)
    axes.figure.colorbar(image, cax=scale, label="asked for (N)")
