"""Fig. 1b: the block diagram of the loop of Section 2, drawn from a System."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch

from frictionloop.figures.style import BLACK, BLUE, GREY, VERMILLION, arrow, say, schematic, styled
from frictionloop.parameters import FrictionLaw, LogSweep, Model, PiController, Sine, System
from frictionloop.report.numbers import number

TOP, BOTTOM = 2.9, 0.75
"""Heights of the forward path and of the feedback path, in units of the drawing."""
CONTROLLER, LOOKUP, PLATE, FRICTION, SENSOR = 3.65, 5.95, 8.3, 10.55, 6.9
"""Horizontal middles of the blocks."""
ERROR, FORCE, TAP, NOISE = 2.05, 12.35, 13.0, 10.0
"""Horizontal places of the error sum, the force sum, the tap of f_a and the noise sum."""


@styled
def figure_diagram(system: System) -> Figure:
    """Return the block diagram with the System's own numbers in the blocks."""
    controller, setpoint, disturbance = system.controller, system.setpoint, system.disturbance
    assert isinstance(controller, PiController)
    assert isinstance(setpoint, LogSweep)
    assert isinstance(disturbance, Sine)
    figure, axes = schematic(9.0, 3.15, (-0.9, 14.0), (-0.4, 4.75))
    _groups(axes)
    _block(axes, CONTROLLER, TOP, "controller $C$", controller_label(controller))
    _block(axes, LOOKUP, TOP, "lookup table", lookup_label(controller.model))
    lowpass, plate, law = "first-order low-pass", system.plate, system.friction
    assert isinstance(law, FrictionLaw)
    most, f0, tau = (number(n) for n in (plate.max_amplitude_um, law.nominal_n, law.susceptibility_per_um2))
    _block(axes, PLATE, TOP, "plate", [lowpass, f"{number(plate.cutoff_hz)} Hz", f"$a$ ≤ {most} µm"])
    words = ["$f_0\\,\\exp(-\\tau a^2)$", f"$f_0$ = {f0} N", f"$\\tau$ = {tau} µm⁻²"]
    _block(axes, FRICTION, TOP, "friction $g(a)$", words)
    _block(axes, SENSOR, BOTTOM, "sensor $S$", [lowpass, f"{number(system.sensor.cutoff_hz)} Hz"])
    _forward_wires(axes)
    _feedback_wires(axes)
    _signal(axes, -0.85, TOP + 0.3, f"set-point $f_r$\n{source_label(setpoint)}", ha="left", va="bottom")
    _signal(axes, FORCE, TOP + 1.25, f"disturbance $d$\n{source_label(disturbance)}", va="bottom")
    _signal(axes, NOISE, BOTTOM - 0.78, f"noise $n$: white, {number(system.sensor.noise_rms_n)} N rms", va="top")
    return figure


def source_label(source: LogSweep | Sine) -> str:
    """Return what the set-point or the disturbance does over time."""
    around = f"{number(source.offset_n)} ± {number(source.amplitude_n)} N"
    if isinstance(source, Sine):
        return f"sine {number(source.frequency_hz)} Hz\n{around}"
    return f"sweep {number(source.start_hz)}–{number(source.stop_hz)} Hz\n{around}"


def controller_label(controller: PiController) -> list[str]:
    """Return gains, rate and delay."""
    delay = f"delay {number(controller.delay_s * 1e6)} µs" if controller.delay_s else "no delay"
    gains = [f"$K_p$ = {number(controller.kp)}", f"$K_i$ = {number(controller.ki)} s⁻¹"]
    return [*gains, f"{number(controller.rate_hz / 1000)} kHz, {delay}"]


def lookup_label(model: Model) -> list[str]:
    """Return what the lookup table inverts and the clamp before it."""
    return [
        "exact inverse of $g$" if model.table_size == 0 else f"{model.table_size} entries",
        f"{number(model.floor_n, 2)} ≤ $u$ ≤ {number(model.nominal_n)} N",
        f"0 ≤ $a$ ≤ {number(model.max_amplitude_um)} µm",
    ]


def _groups(axes: Axes) -> None:
    """Shade the blocks that run in the controller and those that are the plate and the finger."""
    for left, right, name, x, ha in (
        (1.65, 7.15, "controller", 7.03, "right"),
        (7.25, 12.75, "friction modulation", 7.37, "left"),
    ):
        _box(axes, left, TOP - 0.78, right - left, 1.62, fc="#f5f5f5", ec="none")
        say(axes, x, TOP - 0.98, name, color=GREY, fontsize=7.5, ha=ha, style="italic")


def _block(axes: Axes, x: float, y: float, title: str, lines: list[str]) -> None:
    _box(axes, x - 0.98, y - 0.58, 1.96, 1.16, fc="white", ec=BLACK, lw=0.9, zorder=2)
    say(axes, x, y + 0.33, title, fontsize=8, weight="bold", zorder=3)
    say(axes, x, y - 0.16, "\n".join(lines), linespacing=1.35, zorder=3)


def _box(axes: Axes, left: float, bottom: float, width: float, height: float, **look: Any) -> None:
    rounded = "round,pad=0,rounding_size=0.1"
    axes.add_patch(FancyBboxPatch((left, bottom), width, height, boxstyle=rounded, **look))


def _sum(axes: Axes, x: float, y: float) -> None:
    axes.add_patch(Circle((x, y), 0.17, fc="white", ec=BLACK, lw=0.9, zorder=2))


def _signal(axes: Axes, x: float, y: float, text: str, **look: Any) -> None:
    say(axes, x, y, text, **{"fontsize": 7.5, "linespacing": 1.3, "color": BLACK} | look)


def _forward_wires(axes: Axes) -> None:
    places = (-0.85, ERROR, CONTROLLER, LOOKUP, PLATE, FRICTION, FORCE, 13.75)
    ends = ((0.0, 0.17), (0.17, 0.98), (0.98, 0.98), (0.98, 0.98), (0.98, 0.98), (0.98, 0.17), (0.17, 0.0))
    names = ("", "$e$", "$u$", "", "$a$", "", "$f_a$")
    for k, ((after, before), name) in enumerate(zip(ends, names, strict=True)):
        start, stop = places[k] + after, places[k + 1] - before
        arrow(axes, (start, TOP), (stop, TOP))
        _signal(axes, (start + stop) / 2 if k < 6 else 13.45, TOP + 0.2, name)
    _sum(axes, ERROR, TOP)
    _sum(axes, FORCE, TOP)
    arrow(axes, (FORCE, TOP + 1.2), (FORCE, TOP + 0.17), BLUE)


def _feedback_wires(axes: Axes) -> None:
    axes.plot([TAP, TAP], [TOP, BOTTOM], color=BLACK, lw=0.9)
    axes.plot([TAP], [TOP], "o", ms=3, color=BLACK)
    arrow(axes, (TAP, BOTTOM), (NOISE + 0.17, BOTTOM))
    _sum(axes, NOISE, BOTTOM)
    arrow(axes, (NOISE, BOTTOM - 0.72), (NOISE, BOTTOM - 0.17), VERMILLION)
    arrow(axes, (NOISE - 0.17, BOTTOM), (SENSOR + 0.98, BOTTOM))
    axes.plot([SENSOR - 0.98, ERROR], [BOTTOM, BOTTOM], color=BLACK, lw=0.9, solid_capstyle="projecting")
    arrow(axes, (ERROR, BOTTOM), (ERROR, TOP - 0.17))
    _signal(axes, (SENSOR - 0.98 + ERROR) / 2, BOTTOM + 0.2, "$f_m$")
    _signal(axes, ERROR - 0.22, TOP - 0.36, "−")
