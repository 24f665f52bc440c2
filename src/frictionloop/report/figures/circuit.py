"""The electronics of Fig. 3: two charge amplifiers, filters, demodulators, their difference and the converter."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.patches import Circle, Polygon, Rectangle

from frictionloop.figures.style import BLACK, BLUE, GREY, ORANGE, arrow, say
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.report.numbers import number

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
    _excited(axes)
    _common(axes, design)


def _excited(axes: Axes) -> None:
    """The inner frame carries the excitation."""
    height = MIDDLE - 0.27
    axes.plot([MIXER - 1.0, 5.9, 5.9, 4.4], [height, height, 2.3, 2.3], color=BLUE, lw=1.0)
    arrow(axes, (4.6, 2.3), (3.97, 2.3), BLUE)
    say(axes, 7.7, height + 0.22, "to the inner frame")


def _side(axes: Axes, y: float, sign: str, design: SensorDesign) -> None:
    if sign == "+":
        axes.plot([4.21, 5.55, 5.55, AMPLIFIER - 0.6], [4.2, 4.2, y, y], color=ORANGE, lw=1.2)
    else:
        axes.plot([0.79, 0.2, 0.2, 5.55, 5.55, AMPLIFIER - 0.6], [3.0, 3.0, 0.42, 0.42, y, y], color=ORANGE, lw=1.2)
    _amplifier(axes, y, design)
    tuned = f"{number(design.excitation.frequency_hz / 1e3)} kHz, Q {number(design.filters.bandpass_q)}"
    _box(axes, BANDPASS, y, 1.75, "band-pass", tuned)
    _circle(axes, MIXER, y, "×")
    _box(axes, LOWPASS, y, 1.55, "low-pass", f"{number(design.filters.cutoff_hz / 1e3)} kHz")
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
    _circle(axes, DIFFERENCE, MIDDLE, "÷" if ratio else "Σ")
    arrow(axes, (DIFFERENCE + 0.24, MIDDLE), (CONVERTER - 0.775, MIDDLE))
    bits, span = number(design.adc.bits), number(design.adc.range_n)
    _box(axes, CONVERTER, MIDDLE, 1.55, "converter", f"{bits} bit, ±{span} N")
    say(axes, DIFFERENCE + 0.5, MIDDLE - 0.27, "$V_s$", fontsize=8)
    arrow(axes, (CONVERTER + 0.775, MIDDLE), (CONVERTER + 1.75, MIDDLE))
    say(axes, CONVERTER + 1.35, MIDDLE + 0.22, "$f_m$", fontsize=8)


def _box(axes: Axes, x: float, y: float, width: float, title: str, words: str) -> None:
    axes.add_patch(Rectangle((x - width / 2, y - 0.45), width, 0.9, fc="white", ec=BLACK, lw=0.9))
    say(axes, x, y + 0.17, title, weight="bold")
    say(axes, x, y - 0.17, words)


def _circle(axes: Axes, x: float, y: float, sign: str) -> None:
    axes.add_patch(Circle((x, y), 0.24, fc="white", ec=BLACK, lw=0.9))
    say(axes, x, y - 0.01, sign, fontsize=9)
