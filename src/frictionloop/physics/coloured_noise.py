"""Coloured noise: white Gaussian samples through real poles and zeros, stationary from the first sample."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_discrete_lyapunov
from scipy.signal import sosfilt

from frictionloop.parameters.input_signals import ColouredNoise
from frictionloop.quantities import Array, FrictionloopError
from frictionloop.quantities.counter_noise import covariance_root

_PAIRS_PER_DECADE = 2  # level within 0.06 dB of 1/f, peak to peak (tested)
_LOWEST = 1e-6  # low_hz / rate_hz; below it, double precision no longer gives the variance to 1e-5 (tested)


def shaping_filter(noise: ColouredNoise, rate_hz: float) -> Array:
    """Return the filter that turns unit white noise into noise of unit variance with the spectrum asked for.

    With a pole and a zero around each of the logarithmically spaced frequencies f_i, r = f_(i+1) / f_i,

        |H(f)|^2 = K prod_i (x^2 + x_i^2 r^(exponent/2)) / (x^2 + x_i^2 r^(-exponent/2)) / (1 + x^2/x_high^2),
        x(f) = sin(pi f / rate), x_i = x(f_i),

    each pair lowers the power by r^-exponent. The one-sided spectrum S(f) = 2 / rate |H(f)|^2 is flat below
    ``low_hz``, falls as 1/f^exponent above it and as 1/f^(exponent + 2) above ``high_hz``, where the last
    factor is 1/2 (left out if ``high_hz`` is 0.8 of the Nyquist frequency or more). K makes the variance
    of the output, the integral of S from 0 to rate/2, equal to 1: in closed form, not by simulation.

    Parameters
    ----------
    noise
        Its ``exponent`` (0 to 2), ``low_hz`` and ``high_hz`` are used; the level is left to the caller.
    rate_hz
        Sampling rate in Hz, positive.

    Returns
    -------
    Second-order sections as in `scipy.signal`, shape (sections, 6): a pair per half decade, two to a section.

    Raises
    ------
    FrictionloopError
        ``low_hz`` is not between 1e-6 of the rate and half of it.

    Notes
    -----
    Sources: Keshner, "1/f noise", Proc. IEEE 70 (1982) 212-218, for poles and zeros as 1/f noise; Oustaloup
    et al., IEEE Trans. Circuits Syst. I 47 (2000) 25-39, for where they go. A discrete root exp(-2 asinh x_i)
    has its corner exactly at x_i: each corner up to the Nyquist frequency is where it should be, and stable.
    """
    if not _LOWEST * rate_hz <= noise.low_hz < rate_hz / 2:
        raise FrictionloopError(
            f"noise low_hz = {noise.low_hz:g}: accepted {_LOWEST * rate_hz:g} to below {rate_hz / 2:g}"
        )
    zeros, poles = _zeros_and_poles(noise, rate_hz)
    half = len(poles) // 2
    sos = np.array([_section(zeros[i::half], poles[i::half]) for i in range(half)])
    _, _, output, through = _state_space(sos)
    sos[0, :3] /= math.sqrt(output @ _covariance(sos) @ output + through**2)
    return sos


def _zeros_and_poles(noise: ColouredNoise, rate_hz: float) -> tuple[Array, Array]:
    decades = math.log10(rate_hz / 2 / noise.low_hz)
    count = math.ceil(decades * _PAIRS_PER_DECADE)
    ratio = 10 ** (decades / count)
    centres = np.sin(np.pi / rate_hz * noise.low_hz * ratio ** (np.arange(count) + 0.5))
    zeros = list(_root(centres * ratio ** (noise.exponent / 4)))
    poles = list(_root(centres * ratio ** (-noise.exponent / 4)))
    if noise.high_hz < 0.8 * rate_hz / 2:
        zeros.append(0.0)
        poles.append(_root(np.sin(np.pi * noise.high_hz / rate_hz)))
    if len(poles) % 2:
        zeros.append(0.0)
        poles.append(0.0)
    return np.array(zeros), np.array(poles)


def _root(corner: Array) -> Array:
    """Return the a for which |1 - a exp(-j w)|^2 is proportional to corner^2 + sin(w/2)^2."""
    return np.asarray(np.exp(-2 * np.arcsinh(corner)))


def _section(zeros: Array, poles: Array) -> Array:
    """Return a section of unit gain at 0 Hz: slow pole beside fast (two slow ones would lose digits)."""
    numerator, denominator = np.poly(zeros), np.poly(poles)
    return np.concatenate([numerator * (denominator.sum() / numerator.sum()), denominator])


def stationary_state(sos: Array, normals: ArrayLike) -> Array:
    """Return a filter state drawn from its stationary distribution: the noise has no start-up transient.

    The covariance of the state solves P = A P A^T + B B^T; the state is R n with P = R R.
    ``normals`` are independent unit normals n, shape (..., 2 * sections), one row per lane. The result is the
    first ``zi`` for `colour`, shape (sections, ..., 2); a lane's bits do not depend on the other lanes.
    Raises ``FrictionloopError`` if a lane does not hold 2 * sections numbers.
    """
    drawn = np.asarray(normals, dtype=float)
    count = 2 * len(sos)
    if drawn.ndim == 0 or drawn.shape[-1] != count:
        raise FrictionloopError(f"normals has shape {drawn.shape}; accepted: (..., {count})")
    columns = covariance_root(_covariance(sos))
    state = np.zeros(drawn.shape)
    for i in range(count):  # not a matrix product, whose rounding depends on the number of lanes
        state += drawn[..., i, None] * columns[:, i]
    return np.ascontiguousarray(np.moveaxis(state.reshape(*drawn.shape[:-1], len(sos), 2), -2, 0))


def colour(sos: Array, white: ArrayLike, zi: Array) -> tuple[Array, Array]:
    """Return the coloured samples and the state to go on with: the same bits in chunks of any size.

    ``white`` are unit normals at the filter's rate, shape (..., samples), possibly none; ``zi`` is the state
    from `stationary_state` or the chunk before, shape (sections, ..., 2), left unchanged. The force in N is
    ``offset_n + rms_n * samples``. Raises ``ValueError`` if the shapes do not belong together.
    """
    unfiltered = np.array(white, dtype=float)
    if not unfiltered.size:
        return unfiltered, zi
    samples, after = sosfilt(sos, unfiltered, zi=zi)
    return samples, after


def _covariance(sos: Array) -> Array:
    transition, drive, _, _ = _state_space(sos)
    return np.asarray(solve_discrete_lyapunov(transition, np.outer(drive, drive), method="bilinear"))


def _state_space(sos: Array) -> tuple[Array, Array, Array, float]:
    """Return A, B, C, D of x' = A x + B w, y = C x + D w: one step of `sosfilt` from each unit state."""
    count = 2 * len(sos)
    unit = np.eye(count + 1)
    states = unit[:, :count].reshape(count + 1, len(sos), 2).swapaxes(0, 1)
    samples, after = sosfilt(sos, unit[:, count:], zi=states)
    step = after.swapaxes(0, 1).reshape(count + 1, count).T
    return step[:, :count], step[:, count], samples[:count, 0], float(samples[count, 0])
