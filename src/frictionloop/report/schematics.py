"""Fig. 1b, the block diagram of a System, and Fig. 3, one axis of the force sensor with its electronics."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, FancyBboxPatch, Polygon, Rectangle

from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILLION, arrow, say, schematic, styled
from frictionloop.hardware.sensor import springs
from frictionloop.hardware.sensor.front_end import capacitance_f
from frictionloop.parameters import FrictionLaw, LogSweep, Model, PiController, Sine, System
from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign
from frictionloop.report.number_text import number

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


UPPER, LOWER, MIDDLE = 5.3, 1.6, 3.45
"""Heights of the two sides and of what is common to them."""
AMPLIFIER, BANDPASS, MIXER, LOWPASS, DIFFERENCE, CONVERTER = 7.35, 9.6, 11.35, 12.95, 14.75, 16.4
"""Horizontal middles."""


def draw_circuit(axes: Axes, design: SensorDesign) -> None:
    """Draw the chain of both sides with the numbers of a design."""
    excitation = f"{number(design.excitation.amplitude_v)} V, {number(design.excitation.frequency_hz / 1e3)} kHz"
    for y, sign in ((UPPER, "+"), (LOWER, "−")):
        _side(axes, y, sign, design)
    say(axes, MIXER, MIDDLE - 0.27, f"excitation $V$\n{excitation}", linespacing=1.3)
    for y in (UPPER, LOWER):
        towards = 1 if y > MIDDLE else -1
        arrow(axes, (MIXER, MIDDLE - 0.27 + towards * 0.5), (MIXER, y - towards * 0.24), BLUE)
    # The inner frame carries the excitation.
    height = MIDDLE - 0.27
    axes.plot([MIXER - 1.0, 5.9, 5.9, 4.4], [height, height, 2.3, 2.3], color=BLUE, lw=1.0)
    arrow(axes, (4.6, 2.3), (3.97, 2.3), BLUE)
    say(axes, 7.7, height + 0.22, "to the inner frame")
    _common(axes, design)


def _side(axes: Axes, y: float, sign: str, design: SensorDesign) -> None:
    if sign == "+":
        axes.plot([4.21, 5.55, 5.55, AMPLIFIER - 0.6], [4.2, 4.2, y, y], color=ORANGE, lw=1.2)
    else:
        axes.plot([0.79, 0.2, 0.2, 5.55, 5.55, AMPLIFIER - 0.6], [3.0, 3.0, 0.42, 0.42, y, y], color=ORANGE, lw=1.2)
    _amplifier(axes, y, design)
    tuned = f"{number(design.excitation.frequency_hz / 1e3)} kHz, Q {number(design.filters.bandpass_q)}"
    _stage(axes, BANDPASS, y, 1.75, "band-pass", tuned)
    _node(axes, MIXER, y, "×")
    _stage(axes, LOWPASS, y, 1.55, "low-pass", f"{number(design.filters.cutoff_hz / 1e3)} kHz")
    arrow(axes, (AMPLIFIER + 0.55, y), (BANDPASS - 0.875, y))
    arrow(axes, (BANDPASS + 0.875, y), (MIXER - 0.24, y))
    arrow(axes, (MIXER + 0.24, y), (LOWPASS - 0.775, y))
    axes.plot([LOWPASS + 0.775, DIFFERENCE], [y, y], color=BLACK, lw=0.9)
    arrow(axes, (DIFFERENCE, y), (DIFFERENCE, MIDDLE + (0.24 if y > MIDDLE else -0.24)))
    say(axes, DIFFERENCE + 0.2, (y + MIDDLE) / 2, sign, fontsize=9, ha="left")
    say(axes, (LOWPASS + DIFFERENCE) / 2 + 0.38, y + 0.22, f"$V_{sign}$", fontsize=8)


def _amplifier(axes: Axes, y: float, design: SensorDesign) -> None:
    a = design.amplifier
    corners = [(AMPLIFIER - 0.6, y - 0.5), (AMPLIFIER - 0.6, y + 0.5), (AMPLIFIER + 0.55, y)]
    axes.add_patch(Polygon(corners, fc="white", ec=BLACK, lw=0.9))
    before, behind = AMPLIFIER - 0.85, AMPLIFIER + 0.8
    axes.plot([before, before, behind, behind], [y, y + 0.85, y + 0.85, y], color=BLACK, lw=0.9)
    axes.add_patch(Rectangle((AMPLIFIER - 0.35, y + 0.72), 0.6, 0.26, fc="white", ec=BLACK, lw=0.8))
    say(axes, AMPLIFIER - 0.05, y + 1.25, f"{number(a.feedback_pf)} pF ∥ {number(a.feedback_mohm)} MΩ")
    say(axes, AMPLIFIER - 0.05, y - 0.78, "charge amplifier", color=GREY, style="italic")


def _common(axes: Axes, design: SensorDesign) -> None:
    ratio = design.readout.form == "ratio"
    _node(axes, DIFFERENCE, MIDDLE, "÷" if ratio else "Σ")
    arrow(axes, (DIFFERENCE + 0.24, MIDDLE), (CONVERTER - 0.775, MIDDLE))
    bits, span = number(design.adc.bits), number(design.adc.range_n)
    _stage(axes, CONVERTER, MIDDLE, 1.55, "converter", f"{bits} bit, ±{span} N")
    say(axes, DIFFERENCE + 0.5, MIDDLE - 0.27, "$V_s$", fontsize=8)
    arrow(axes, (CONVERTER + 0.775, MIDDLE), (CONVERTER + 1.75, MIDDLE))
    say(axes, CONVERTER + 1.35, MIDDLE + 0.22, "$f_m$", fontsize=8)


def _stage(axes: Axes, x: float, y: float, width: float, title: str, words: str) -> None:
    axes.add_patch(Rectangle((x - width / 2, y - 0.45), width, 0.9, fc="white", ec=BLACK, lw=0.9))
    say(axes, x, y + 0.17, title, weight="bold")
    say(axes, x, y - 0.17, words)


def _node(axes: Axes, x: float, y: float, sign: str) -> None:
    axes.add_patch(Circle((x, y), 0.24, fc="white", ec=BLACK, lw=0.9))
    say(axes, x, y - 0.01, sign, fontsize=9)


METAL, GLASS = "#dcdcdc", "#eaf4fb"
LEFT, RIGHT, BELOW, ABOVE = 1.05, 3.95, 1.7, 5.3
"""Edges of the inner frame, in units of the drawing."""


@styled
def figure_sensor(design: SensorDesign) -> Figure:
    """Return frame, springs and electrodes on the left, the electronics of one axis on the right."""
    figure, axes = schematic(9.2, 4.5, (-0.15, 18.25), (-1.0, 7.9))
    _frames(axes, design)
    _springs(axes, design)
    _electrodes(axes, design)
    _words(axes, design)
    draw_circuit(axes, design)
    return figure


def _frames(axes: Axes, design: SensorDesign) -> None:
    axes.add_patch(Rectangle((0, 0.2), 5, 6.6, fc=METAL, ec=GREY, lw=0.8))
    axes.add_patch(Rectangle((0.4, 0.65), 4.2, 5.7, fc="white", ec=GREY, lw=0.8))
    axes.add_patch(Rectangle((LEFT, BELOW), RIGHT - LEFT, ABOVE - BELOW, fc=METAL, ec=BLACK, lw=0.9))
    axes.add_patch(Rectangle((LEFT + 0.3, BELOW + 0.3), 2.3, 3.0, fc=GLASS, ec=GREY, lw=0.7))
    say(axes, 2.5, 4.25, "glass plate and\ninner frame", fontsize=7.5)
    say(axes, 2.5, 3.5, f"{number(design.moving.mass_kg)} kg", fontsize=8, weight="bold")
    axes.annotate("", (3.45, 2.85), (1.55, 2.85), arrowprops={"arrowstyle": "-|>", "lw": 1.4, "color": VERMILLION})
    say(axes, 2.5, 2.45, "friction $f_a$,\nmotion $x$", color=BLACK)


def _springs(axes: Axes, design: SensorDesign) -> None:
    """Draw four leaves between the frames: one per side, or two above and two below if all are turned alike."""
    if design.springs.arrangement == "around":
        ends = [((1.6, 6.35), (1.6, ABOVE)), ((3.4, 0.65), (3.4, BELOW))]
        ends += [((0.4, 5.0), (LEFT, 5.0)), ((4.6, 2.0), (RIGHT, 2.0))]
    else:
        ends = [((x, outer), (x, inner)) for x in (1.5, 3.5) for outer, inner in ((6.35, ABOVE), (0.65, BELOW))]
    for outer, inner in ends:
        _leaf(axes, np.array(outer), np.array(inner), design)


def _leaf(axes: Axes, start: np.ndarray, stop: np.ndarray, design: SensorDesign) -> None:
    """Draw a leaf from the outer to the inner frame: an arc of the design's own angle, or a straight one."""
    chord = stop - start
    half = math.radians(design.springs.angle_deg) / 2 if isinstance(design.springs, ArcSprings) else 1e-3
    p = np.linspace(-half, half, 60)
    along, across = (np.sin(p) / np.sin(half) + 1) / 2, (np.cos(p) - np.cos(half)) / (2 * np.sin(half))
    normal = np.array([-chord[1], chord[0]])
    line = start + np.outer(along, chord) + np.outer(across, normal)
    axes.plot(line[:, 0], line[:, 1], color=BLUE, lw=2.2, solid_capstyle="butt")


def _electrodes(axes: Axes, design: SensorDesign) -> None:
    for edge, side, sign in ((LEFT, -1, "−"), (RIGHT, 1, "+")):
        plate = edge + side * 0.17
        axes.add_patch(Rectangle((min(plate, plate + side * 0.09), 2.6), 0.09, 1.8, fc=ORANGE, ec="none"))
        say(axes, edge + side * 0.46, 3.75, f"$q_{sign}$", fontsize=8)
    gap = number(design.electrodes.gap_um)
    axes.plot([0.97, 1.3], [2.7, 1.5], color=GREY, lw=0.6)
    say(axes, 1.45, 1.18, f"gap $e_±$ = {gap} µm,\n{number(design.electrodes.area_mm2)} mm² each")


def _words(axes: Axes, design: SensorDesign) -> None:
    stiffness, leaves = springs.stiffness(design.springs).x_n_per_m, design.springs
    travel_um = springs.travel_m(design) * 1e6
    shape = (
        f"{leaves.count} arcs, {number(leaves.angle_deg)}°, R {number(leaves.radius_mm)} mm"
        if isinstance(leaves, ArcSprings)
        else f"{leaves.count} straight leaves, {number(leaves.length_mm)} mm"
    )
    say(axes, 2.5, 7.5, "outer frame, fixed", fontsize=7.5, color=GREY, style="italic")
    say(axes, 2.5, 7.07, f"{shape}, {number(leaves.thickness_mm)} × {number(leaves.width_mm)} mm", fontsize=7.5)
    resonance = f"$k$ = {stiffness * 1e-6:.2f} N/µm, resonance {number(springs.resonance_hz(design))} Hz"
    say(axes, 2.5, -0.12, resonance, fontsize=7.5)
    rest = capacitance_f(design)
    farads = f"{number(math.sqrt(rest.plus * rest.minus) * 1e12)} pF at rest"
    say(axes, 2.5, -0.58, f"{number(travel_um)} µm at {number(design.load.range_n)} N, {farads}", fontsize=7.5)
