"""The lookup table from data: which amplitude leaves which force, as a monotone curve and no formula."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.optimize import isotonic_regression

from frictionloop.identification.vibrated import Vibrated
from frictionloop.quantities import must_be
from frictionloop.quantities.checks import whole

Array = NDArray[np.float64]
BINS = 12
"""Stretches of the amplitude over each of which pieces are averaged (assumed: enough for a curve with one bend)."""
LEAST_PER_BIN = 3
LEAST_FALL = 1e-4
"""Least fall of log friction from stretch to stretch, so that each force has one amplitude."""


class MonotoneTable(NamedTuple):
    """Amplitude squared over force, at even forces, as ``controller.model`` has its table."""

    force_n: Array
    """From the lowest to f0."""
    square_um2: Array
    """a^2, falling to 0."""
    gaussian_n: float
    """Largest difference in force from equation (1) with the fitted f0 and tau, in N."""

    def overrides(self) -> dict[str, object]:
        """Return what a System's controller believes: f0, tau through the table's end, and the table."""
        f0, floor, largest = float(self.force_n[-1]), float(self.force_n[0]), float(self.square_um2[0])
        return {
            "controller.model.nominal_n": f0,
            "controller.model.max_amplitude_um": largest**0.5,
            "controller.model.susceptibility_per_um2": float(np.log(f0 / floor) / largest),
            "controller.model.table_size": self.square_um2.size,
            "controller.model.table_um2": (*(float(f"{each:.6g}") for each in self.square_um2[:-1]), 0.0),
        }


def monotone_table(found: Vibrated, entries: int = 33) -> MonotoneTable:
    """Return the table a^2(u) that the recordings themselves give.

    The mean of log share over twelve stretches of amplitude is made falling by isotonic regression (pool adjacent
    violators), joined from (0, 0) on by a monotone cubic (Fritsch and Carlson 1980), and inverted.

    Parameters
    ----------
    found : Vibrated
        From `vibrated`.
    entries : int
        Entries of the table, 2 to 1025.

    Raises
    ------
    FrictionloopError
        For a number of entries out of range, or amplitudes in fewer than four stretches.
    """
    whole("entries", entries, 2, 1025)
    edges = np.linspace(0.0, found.largest_um, BINS + 1)
    which = np.clip(np.digitize(found.amplitude_um, edges) - 1, 0, BINS - 1)
    rows = [which == k for k in range(BINS) if np.count_nonzero(which == k) >= LEAST_PER_BIN]
    if len(rows) < 4:
        raise must_be(f"recording: stretches of {BINS} with amplitudes", len(rows), "at least 4")
    middle = np.array([float(np.sqrt(np.mean(found.amplitude_um[row] ** 2))) for row in rows])
    weight = np.array([float(np.count_nonzero(row)) for row in rows])
    falling = isotonic_regression(
        [float(found.log_share[row].mean()) for row in rows], weights=weight, increasing=False
    )
    share = np.minimum(falling.x, 0.0) - LEAST_FALL * np.arange(1, len(rows) + 1)
    if middle[0] < 1e-3 * found.largest_um:
        middle, share = middle[1:], share[1:]
    curve = PchipInterpolator(np.concatenate([[0.0], middle**2]), np.concatenate([[0.0], share]))
    squares = np.linspace(0.0, float(middle[-1]) ** 2, 2001)
    f0 = found.nominal.value
    forces = f0 * np.exp(curve(squares))
    wanted = np.linspace(forces[-1], f0, entries)
    table = np.interp(wanted, forces[::-1], squares[::-1])
    table[-1] = 0.0
    apart = float(np.max(np.abs(forces - f0 * np.exp(-found.susceptibility.value * squares))))
    return MonotoneTable(wanted, table, apart)
