"""Fig. 1b: the block diagram, drawn from a System."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from frictionloop.parameters import System
from frictionloop.report.figures.labels import (
    controller_label,
    friction_label,
    lookup_label,
    noise_label,
    plate_label,
    sensor_label,
    source_label,
)
from frictionloop.report.style import BLACK, BLUE, GREY, VERMILLION, new_figure, styled

TOP, BOTTOM = 2.9, 0.75
"""Heights of the forward path and of the feedback path, in units of the drawing."""
CONTROLLER, LOOKUP, PLATE, FRICTION, SENSOR = 3.65, 5.95, 8.3, 10.55, 6.9
"""Horizontal middles of the blocks."""
ERROR, FORCE, TAP, NOISE = 2.05, 12.35, 13.0, 10.0
"""Horizontal places of the error sum, the force sum, the tap of f_a and the noise sum."""


@styled
def figure_diagram(system: System) -> Figure:
    """Return the block diagram with the System's own numbers in the blocks."""
    figure = new_figure(9.0, 3.15)
    axes = figure.subplots()
    axes.set(xlim=(-0.9, 14.0), ylim=(-0.4, 4.75), aspect="equal")
    axes.set_axis_off()
    _groups(axes)
    _block(axes, CONTROLLER, TOP, "controller $C$", controller_label(system.controller))
    _block(axes, LOOKUP, TOP, "lookup table", lookup_label(system.controller.model))
    _block(axes, PLATE, TOP, "plate", plate_label(system.plate))
    _block(axes, FRICTION, TOP, "friction $g(a)$", friction_label(system.friction))
    _block(axes, SENSOR, BOTTOM, "sensor $S$", sensor_label(system.sensor))
    _forward_wires(axes)
    _feedback_wires(axes)
    _signal(axes, -0.85, TOP + 0.3, f"set-point $f_r$\n{source_label(system.setpoint)}", ha="left", va="bottom")
    _signal(axes, FORCE, TOP + 1.25, f"disturbance $d$\n{source_label(system.disturbance)}", va="bottom")
    _signal(axes, NOISE, BOTTOM - 0.78, f"noise $n$: {noise_label(system.sensor)}", va="top")
    return figure


def _groups(axes: Axes) -> None:
    """Shade the blocks that run in the controller and those that are the plate and the finger."""
    for left, right, name, x, ha in (
        (1.65, 7.15, "controller", 7.03, "right"),
        (7.25, 12.75, "friction modulation", 7.37, "left"),
    ):
        _box(axes, left, TOP - 0.78, right - left, 1.62, fc="#f5f5f5", ec="none")
        axes.text(x, TOP - 0.98, name, color=GREY, fontsize=7.5, ha=ha, va="center", style="italic")


def _block(axes: Axes, x: float, y: float, title: str, lines: list[str]) -> None:
    _box(axes, x - 0.98, y - 0.58, 1.96, 1.16, fc="white", ec=BLACK, lw=0.9, zorder=2)
    axes.text(x, y + 0.33, title, ha="center", va="center", fontsize=8, weight="bold", zorder=3)
    axes.text(x, y - 0.16, "\n".join(lines), ha="center", va="center", fontsize=7, linespacing=1.35, zorder=3)


def _box(axes: Axes, left: float, bottom: float, width: float, height: float, **look: Any) -> None:
    rounded = "round,pad=0,rounding_size=0.1"
    axes.add_patch(FancyBboxPatch((left, bottom), width, height, boxstyle=rounded, **look))


def _sum(axes: Axes, x: float, y: float) -> None:
    axes.add_patch(Circle((x, y), 0.17, fc="white", ec=BLACK, lw=0.9, zorder=2))


def _arrow(axes: Axes, start: tuple[float, float], stop: tuple[float, float], color: str = BLACK) -> None:
    axes.annotate(
        "", stop, start, arrowprops={"arrowstyle": "-|>", "lw": 0.9, "color": color, "shrinkA": 0, "shrinkB": 0}
    )


def _signal(
    axes: Axes, x: float, y: float, text: str, ha: str = "center", va: str = "center", color: str = BLACK
) -> None:
    axes.text(x, y, text, ha=ha, va=va, fontsize=7.5, linespacing=1.3, color=color)


def _forward_wires(axes: Axes) -> None:
    places = (-0.85, ERROR, CONTROLLER, LOOKUP, PLATE, FRICTION, FORCE, 13.75)
    ends = ((0.0, 0.17), (0.17, 0.98), (0.98, 0.98), (0.98, 0.98), (0.98, 0.98), (0.98, 0.17), (0.17, 0.0))
    names = ("", "$e$", "$u$", "", "$a$", "", "$f_a$")
    for k, ((after, before), name) in enumerate(zip(ends, names, strict=True)):
        start, stop = places[k] + after, places[k + 1] - before
        _arrow(axes, (start, TOP), (stop, TOP))
        _signal(axes, (start + stop) / 2 if k < 6 else 13.45, TOP + 0.2, name)
    _sum(axes, ERROR, TOP)
    _sum(axes, FORCE, TOP)
    _arrow(axes, (FORCE, TOP + 1.2), (FORCE, TOP + 0.17), BLUE)


def _feedback_wires(axes: Axes) -> None:
    axes.plot([TAP, TAP], [TOP, BOTTOM], color=BLACK, lw=0.9)
    axes.plot([TAP], [TOP], "o", ms=3, color=BLACK)
    _arrow(axes, (TAP, BOTTOM), (NOISE + 0.17, BOTTOM))
    _sum(axes, NOISE, BOTTOM)
    _arrow(axes, (NOISE, BOTTOM - 0.72), (NOISE, BOTTOM - 0.17), VERMILLION)
    _arrow(axes, (NOISE - 0.17, BOTTOM), (SENSOR + 0.98, BOTTOM))
    axes.plot([SENSOR - 0.98, ERROR], [BOTTOM, BOTTOM], color=BLACK, lw=0.9, solid_capstyle="projecting")
    _arrow(axes, (ERROR, BOTTOM), (ERROR, TOP - 0.17))
    _signal(axes, (SENSOR - 0.98 + ERROR) / 2, BOTTOM + 0.2, "$f_m$")
    _signal(axes, ERROR - 0.22, TOP - 0.36, "−")
