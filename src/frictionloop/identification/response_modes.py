"""Several modes of a frequency response: of a hammer with a force channel, of a stepped sine, of a table."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.signal import find_peaks

from frictionloop.identification.decay_modes import Mode, Modes, Which, chosen_of, refuse_misfit
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import Errors, FrequencyResponse, sandwich
from frictionloop.identification.matrix_pencil import MOST_MODES
from frictionloop.identification.project_entry_result import Refused
from frictionloop.quantities import Array, Complex, must_be

WIDEST = 1.0
"""A mode whose 95 % interval is wider than this share of its frequency is none."""

ENOUGH = 0.8
"""Modes are added while they lower the misfit to less than this share (assumed)."""
SURE = 2.0
"""Standard errors within which the value of a mode is taken to lie."""
IN_VAIN = 2
"""So many modes in a row that do not are the end (assumed)."""


class ResponseFit(NamedTuple):
    """A response fitted by some modes; arrays in the order of their frequencies."""

    poles: Array
    """Frequency and Q, shape (modes, 2)."""
    errors: Array
    freedom: Array
    weights: Complex
    misfit: float
    model: Complex


def response_modes(
    found: FrequencyResponse,
    which: Which | int = "first",
    band_hz: tuple[float, float] | None = None,
    *,
    magnitude: bool = False,
) -> Modes:
    """Return the modes of a frequency response, from the lowest up.

        H(f) = c + sum_k (a_k + j b_k f/f_k) / (1 - (f/f_k)^2 + j f/(f_k Q_k))

    Modes are added where the most is left, until two more no longer lower the misfit by a fifth. Least squares go by
    the power of frequencies; standard errors are those of the sandwich (`sandwich`), and the method's come from leaving
    out every other frequency.

    Parameters
    ----------
    found : FrequencyResponse
        From `response` or `response_table`.
    which : str or int
        "first" (the lowest), "strongest", or how many from the lowest up.
    band_hz : tuple, optional
        Frequencies in Hz that are fitted and chosen from; None: all with a hundredth of the largest input.
    magnitude : bool
        Whether only the magnitude is known: then squares of it are fitted.

    Raises
    ------
    FrictionloopError
        For too few frequencies, no mode, or modes that leave more than a quarter unexplained; with what is drawn.
    """
    inside = found.input_density > 0.01 * found.input_density.max()
    if band_hz is not None:
        inside &= (found.frequency_hz >= band_hz[0]) & (found.frequency_hz <= band_hz[1])
    hertz, seen = found.frequency_hz[inside], found.response[inside]
    if hertz.size < 12:
        raise Refused(str(must_be("response: frequencies", hertz.size, "at least 12")), "response", {})
    weight = np.sqrt(found.input_density[inside] / found.input_density[inside].mean())
    fits = rising(hertz, seen, weight, magnitude)
    best = fits[-1] if fits else None
    if best is not None and found.hits == 1:
        best, weight = weighed(hertz, seen, weight, best, magnitude)
    curves = {"response": {**found.drawn(inside), "fitted": [] if best is None else np.abs(best.model).tolist()}}
    if best is None:
        raise Refused(str(must_be("response: peaks", 0, "1 or more")), "response", curves)
    refuse_misfit("response", best.misfit, best.poles.tolist(), curves)
    half = fitted(hertz[::2], seen[::2], weight[::2], best.poles, magnitude)
    moved = np.abs(half.poles - best.poles) / math.sqrt(3)
    modes = _modes(best, found, hertz)
    for hertz_, ends in ((mode.frequency, mode.frequency.interval()) for mode in modes):
        if not ends.high - ends.low < WIDEST * hertz_.value:
            raise Refused(str(must_be("response: mode", str(hertz_), "surely above 0")), "response", curves)
    chosen = chosen_of(modes, which, band_hz or (0.0, math.inf))
    drawn = tuple(zip(hertz.tolist(), np.abs(best.model).tolist(), strict=True))
    hertz_moved, q_moved = map(tuple, moved.T)
    return Modes(tuple(modes), chosen, best.misfit, hertz_moved, q_moved, found.hits, (), fitted=drawn)


def _modes(fit: ResponseFit, found: FrequencyResponse, hertz: Array) -> list[Mode]:
    """Return the modes; a mode's share is that of the squared height of its peak, its agreement the coherence there."""
    height = np.abs(fit.weights) ** 2
    share = height / height.sum()
    listed: list[Mode] = []
    for (f, q), (ef, eq), (nf, nq), part in zip(fit.poles, fit.errors, fit.freedom, share, strict=True):
        coherence = float(np.interp(f, found.frequency_hz, found.coherence))
        frequency = Estimate(float(f), float(ef), "Hz", float(nf))
        listed.append(Mode(frequency, Estimate(float(q), float(eq), "", float(nq)), float(part), coherence))
    return listed


def rising(hertz: Array, seen: Complex, weight: Array, magnitude: bool) -> list[ResponseFit]:
    """Return fits of ever more modes, as long as each is worth it."""
    fits: list[ResponseFit] = []
    best = 0
    left = np.abs(seen)
    poles = np.zeros((0, 2))
    for _ in range(MOST_MODES):
        start = _peak(hertz, left * weight)
        if start is None:
            break
        fit = fitted(hertz, seen, weight, np.vstack([poles, start]), magnitude)
        if not np.all(np.isfinite(fit.errors)) or fit.poles[:, 0].min() < hertz[0] or fit.poles[:, 0].max() > hertz[-1]:
            break
        fits.append(fit)
        if len(fits) > 1 and fit.misfit <= ENOUGH * fits[best].misfit and _told_apart(fit):
            new, old = (_unseen(hertz, seen, weight, each.poles, magnitude) for each in (fit, fits[best]))
            best = len(fits) - 1 if new <= ENOUGH * old else best
        if len(fits) - 1 - best >= IN_VAIN:
            break
        poles, left = fit.poles, np.abs(np.abs(seen) - np.abs(fit.model) if magnitude else seen - fit.model)
        if fit.misfit < 1e-3:
            break
    return fits[: best + 1]


def _told_apart(fit: ResponseFit) -> bool:
    """Return whether each mode is known to better than its width, and its Q to better than itself.

    Noise that goes with the response is largest beside a peak, where modes without number lower the misfit.
    """
    (hertz, q), (error_hz, error_q) = fit.poles.T, SURE * fit.errors.T
    return bool(np.all(error_hz < hertz / q) and np.all(error_q < q))


def _unseen(hertz: Array, seen: Complex, weight: Array, poles: Array, magnitude: bool) -> float:
    """Return the misfit at every other frequency of a fit to the rest, both ways round: noise is not seen twice."""
    left = 0.0
    for out in (slice(0, None, 2), slice(1, None, 2)):
        known = weight.copy()
        known[out] = 0.0
        model = fitted(hertz, seen, known, poles, magnitude).model
        left += float(np.sum(np.abs(weight * _away(model, seen, magnitude))[out] ** 2))
    return math.sqrt(left)


def weighed(hertz: Array, seen: Complex, weight: Array, fit: ResponseFit, magnitude: bool) -> tuple[ResponseFit, Array]:
    """Return the fit by the noise that is likelier, the same everywhere or a share of the response, and its weights.

    Of normal noise of standard deviation s/w_i the log-likelihood is sum log w_i^2 - n log sum w_i^2 |r_i|^2.
    """
    sizes = np.maximum(np.abs(fit.model), 1e-3 * float(np.abs(fit.model).max()))
    shared = weight / sizes
    other = fitted(hertz, seen, shared, fit.poles, magnitude)

    def likelihood(each: ResponseFit, by: Array) -> float:
        away = np.abs(_away(each.model, seen, magnitude))
        return float(np.sum(np.log(by**2)) - by.size * np.log(np.sum((by * away) ** 2)))

    if not likelihood(other, shared) > likelihood(fit, weight):
        return fit, weight
    misfit = float(np.linalg.norm(weight * _away(other.model, seen, magnitude)) / np.linalg.norm(weight * np.abs(seen)))
    return other._replace(misfit=misfit), shared


def _away(model: Complex, seen: Complex, magnitude: bool) -> Any:
    """Return how far a model is from what was seen, its magnitude or all of it."""
    return np.abs(model) - np.abs(seen) if magnitude else model - seen


def _peak(hertz: Array, size: Array) -> Array | None:
    """Return frequency and Q of the peak that stands out the most on a logarithmic scale."""
    if size.max() <= 0:
        return None
    level = np.log(np.maximum(size, 1e-6 * size.max()))
    peaks, told = find_peaks(level, prominence=0.5, width=0, rel_height=0.5)
    if not peaks.size:
        return None
    k = int(np.argmax(size[peaks] * np.minimum(told["prominences"], 3.0)))
    row = peaks[k]
    above = size >= size[row] / math.sqrt(2)
    left = row - int(np.argmin(above[row::-1])) if not above[: row + 1].all() else 0
    right = row + int(np.argmin(above[row:])) if not above[row:].all() else size.size - 1
    width = max(hertz[right] - hertz[left], np.diff(hertz).min())
    return np.array([[hertz[row], max(hertz[row] / width, 1.0)]])


def fitted(hertz: Array, seen: Complex, weight: Array, start: Array, magnitude: bool) -> ResponseFit:
    """Return the fit that begins at these poles: their weights are found by linear least squares within."""
    scale = float(np.linalg.norm(weight * np.abs(seen)))
    x0 = np.log(start).ravel()
    if magnitude:
        weights0 = np.full(len(start), math.sqrt(float(np.max(np.abs(seen)))))
        for k, (f, q) in enumerate(start):
            weights0[k] = float(np.abs(np.interp(f, hertz, np.abs(seen)))) / q
        x0 = np.concatenate([x0, weights0 / weights0.max(), [0.0]])
        unit = weights0.max()

    def parts(x: Array) -> tuple[Array, Complex]:
        poles = np.exp(np.clip(x[: start.size], -20, 20)).reshape(-1, 2)
        relative = hertz[:, None] / poles[:, 0]
        return poles, 1 / (1 - relative**2 + 1j * relative / poles[:, 1])

    def model(x: Array) -> Complex:
        poles, shape = parts(x)
        if magnitude:
            return np.asarray(unit * (shape @ x[start.size : -1] + x[-1]))
        columns = np.concatenate([shape, 1j * shape * hertz[:, None] / poles[:, 0], np.ones((hertz.size, 1))], axis=1)
        stacked = np.concatenate([(weight[:, None] * columns).real, (weight[:, None] * columns).imag])
        target = np.concatenate([(weight * seen).real, (weight * seen).imag])
        # By the normal equations, of columns of one length: many times faster than by singular values.
        size = np.linalg.norm(stacked, axis=0)
        share = np.linalg.lstsq(stacked.T @ stacked / np.outer(size, size), stacked.T @ target / size, rcond=1e-12)[0]
        return np.asarray(columns @ (share / size))

    def residuals(x: Array) -> Array:
        away = weight * _away(model(x), seen, magnitude) / scale
        return away if magnitude else np.concatenate([away.real, away.imag])

    fit = least_squares(residuals, x0, x_scale=np.where(np.arange(x0.size) < start.size, 1e-2, 1.0), max_nfev=100)
    try:
        errors = sandwich(fit.jac, fit.fun)
    except np.linalg.LinAlgError:  # a mode too many, which nothing determines
        errors = Errors(np.full(x0.size, np.inf), np.ones(x0.size))
    poles = np.exp(np.clip(fit.x[: start.size], -20, 20)).reshape(-1, 2)
    order = np.argsort(poles[:, 0])
    given = model(fit.x)
    _, shape = parts(fit.x)
    size = np.abs(np.linalg.lstsq(np.column_stack([shape, np.ones(hertz.size)]), given, rcond=None)[0][:-1])
    spread = (errors.standard[: start.size].reshape(-1, 2) * poles)[order]
    freedom = errors.freedom[: start.size].reshape(-1, 2)[order]
    misfit = float(np.linalg.norm(fit.fun))
    return ResponseFit(poles[order], spread, freedom, (size * poles[:, 1])[order], misfit, given)
