"""Fig. 1a: friction against amplitude over sliding trials."""

from __future__ import annotations

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from frictionloop.parameters import FrictionLimit
from frictionloop.physics.friction import friction_force
from frictionloop.report.style import BLACK, BLUE, GREY, new_figure, styled

BINS_UM = np.linspace(0.0, 2.5, 11)
EVERY = 4
"""Of the samples of a trial, one in four is drawn."""


def binned(trials: xr.Dataset) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return bin centres in um, mean and standard deviation of the force in N over all trials."""
    within = np.clip(np.digitize(trials["a"].values, BINS_UM) - 1, 0, len(BINS_UM) - 2)
    forces = [trials["f"].values[:, within == k].ravel() for k in range(len(BINS_UM) - 1)]
    centres = (BINS_UM[1:] + BINS_UM[:-1]) / 2
    return centres, np.array([f.mean() for f in forces]), np.array([f.std() for f in forces])


@styled
def figure_population(trials: xr.Dataset, nominal: FrictionLimit) -> Figure:
    """Return the forces of all trials in grey, their mean and standard deviation in black, equation (1) in blue."""
    figure = new_figure()
    axes = figure.subplots()
    lines = axes.plot(trials["a"].values[::EVERY], trials["f"].values[:, ::EVERY].T, color=GREY, alpha=0.4, lw=0.5)
    lines[0].set_label("one trial")
    centres, mean, spread = binned(trials)
    axes.errorbar(centres, mean, spread, fmt="o-", color=BLACK, capsize=3, lw=1.2, label="mean ± SD of the trials")
    curve = np.linspace(0, 2.5, 200)
    axes.plot(curve, friction_force(curve, nominal), "--", color=BLUE, label="eq. (1) with $d = 0$, as printed")
    axes.set(xlabel="vibration amplitude $a$ (µm)", ylabel="friction force $f$ (N)", xlim=(-0.03, 2.53), ylim=(0, None))
    axes.set_title(f"{trials.sizes['trial']} synthetic sliding trials")
    axes.legend(loc="upper right")
    return figure
