"""Draw docs/_static/frontpage.svg: one finger and one set-point, with the loop open and with the loop closed.

Run from the root of the repository: python docs/make_frontpage.py
"""

from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import frictionloop as fl
from frictionloop.report.style import BLUE, VERMILLION, new_figure, styled, svg

SILVER = "#b3b3b3"


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


@styled
def front_page() -> Figure:
    """Return the figure, the open loop above the closed one."""
    closed = fl.simulate(fl.feasible(), duration_s=3.0)
    figure = new_figure(8.0, 4.2)
    panels = figure.subplots(2, sharex=True, sharey=True)
    cases = [("Open loop", opened(closed), VERMILLION), ("Closed loop", closed, BLUE)]
    for axes, (title, run, colour) in zip(panels, cases, strict=True):
        axes.plot(run.time, run.f_r, color=SILVER, linewidth=3.0, label="force asked for, $f_r$")
        axes.plot(run.time, run.f_a, color=colour, linewidth=1.2, label="force on the finger, $f_a$")
        axes.set_title(f"{title}: rms error {fl.rms_error(run) * 1e3:.0f} mN, $R^2$ {fl.r2_identity(run):.2f}")
        axes.set(ylabel="force (N)", xlim=(0, 3), ylim=(0.2, 1.0))
        axes.legend(loc="upper right", ncols=2, borderaxespad=0)
    panels[1].set_xlabel("time (s)")
    return figure


if __name__ == "__main__":
    target = Path(__file__).parent / "_static" / "frontpage.svg"
    target.parent.mkdir(exist_ok=True)
    target.write_text(svg(front_page(), "frontpage"), encoding="utf-8")
    print(target)
