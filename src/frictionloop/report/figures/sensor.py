"""Fig. 3: the force sensor as a schematic of one axis, drawn from a SensorDesign."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, VERMILLION, say, schematic, styled
from frictionloop.hardware.sensor import springs
from frictionloop.hardware.sensor.electrodes import capacitance_f
from frictionloop.parameters.sensor_design import ArcSprings, SensorDesign
from frictionloop.report.figures.circuit import draw_circuit
from frictionloop.report.numbers import number

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
