"""The block diagram of the bench, drawn with the report's blocks from `fl.bench()` when the pages are built."""

from __future__ import annotations

from pathlib import Path

from matplotlib.axes import Axes
from matplotlib.figure import Figure

import frictionloop as fl
from frictionloop.figures.style import BLACK, BLUE, GREY, arrow, schematic, styled, svg
from frictionloop.report.schematics import _block, _box, _signal, _sum

FILE = "_build/figures/bench-diagram.svg"
TOP, BOTTOM, OVER = 3.4, 0.9, 5.85
"""Heights of the forward path, of the feedback path, and of what moves."""
CONTROLLER, LOOKUP, PLATE, LIMIT, SKIN = 3.0, 5.4, 7.8, 10.2, 12.6
CONVERTER, DEMODULATOR, SPRINGS = 5.4, 7.8, 10.2
ERROR, TAP = 1.45, 14.1


def image(source: Path) -> str:
    """Draw the diagram and return the Markdown that shows it."""
    file = source / FILE
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(svg(figure_bench(fl.bench()), "bench-diagram"), encoding="utf-8")
    return f"![Block diagram of the bench: controller, plate, finger and sensor in a loop]({FILE})"


@styled
def figure_bench(system: fl.System) -> Figure:
    """Return the loop with the numbers of a bench in its blocks."""
    figure, axes = schematic(9.0, 4.3, (-0.2, 14.9), (-0.15, 6.75))
    _groups(axes)
    control, plate, sensor = system.controller, system.plate, system.sensor
    friction, skin, motion = system.friction, system.finger, system.motion
    gains = [f"$K_p$ = {control.kp:g}", f"$K_i$ = {control.ki:g} s⁻¹", f"{control.rate_hz / 1e3:g} kHz"]
    _block(axes, CONTROLLER, TOP, "controller", gains)
    late = f"{control.delay_s * 1e6:g} µs late"
    _block(axes, LOOKUP, TOP, "lookup table", [f"believes {control.model.nominal_n:g} N", late])
    resonance = f"{plate.frequency_hz / 1e3:g} kHz, Q {plate.q:g}"
    _block(axes, PLATE, TOP, "plate", [resonance, f"≤ {plate.max_amplitude_um:g} µm"])
    _block(axes, LIMIT, TOP, "friction limit", [f"$f_0$ = {friction.nominal_n:g} N,", "moisture, place"])
    spring = f"{skin.stiffness_n_m / 1e3:g} N/mm"
    _block(axes, SKIN, TOP, "skin, contact", [spring, f"slips in {skin.slip_length_um:g} µm"])
    stroke = f"{motion.speed_mm_s:g} mm/s, {motion.load_n:g} N"
    _block(axes, LIMIT, OVER, "stroke", [stroke, "tremor, drift"])
    _block(
        axes,
        SPRINGS,
        BOTTOM,
        "springs",
        [f"{sensor.moving_mass_kg:g} kg", f"{sensor.resonance_hz:g} Hz, Q {sensor.q:g}"],
    )
    _block(axes, DEMODULATOR, BOTTOM, "electronics", [f"{sensor.cutoff_hz:g} Hz low-pass,", "noise"])
    _block(axes, CONVERTER, BOTTOM, "converter", [f"{sensor.adc_bits} bit,", f"±{sensor.range_n:g} N"])
    _wires(axes)
    return figure


def _groups(axes: Axes) -> None:
    for left, right, name, y in (
        (1.9, 6.5, "microcontroller", TOP),
        (6.7, 8.9, "plate", TOP),
        (9.1, 13.7, "finger", TOP),
        (4.3, 11.3, "force sensor", BOTTOM),
    ):
        _box(axes, left, y - 0.78, right - left, 1.56, fc="#f5f5f5", ec="none")
        axes.text(left + 0.12, y - 0.97, name, color=GREY, fontsize=7.5, ha="left", va="center", style="italic")


def _wires(axes: Axes) -> None:
    half = 0.98
    arrow(axes, (-0.1, TOP), (ERROR - 0.17, TOP))
    _signal(axes, 0.55, TOP + 0.22, "$f_r$")
    _sum(axes, ERROR, TOP)
    arrow(axes, (ERROR + 0.17, TOP), (CONTROLLER - half, TOP))
    for one, two, name in (
        (CONTROLLER, LOOKUP, "$u$"),
        (LOOKUP, PLATE, ""),
        (PLATE, LIMIT, "$a$"),
        (LIMIT, SKIN, ""),
    ):
        arrow(axes, (one + half, TOP), (two - half, TOP))
        _signal(axes, (one + two) / 2, TOP + 0.22, name)
    arrow(axes, (SKIN + half, TOP), (14.85, TOP))
    _signal(axes, 14.5, TOP + 0.22, "$f_a$")
    arrow(axes, (LIMIT, OVER - 0.58), (LIMIT, TOP + 0.58), BLUE)
    _signal(axes, LIMIT + 0.12, (OVER + TOP) / 2, "place, speed, load", ha="left", color=BLUE)
    axes.plot([LIMIT + half, SKIN], [OVER, OVER], color=BLUE, lw=0.9, solid_capstyle="projecting")
    arrow(axes, (SKIN, OVER), (SKIN, TOP + 0.58), BLUE)
    _signal(axes, SKIN - 0.1, OVER + 0.22, "speed", ha="right", color=BLUE)
    axes.plot([LIMIT - half, CONTROLLER], [OVER, OVER], color=BLUE, lw=0.9, solid_capstyle="projecting")
    arrow(axes, (CONTROLLER, OVER), (CONTROLLER, TOP + 0.58), BLUE)
    _signal(
        axes, (LIMIT - half + CONTROLLER) / 2, OVER + 0.22, "position sensor and load cells: is it sliding?", color=BLUE
    )
    axes.plot([TAP, TAP], [TOP, BOTTOM], color=BLACK, lw=0.9)
    axes.plot([TAP], [TOP], "o", ms=3, color=BLACK)
    arrow(axes, (TAP, BOTTOM), (SPRINGS + half, BOTTOM))
    arrow(axes, (SPRINGS - half, BOTTOM), (DEMODULATOR + half, BOTTOM))
    arrow(axes, (DEMODULATOR - half, BOTTOM), (CONVERTER + half, BOTTOM))
    axes.plot([CONVERTER - half, ERROR], [BOTTOM, BOTTOM], color=BLACK, lw=0.9, solid_capstyle="projecting")
    arrow(axes, (ERROR, BOTTOM), (ERROR, TOP - 0.17))
    _signal(axes, 2.9, BOTTOM + 0.22, "$f_m$")
    _signal(axes, ERROR - 0.22, TOP - 0.36, "−")
