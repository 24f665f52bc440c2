"""The least residual of any linear controller that hears noise, keeps Ms and spares its drive: from both sides."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.quantities import Array, Complex
from studies.wiener_hopf import Spectra, bins, least_power, squared

BINS = 2**14
"""Bins of the FFT: 0.15 Hz at 5 kHz; with half or twice as many the residual on the bench differs by up to 0.3 %."""
START, ROUNDS, CLOSE = 0.1, 300, 2e-3
"""First weight over the mean density, updates at most, and the gap between both bounds at which they end, relative."""


class LinearOptimum(NamedTuple):
    """The least residual between its bounds, and the sensitivity of the upper one."""

    residual_rms_n: float
    """What the best controller found leaves, N: root of the sum of the next two, squared."""
    disturbance_rms_n: float
    """Disturbance left, N."""
    noise_rms_n: float
    """Sensor noise let through to friction, N."""
    bound_rms_n: float
    """No linear controller leaves less, N (by duality)."""
    drive_rms_n: float
    """Rms of its command, N, as long as nothing cuts it."""
    sensitivity_peak: float
    """Largest |S| of the controller found."""
    frequency_hz: Array
    """Bins of ``sensitivity``, from 0 to the Nyquist frequency."""
    sensitivity: Complex
    """S of the controller found."""


def linear_optimum(
    frequency_hz: ArrayLike,
    psd: ArrayLike,
    noise_psd: ArrayLike,
    sensitivity_peak: float,
    nyquist_hz: float,
    *,
    reading: ArrayLike,
    friction: ArrayLike,
    poles: ArrayLike = (1.0,),
    largest_drive_n: float = math.inf,
    bins_to_nyquist: int = BINS,
) -> LinearOptimum:
    """Return the least residual of a disturbance under any linear sampled controller that measures with noise.

    Minimise integral |S|^2 Phi_d + |N_f X|^2 Phi_n over 0 to the Nyquist frequency, subject to |S| <= Ms, over every
    stable causal X, S = 1 - N_y X: by Youla all controllers that stabilise a known, stable plant, of any order. The
    problem is convex. Weights w >= 0 on |S|^2 - Ms^2 make it the one of `least_power`, whose least, less the integral
    of w Ms^2, is below the optimum whatever w is (Lagrange's dual). The weights grow where |S| > Ms and fall where it
    is less, w <- w |S|^2/Ms^2 (Lawson). The S met on the way is mixed with S = 1, which no control has, just so far
    that it keeps Ms: a controller, so above the optimum. It ends when both agree.

    The plant is one that is known exactly: robustness is in it as Ms of the nominal loop alone. Saturation is not in
    it, nor what a law makes of more than this reading (a measured load or speed) or of being nonlinear or changing in
    time. Residual means S times the disturbance at the sampling instants, as for `waterbed_bound`.

    Parameters
    ----------
    frequency_hz, psd, nyquist_hz
        The disturbance, as for `waterbed_bound`.
    noise_psd
        One-sided density of the noise of the reading, N^2/Hz, over the same frequencies, not negative.
    sensitivity_peak
        Largest |S|, above 1; infinite for none.
    reading, friction
        N_y and N_f: numerators of the responses from command to reading and to friction over their common, stable
        denominator, coefficients of 1, z^-1, z^-2, ... (`SampledPlant.numerators`). Their common factor is free.
    poles
        A, this denominator in the same order; it is needed for the command alone.
    largest_drive_n
        Largest rms of the command, N, above 0.
    bins_to_nyquist
        Bins of the FFT; what rings or drifts for longer than its length is cut.
    """
    frequency, power, noise = (np.asarray(each, dtype=float) for each in (frequency_hz, psd, noise_psd))
    paths = tuple(np.atleast_1d(np.asarray(each, dtype=float)) for each in (reading, friction, poles))
    size = float(np.max(np.abs(paths[0])))
    numbers = tuple(path / size for path in paths)
    spectra = bins(frequency, power, noise, nyquist_hz, numbers, bins_to_nyquist)  # type: ignore[arg-type]
    spectra, bound, correction = _spared(spectra, sensitivity_peak, largest_drive_n)
    S = 1.0 - spectra.reading * correction
    left = float(spectra.width_hz @ (squared(S) * spectra.disturbance))
    heard = float(spectra.width_hz @ (squared(correction) * spectra.heard()))
    hertz = np.linspace(0.0, nyquist_hz, bins_to_nyquist + 1)
    rms = (math.sqrt(left + heard), math.sqrt(left), math.sqrt(heard), math.sqrt(max(bound, 0.0)))
    return LinearOptimum(*rms, _drive_rms_n(spectra, correction), float(np.max(np.abs(S))), hertz, S)


def _drive_rms_n(spectra: Spectra, correction: Complex) -> float:
    return math.sqrt(float(spectra.width_hz @ (squared(correction) * spectra.drive)))


def _spared(spectra: Spectra, peak: float, largest_n: float) -> tuple[Spectra, float, Complex]:
    """Return `_between` at the least price that keeps the command's rms, within a tenth, and the spectra with it."""
    bound, correction = _between(spectra, peak)
    if _drive_rms_n(spectra, correction) <= largest_n:
        return spectra, bound, correction
    # At the highest price even all of the residual would not pay for a command that is too large.
    low, high = 0.0, float(spectra.width_hz @ spectra.disturbance) / largest_n**2
    while low == 0.0 or high > 1.1 * low:
        # Downwards by tens until the command is too large, then halfway on a logarithmic scale.
        price = math.sqrt(low * high) if low else high / 10.0
        tried = spectra._replace(price=price)
        if _drive_rms_n(tried, _between(tried, peak)[1]) > largest_n:
            low = price
        else:
            high = price
    spared = spectra._replace(price=high)
    bound, correction = _between(spared, peak)
    return spared, bound - high * largest_n**2, correction


def _between(spectra: Spectra, peak: float) -> tuple[float, Complex]:
    """Return the largest lower bound of the price found, N^2, and the X of least price found that keeps the peak."""
    if peak == math.inf:
        return least_power(spectra)
    width, loud = spectra.width_hz, spectra.width_hz * spectra.disturbance
    paid = width * spectra.paid()
    least, below, best = float(np.sum(loud)), 0.0, np.zeros(width.size, dtype=complex)
    weight = np.full(width.size, START * least / float(np.sum(width)))
    for _ in range(ROUNDS):
        dual, correction = least_power(spectra, weight)
        S = 1.0 - spectra.reading * correction
        size = squared(S)
        below = max(below, dual - peak**2 * float(width @ weight))
        # |(1 - m) + m S| <= Ms for m = (Ms - 1)/(max |S| - 1).
        m = min(1.0, (peak - 1.0) / max(math.sqrt(float(np.max(size))) - 1.0, 1e-300))
        kept = (1.0 - m) ** 2 + 2.0 * m * (1.0 - m) * S.real + m**2 * size
        power = float(loud @ kept + m**2 * (paid @ squared(correction)))
        if power < least:
            least, best = power, m * correction
        if least <= (1.0 + CLOSE) ** 2 * below:
            break
        weight = weight * (size / peak**2)
    return below, best
