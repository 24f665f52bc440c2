"""Draw docs/_static/frontpage.svg: the idea, and one finger with the loop open and with the loop closed.

Run from the root of the repository: python docs/make_frontpage.py
"""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, FancyBboxPatch, Rectangle

import frictionloop as fl
from frictionloop.figures.style import BLUE, VERMILLION, new_figure, styled, svg

SILVER = "#b3b3b3"
MOVING = """<style>
#frontpage-cover0, #frontpage-cover1 { transform-box: fill-box; animation: sweep 8s linear infinite; }
#frontpage-finger { animation: slide 4s ease-in-out infinite alternate; }
@keyframes sweep { from { transform: none; } 85%, to { transform: translateX(100%); } }
@keyframes slide { from { transform: translateX(-14px); } to { transform: translateX(10px); } }
@media (prefers-reduced-motion: reduce) { #frontpage-cover0, #frontpage-cover1 { display: none; } #frontpage-finger { animation: none; } }
</style>
"""
"""The traces appear as time goes on, while the finger strokes; readers who want no motion see all at once."""
ARROW = {"arrowstyle": "-|>", "color": "0.25", "linewidth": 1.2, "mutation_scale": 11}


def opened(run: xr.Dataset) -> xr.Dataset:
    """Return a run with f_a as it is without feedback: the lookup table alone, set for this finger's mean friction."""
    system = fl.system_of(run)
    plant = fl.Stepper(system)
    commands_um = fl.amplitude_for(run.f_r.values - run.d.values.mean(), system.friction)
    amplitudes_um = np.empty(commands_um.size)
    for k, command_um in enumerate(commands_um):
        amplitudes_um[k] = plant.amplitude_um
        plant.tick(command_um)
    force_n = fl.friction_force(amplitudes_um, system.friction) + run.d.values
    return run.assign(f_a=("time", force_n))


def sketch(axes: Axes) -> None:
    """Draw the idea: a finger slides on glass that vibrates; its friction is measured, compared and corrected."""
    axes.set(xlim=(0, 100), ylim=(0, 26), aspect="equal")
    axes.axis("off")
    x = np.linspace(2, 48, 400)
    wave = 0.5 * np.sin(2 * np.pi * x / 4)
    axes.fill_between(x, 8.6 + wave, 10.8 + wave, color="#cfe4f2", edgecolor=BLUE, linewidth=1.0)
    finger = Ellipse((27, 16.2), 19, 9.6, angle=28, facecolor="#f3d3bd", edgecolor="#8a5a3b", linewidth=1.0)
    axes.add_patch(finger).set_gid("finger")
    axes.annotate("", (10, 14.5), (18, 14.5), arrowprops=ARROW | {"color": VERMILLION})
    axes.text(9, 16, "friction", color=VERMILLION, ha="center")
    axes.annotate("", (48, 21.5), (38, 21.5), arrowprops=ARROW | {"color": "0.4"})
    axes.text(43, 23, "slides", color="0.35", ha="center")
    for foot in (6, 44):
        zigzag = np.linspace(8, 3.4, 9)
        axes.plot(foot + 1.1 * np.where(np.arange(9) % 2, 1, -1), zigzag, color="0.4", linewidth=1.0)
    axes.plot([2, 48], [3, 3], color="0.4", linewidth=1.4)
    axes.text(25, 5.2, "glass on springs", color="0.35", ha="center", va="center")
    for left, words, colour in ((58, "measure\nthe force", BLUE), (80, "compare with the\nforce asked for", BLUE)):
        box = FancyBboxPatch((left, 3.5), 17, 7, boxstyle="round,pad=0.6", facecolor="white", edgecolor=colour)
        axes.add_patch(box)
        axes.text(left + 8.5, 7, words, ha="center", va="center")
    axes.annotate("", (57, 7), (49, 7), arrowprops=ARROW)
    axes.annotate("", (79, 7), (76, 7), arrowprops=ARROW)
    axes.plot([88.5, 88.5, 56], [11.5, 17, 17], color=ARROW["color"], linewidth=1.2)
    axes.annotate("", (49, 11), (56.2, 17.1), arrowprops=ARROW)
    axes.text(72, 18.3, "vibrate more, or less", ha="center")


@styled
def front_page() -> Figure:
    """Return the figure: the idea, then the open loop above the closed one."""
    closed = fl.simulate(fl.feasible(), duration_s=3.0)
    figure = new_figure(7.0, 5.8)
    top, *panels = figure.subplots(3, height_ratios=(1.15, 1, 1))
    sketch(top)
    panels[0].sharex(panels[1])
    panels[0].tick_params(labelbottom=False)
    cases = [("Open loop", opened(closed), VERMILLION), ("Closed loop", closed, BLUE)]
    for i, (axes, (title, run, colour)) in enumerate(zip(panels, cases, strict=True)):
        axes.plot(run.time, run.f_r, color=SILVER, linewidth=3.0, label="asked for, $f_r$")
        axes.plot(run.time, run.f_a, color=colour, linewidth=1.2, label="on the finger, $f_a$")
        axes.set_title(f"{title}: rms error {fl.rms_error(run) * 1e3:.0f} mN, $R^2$ {fl.r2_identity(run):.2f}")
        axes.set(ylabel="force (N)", xlim=(0, 3), ylim=(0.2, 1.0))
        axes.add_patch(Rectangle((0, 0.2), 3.0, 0.8, facecolor="white", zorder=4)).set_gid(f"cover{i}")
        axes.legend(loc="upper right", ncols=2, borderaxespad=0).set_zorder(5)
    panels[1].set_xlabel("time (s)")
    return figure


if __name__ == "__main__":
    target = Path(__file__).parent / "_static" / "frontpage.svg"
    target.parent.mkdir(exist_ok=True)
    still = svg(front_page(), "frontpage")
    target.write_text(still.replace("</defs>\n", f"</defs>\n{MOVING}", 1), encoding="utf-8")
    print(target)
