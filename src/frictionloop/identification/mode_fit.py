"""Damped oscillations fitted to decays: which poles start the fit, and what they leave."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from frictionloop.identification.poles import Pole
from frictionloop.identification.ring_down import damped

Array = NDArray[np.float64]

MOST_MODES = 8
STABLE_AT = 3
"""At so many orders in a row a pole must be stable to be a mode (assumed)."""
LEAST_SHARE = 0.01
"""Share of the energy of a decay below which a mode is not counted (assumed)."""
LEAST_Q = 2.0


def left_of(decay: Array, starts: Sequence[tuple[float, float]], rate_hz: float) -> float:
    """Return what modes as they stand leave of a decay, as a share of its rms."""
    shape = damped(np.arange(decay.size) / rate_hz, starts)
    rest = decay - shape @ np.linalg.lstsq(shape, decay, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(decay - decay.mean()))


def lasting(diagram: Sequence[Pole]) -> list[tuple[float, float]]:
    """Return frequency and Q of the poles that are stable at several orders in a row, from the lowest up."""
    stable = [pole for pole in diagram if pole.stable and pole.q > LEAST_Q]
    groups: list[list[Pole]] = []
    for pole in sorted(stable, key=lambda each: each.frequency_hz):
        if groups and pole.frequency_hz <= groups[-1][-1].frequency_hz * 1.01:
            groups[-1].append(pole)
        else:
            groups.append([pole])
    kept = []
    for group in groups:
        orders = sorted({pole.order for pole in group})
        runs = np.split(np.array(orders), np.flatnonzero(np.diff(orders) > 1) + 1)
        if max(run.size for run in runs) >= STABLE_AT:
            kept.append((float(np.median([p.frequency_hz for p in group])), float(np.median([p.q for p in group]))))
    return kept


def strong(decays: Sequence[Array], starts: Sequence[tuple[float, float]], rate_hz: float) -> list[tuple[float, float]]:
    """Return the modes that have a part in the energy, at most eight."""
    shares = np.mean([_shares(decay, starts, rate_hz) for decay in decays], axis=0)
    order = np.argsort(shares)[::-1][:MOST_MODES]
    kept = sorted(int(k) for k in order if shares[k] >= LEAST_SHARE)
    return [starts[k] for k in kept] or [starts[int(np.argmax(shares))]]


def _shares(decay: Array, starts: Sequence[tuple[float, float]], rate_hz: float) -> Array:
    shape = damped(np.arange(decay.size) / rate_hz, starts)
    weight = np.linalg.lstsq(shape, decay, rcond=None)[0]
    parts = [float(np.sum((shape[:, k : k + 2] @ weight[k : k + 2]) ** 2)) for k in range(1, shape.shape[1], 2)]
    return np.array(parts) / max(sum(parts), 1e-300)


def fit_decay(decay: Array, starts: Sequence[tuple[float, float]], rate_hz: float) -> Array:
    """Return frequency, Q and share of each mode of one hit, and in a last row the misfit, shape (modes + 1, 3)."""
    time = np.arange(decay.size) / rate_hz
    guess = np.log(np.array(starts)).ravel()

    def pairs(x: Array) -> list[tuple[float, float]]:
        return [(float(a), float(b)) for a, b in np.exp(np.clip(x, -20, 20)).reshape(-1, 2)]

    def left(x: Array) -> Array:
        shape = damped(time, pairs(x))
        # By the normal equations, many times faster than by singular values; the columns are far from dependent.
        weight = np.linalg.lstsq(shape.T @ shape, shape.T @ decay, rcond=1e-12)[0]
        return np.asarray(shape @ weight - decay)

    fit = least_squares(left, guess, x_scale=np.tile([1e-3, 1e-2], len(starts)), xtol=1e-7, ftol=1e-9, max_nfev=25)
    shares = _shares(decay, pairs(fit.x), rate_hz)
    misfit = float(np.linalg.norm(fit.fun) / np.linalg.norm(decay - decay.mean()))
    rows = [(hertz, q, share) for (hertz, q), share in zip(pairs(fit.x), shares, strict=True)]
    return np.array([*rows, (misfit, 0.0, 0.0)])
