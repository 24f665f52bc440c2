"""How far a loop is from instability, read off its gain G on the unit circle."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.quantities import Array, Complex

_WIDTHS = np.sinh(np.linspace(-4.0, 4.0, 161))
"""Distances from a resonance in half widths, 0.05 apart at its peak."""
LoopGain = Callable[[Array], Complex]
"""Frequencies in Hz to G, complex."""


@dataclass(frozen=True)
class Margins:
    """Distances of the loop gain G from -1."""

    gain_margin: float
    """Factor on G nearest to 1 that puts it on -1; below 1 if less gain does it; infinite if none does."""
    phase_margin_deg: float
    """Phase of G above -180 degrees where |G| = 1, the smallest; infinite if |G| never is 1."""
    delay_margin_s: float
    """Further delay that makes a stable loop unstable, min(phase margin / angular frequency); 0 if it is unstable."""
    crossover_hz: float
    """Where |G| = 1 with that phase margin; NaN if nowhere."""
    phase_crossover_hz: float
    """Where G is real and negative with that gain margin; NaN if nowhere."""
    sensitivity_peak: float
    """Ms = max |1/(1 + G)| up to half the control rate; infinite if the loop is unstable."""
    modulus_margin: float
    """Smallest distance of G from -1, 1/Ms of a stable loop."""
    stable: bool
    """Whether the closed loop is stable (from its poles, not from the margins)."""


def search_grid(
    nyquist_hz: float, whole_periods: int, lowest_hz: float, around: Sequence[tuple[float, float]]
) -> Array:
    """Return frequencies in Hz, dense enough for the turns that a delay adds and for resonances (frequency, width)."""
    lowest = min(1e-6, lowest_hz / nyquist_hz)
    relative = np.geomspace(lowest, 1.0, math.ceil(600 * -math.log10(lowest)))
    even = np.linspace(0.0, 1.0, 100 * (whole_periods + 4))[1:]
    # G is real at the Nyquist frequency itself, so it is looked at apart.
    grid = np.union1d(relative, even)[:-1] * nyquist_hz
    near = np.array([centre + width * _WIDTHS for centre, width in around]).ravel()
    return np.union1d(grid, near[(near > grid[0]) & (near < nyquist_hz)])


def crossings(value: Callable[[Array], Array], grid: Array, on_grid: Array) -> Array:
    """Return the frequencies at which a real function of frequency changes sign, between grid points, refined.

    ``on_grid`` is the function there, which takes longest to compute.
    """
    positive = on_grid >= 0
    changes = np.flatnonzero(positive[1:] != positive[:-1])

    def scalar(frequency: float) -> float:
        return float(value(np.array([frequency]))[0])

    from scipy.optimize import brentq  # takes long to load: not for what is unstable

    return np.array([brentq(scalar, grid[i], grid[i + 1], xtol=1e-15 * grid[-1], rtol=1e-14) for i in changes])


def real_axis(value: LoopGain, grid: Array, on_grid: Complex, nyquist_hz: float) -> Array:
    """Return the frequencies at which a complex response is real, the Nyquist frequency included."""
    return np.append(crossings(lambda f: value(f).imag, grid, on_grid.imag), nyquist_hz)


def margins(loop_gain: LoopGain, grid: Array, nyquist_hz: float, stable: bool) -> Margins:
    """Return the margins of a sampled loop.

    Parameters
    ----------
    loop_gain
        G as a function of frequency in Hz.
    grid
        Rising frequencies in Hz below ``nyquist_hz`` between which G crosses the unit circle or the axis at most once.
    nyquist_hz
        Half the control rate.
    stable
        Whether the closed loop is stable.
    """
    full = np.append(grid, nyquist_hz)
    gains = loop_gain(full)
    gain_margin, phase_crossover_hz = _gain_margin(loop_gain, grid, gains[:-1], nyquist_hz)
    phase_margin, delay_margin_s, crossover_hz = _phase_margin(loop_gain, grid, gains[:-1])
    peak = _peak(loop_gain, full, gains)
    return Margins(
        gain_margin=gain_margin,
        phase_margin_deg=phase_margin,
        delay_margin_s=delay_margin_s if stable else 0.0,
        crossover_hz=crossover_hz,
        phase_crossover_hz=phase_crossover_hz,
        sensitivity_peak=peak if stable else math.inf,  # a number, too, but it would say nothing
        modulus_margin=1.0 / peak,
        stable=stable,
    )


def sensitivity_peak(loop_gain: LoopGain, grid: Array, nyquist_hz: float) -> float:
    """Return Ms of a stable loop alone, for the arguments of `margins`."""
    full = np.append(grid, nyquist_hz)
    return _peak(loop_gain, full, loop_gain(full))


def gain_factor(loop_gain: LoopGain, grid: Array, nyquist_hz: float, peak: float) -> float:
    """Return the factor k on G up to which Ms of a loop that is stable at little gain stays within a peak.

    It is the least of `gain_roots`: below it no |1 + k G| is smaller than 1/peak and none is 0, so no pole crosses the
    unit circle, and every smaller factor holds as well. Infinite if every factor does.
    """

    def root(frequency_hz: Array) -> Array:
        return gain_roots(loop_gain(frequency_hz), peak)

    full = np.append(grid, nyquist_hz)
    roots = root(full)
    least = int(np.argmin(roots))
    if math.isinf(roots[least]):
        return math.inf
    far = 2.0 * float(roots[least])  # what has no root is farther, for a search that wants numbers
    return min(_least_near(full, least, lambda f: min(far, float(root(np.array([f]))[0]))), float(roots[least]))


def gain_roots(gains: Complex, peak: ArrayLike) -> Array:
    """Return the least factor k on each G that takes |1 + k G| down to 1/peak, infinite where none does.

    |1 + k G|^2 = 1/peak^2 has its smaller root at k = (1 - 1/peak^2)/(-Re G + sqrt(Re^2 G - |G|^2 (1 - 1/peak^2))).
    """
    room = 1.0 - 1.0 / np.square(peak)
    inside = gains.real**2 - np.abs(gains) ** 2 * room
    there = (gains.real < 0) & (inside >= 0)
    return np.where(there, room / np.where(there, np.sqrt(np.maximum(inside, 0.0)) - gains.real, 1.0), np.inf)


def _gain_margin(loop_gain: LoopGain, grid: Array, gains: Complex, nyquist_hz: float) -> tuple[float, float]:
    frequency = real_axis(loop_gain, grid, gains, nyquist_hz)
    real = loop_gain(frequency).real
    frequency, real = frequency[real < 0], real[real < 0]
    if frequency.size == 0:
        return math.inf, math.nan
    nearest = np.argmin(np.abs(np.log(-real)))
    return float(-1.0 / real[nearest]), float(frequency[nearest])


def _phase_margin(loop_gain: LoopGain, grid: Array, gains: Complex) -> tuple[float, float, float]:
    frequency = crossings(lambda f: np.abs(loop_gain(f)) - 1.0, grid, np.abs(gains) - 1.0)
    if frequency.size == 0:
        return math.inf, math.inf, math.nan
    above = np.angle(-loop_gain(frequency))  # 0 where G = -1, in (-pi, pi]
    nearest = np.argmin(np.abs(above))
    further_s = np.mod(above, 2 * np.pi) / (2 * np.pi * frequency)
    return float(np.degrees(above[nearest])), float(np.min(further_s)), float(frequency[nearest])


def _peak(loop_gain: LoopGain, grid: Array, gains: Complex) -> float:
    def distance(frequency: float) -> float:
        return float(np.abs(1.0 + loop_gain(np.array([frequency]))[0]))

    distances = np.abs(1.0 + gains)
    nearest = int(np.argmin(distances))
    return 1.0 / min(_least_near(grid, nearest, distance), float(distances[nearest]))


def _least_near(grid: Array, k: int, value: Callable[[float], float]) -> float:
    """Return the least of a function of frequency between the neighbours of a grid point."""
    from scipy.optimize import minimize_scalar

    around = grid[max(k - 1, 0)], grid[min(k + 1, grid.size - 1)]
    return float(minimize_scalar(value, bounds=around, method="bounded", options={"xatol": 1e-9 * around[1]}).fun)
