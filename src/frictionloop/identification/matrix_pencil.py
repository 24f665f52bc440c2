"""Poles that several decays share: the matrix pencil, at rising orders, and the damped oscillations that they start."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from frictionloop.quantities import Array

NEAR_HZ, NEAR_Q = 0.01, 0.3
"""A pole is stable if at the order below there is one as near in frequency and in Q, as shares (assumed)."""

MOST_MODES = 8
STABLE_AT = 3
"""At so many orders in a row a pole must be stable to be a mode (assumed)."""
LEAST_SHARE = 0.01
"""Share of the energy of a decay below which a mode is not counted (assumed)."""
LEAST_Q = 2.0
MOST_POLES = 10
"""Modes, and weak ones beside them."""
TRIED = 6
"""Hits in which weak modes are looked for."""
ENOUGH = 0.98
"""A weak mode lowers the misfit at least to this share (assumed)."""


class Pole(NamedTuple):
    """One damped oscillation at one order."""

    order: int
    frequency_hz: float
    q: float
    stable: bool


def drawn_poles(diagram: Sequence[Pole], modes_hz: Sequence[float]) -> dict[str, Any]:
    """Return what a stabilisation diagram draws."""
    return {"poles": [(pole.order, pole.frequency_hz, pole.stable) for pole in diagram], "modes_hz": list(modes_hz)}


def stabilisation(decays: Sequence[Array], rate_hz: float, orders: Sequence[int]) -> list[Pole]:
    """Return the poles of a sum of damped oscillations, common to several decays, at each order.

        y_n = sum_k A_k z_k^n,    z = exp((-w/(2 Q) + j w_d)/rate),    w_d = w sqrt(1 - 1/(4 Q^2))

    The Hankel matrices of all decays stand side by side, so that they have one set of poles; of their left singular
    vectors, as many as the order, the shift from row to row is solved by least squares (matrix pencil).

    Parameters
    ----------
    decays : sequence of array
        Free decays without mean, of any lengths.
    rate_hz : float
        Samples per second.
    orders : sequence of int
        Numbers of modes to try, rising; those for which the shortest decay has too few samples are not.

    Notes
    -----
    Source: Hua and Sarkar, IEEE Trans. ASSP 38 (1990) 814.
    """
    shortest = min(decay.size for decay in decays)
    orders = [order for order in orders if 4 * order + 4 <= shortest]
    if not orders:
        return []
    rows = max(min(shortest // 2, 300), 2 * max(orders) + 2)
    windows = [np.lib.stride_tricks.sliding_window_view(decay, rows) for decay in decays]
    # The left singular vectors of a wide matrix are the eigenvectors of its square, a sum over decays.
    powers, vectors = np.linalg.eigh(sum(each.T @ each for each in windows))
    vectors = vectors[:, np.argsort(powers)[::-1]]
    found: list[Pole] = []
    before: list[Pole] = []
    for order in orders:
        signal = vectors[:, : 2 * order]
        shift, *_ = np.linalg.lstsq(signal[:-1], signal[1:], rcond=None)
        here = [_pole(order, z, rate_hz, before) for z in np.linalg.eigvals(shift) if z.imag > 0 and abs(z) < 1]
        before = sorted(here, key=lambda pole: pole.frequency_hz)
        found += before
    return found


def _pole(order: int, z: complex, rate_hz: float, before: Sequence[Pole]) -> Pole:
    s = complex(np.log(z)) * rate_hz
    hertz, q = abs(s) / (2 * np.pi), abs(s) / (-2 * s.real)
    near = [each for each in before if abs(each.frequency_hz - hertz) <= NEAR_HZ * hertz]
    return Pole(order, hertz, q, any(abs(each.q - q) <= NEAR_Q * q for each in near))


def rest_of(decay: Array, poles: Sequence[tuple[float, float]], rate_hz: float) -> Array:
    """Return what modes as they stand leave of a decay."""
    shape = damped(np.arange(decay.size) / rate_hz, poles)
    return np.asarray(decay - shape @ np.linalg.lstsq(shape, decay, rcond=None)[0])


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

    def pairs(x: Array) -> list[tuple[float, float]]:
        return [(float(a), float(b)) for a, b in np.exp(np.clip(x, -20, 20)).reshape(-1, 2)]

    def left(x: Array) -> Array:
        shape = damped(time, pairs(x))
        # By the normal equations, many times faster than by singular values; the columns are far from dependent.
        weight = np.linalg.lstsq(shape.T @ shape, shape.T @ decay, rcond=1e-12)[0]
        return np.asarray(shape @ weight - decay)

    guess, scale = np.log(np.array(starts)).ravel(), np.tile([1e-3, 1e-2], len(starts))
    fit = least_squares(left, guess, x_scale=scale, xtol=1e-7, ftol=1e-9, max_nfev=25)
    shares = _shares(decay, pairs(fit.x), rate_hz)
    misfit = float(np.linalg.norm(fit.fun) / np.linalg.norm(decay - decay.mean()))
    rows = [(hertz, q, share) for (hertz, q), share in zip(pairs(fit.x), shares, strict=True)]
    return np.array([*rows, (misfit, 0.0, 0.0)])


def with_weak(decays: Sequence[Array], poles: list[tuple[float, float]], rate_hz: float) -> list[tuple[float, float]]:
    """Return poles with the weak ones beside them, without which their fit would be biased, from the lowest up.

    One at a time is put where most is left of some hits, each fitted alone, while that lowers the misfit by more than
    chance does.
    """
    some = sorted(decays, key=len)[-TRIED:]
    fits = np.array([fit_decay(decay, poles, rate_hz) for decay in some])
    size = max(decay.size for decay in some)
    while len(poles) < MOST_POLES:
        left = [rest_of(decay, fit[:-1, :2].tolist(), rate_hz) for decay, fit in zip(some, fits, strict=True)]
        power = np.sum([np.abs(np.fft.rfft(rest, 4 * size)) ** 2 for rest in left], axis=0)
        hertz = float((8 + np.argmax(power[8:])) * rate_hz / (4 * size))
        new = [*poles, (hertz, math.pi * hertz * size / rate_hz / 4)]
        tried = np.array([fit_decay(decay, new, rate_hz) for decay in some])
        fewer = float(np.median(tried[:, -1, 0]) / np.median(fits[:, -1, 0]))
        middle = np.median(tried[:, :-1], axis=0)
        near, q, _ = middle[-1]
        # Noise that rings with the sensor is another one in each hit.
        shared = float(np.median(np.abs(tried[:, -2, 0] - near))) < near / q
        if not (shared and q > LEAST_Q and near < 0.45 * rate_hz):
            break
        if not fewer < min(ENOUGH, math.exp(-4 * math.log(size) / size)):
            break
        poles, fits = [(float(f), float(q)) for f, q, _ in middle], tried
    return sorted(poles)


def damped(time_s: Array, modes: Sequence[tuple[float, float]]) -> Array:
    """Return a constant and the two phases of each damped oscillation (Hz, Q), shape (time, 1 + 2 modes)."""
    columns = [np.ones_like(time_s)]
    for resonance_hz, q in modes:
        angle = 2.0 * math.pi * resonance_hz * time_s
        turns = angle * math.sqrt(max(1.0 - 0.25 / q**2, 1e-6))
        falls = np.exp(-0.5 * angle / q)
        columns += [falls * np.cos(turns), falls * np.sin(turns)]
    return np.stack(columns, axis=1)
