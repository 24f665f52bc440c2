"""tau and f0 of a finger from recordings with amplitude commands, with moisture and load in the model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.stats import t as student

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.part import not_told
from frictionloop.identification.sliding_pieces import AMPLITUDES, Pieces, sliding_pieces
from frictionloop.identification.vibrated_fit import FIXED, LAWS, LawFit, VibratedLaw, fit_law, relative_load, wet_share
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
PIECE_S = 0.1
"""Length of a piece: some tens of periods of the skin's resonance, a fraction of a stroke (assumed)."""
CANNOT_BE_TOLD = 4.0
"""Difference of AIC below which two laws are not told apart (Burnham and Anderson 2002: 4 to 7 is considerably less
support for the worse one)."""
UNTOLD = "cannot be told"
SURE = 0.01
"""Chance below which a slope over amplitude squared is called real (assumed)."""


@dataclass(frozen=True)
class Vibrated:
    """What recordings with amplitude commands tell of one finger."""

    nominal: Estimate
    """f0 in N at 0.5 N of load, when the contact begins."""
    susceptibility: Estimate
    """tau in um^-2, when the contact begins: exp(-tau a^2) is left, or exp(-sqrt(tau) a) if the law is exponential; of
    a threshold, what the Gaussian comes nearest with."""
    load_exponent: Estimate
    occlusion_ratio: Estimate
    moist_loss: Estimate
    method_n: float
    """Standard error of f0 from the length of a piece, and of tau below."""
    method_per_um2: float
    laws: tuple[LawFit, ...]
    """From the likeliest to the least."""
    largest_um: float
    log_share: Array
    """Of each piece, log of the share of friction that is left, load and moisture taken off."""
    amplitude_um: Array
    """Root mean square of each piece."""
    pieces: int
    findings: tuple[Finding, ...]

    @property
    def law(self) -> str:
        """Name of the likeliest law, "cannot be told" if another is nearly as likely."""
        return _told(self.laws)


def _told(laws: Sequence[LawFit]) -> str:
    return laws[0].name if laws[1].aic - laws[0].aic >= CANNOT_BE_TOLD else UNTOLD


def _susceptibility(law: VibratedLaw, x: float, largest_um: float) -> tuple[float, float]:
    """Return tau in um^-2 from the exponent at the largest amplitude, and how it changes with that."""
    if law.name == "exponential":
        return (x / largest_um) ** 2, 2 * abs(x) / largest_um**2
    return x / largest_um**2, 1 / largest_um**2


def vibrated(recording: xr.Dataset | Sequence[xr.Dataset], plate_hz: float | None = None) -> Vibrated:
    """Return f0 and tau of a finger from one recording, or from several as one measurement.

        log f = log f0 + n log(N/0.5 N) + log(1 + g w) + log mean(share(a)^(1 - k w)),   w = 1 - exp(-t/T)

    over pieces of 0.1 s, t the time in contact, share the law: exp(-tau a^2) and two others (`vibrated_fit`). The mean
    is over the samples of a piece, so amplitudes may step, sweep or be noise. Residuals follow each other as an
    autoregression of first order, since the roughness under a finger does; what n, g, k and T are where a recording
    does not tell is `PRIORS`.

    Parameters
    ----------
    recording : xarray.Dataset or sequence of them
        As for ``sliding_pieces``: friction, load, amplitude, position or speed.
    plate_hz : float, optional
        Cutoff of the plate's envelope in Hz, where ``amplitude`` is a command.

    Raises
    ------
    FrictionloopError
        For too little sliding, an amplitude that hardly changes, friction that rises with the amplitude as
        electroadhesion makes it, or that does not change with it beyond its scatter.
    """
    runs = [recording] if isinstance(recording, xr.Dataset) else list(recording)
    pieces = _joined([sliding_pieces(run, PIECE_S, plate_hz) for run in runs])
    square = np.mean(pieces.amplitude_um**2, axis=1)
    largest = float(pieces.amplitude_um.max())
    if not largest > 0 or np.ptp(square) < 0.2 * largest**2:
        raise must_be("recording: amplitude, its largest", largest, "reached and left, between 0 and this", "um")
    fits = [fit_law(law, pieces, largest) for law in LAWS]
    smooth, their_errors, their_freedom = min(fits[:2], key=lambda each: each[0].aic)
    _refuse_no_effect(smooth.x[FIXED], their_errors[FIXED], their_freedom)
    _refuse_unscaled(runs)
    shorter = _joined([sliding_pieces(run, PIECE_S / 2, plate_hz) for run in runs])
    laws = tuple(sorted((fit for fit, *_ in fits), key=lambda each: each.aic))
    told = _told(laws)
    chosen = LAWS[1] if told == "exponential" else LAWS[0]
    likeliest = next((law for law in LAWS if law.name == told), LAWS[0])
    best, errors, freedom = next(fit for fit in fits if fit[0].name == likeliest.name)
    curve, curve_errors, _ = next(fit for fit in fits if fit[0].name == chosen.name)
    moved = _moved(best, fit_law(likeliest, shorter, largest)[0])
    curve_moved = _moved(curve, fit_law(chosen, shorter, largest)[0])
    f0, tau, share = math.exp(best.x[0]), *_susceptibility(chosen, curve.x[FIXED], largest)
    wet = wet_share(pieces.contact_s, best.x[4])
    rest = best.x[0] + best.x[1] * relative_load(pieces) + np.log1p(best.x[2] * wet)

    def told_as(k: int, unit: str, scale: float = 1.0, shift: float = 0.0) -> Estimate:
        return Estimate(shift + scale * best.x[k], scale * errors[k], unit, freedom)

    return Vibrated(
        nominal=Estimate(f0, f0 * errors[0], "N", freedom),
        susceptibility=Estimate(tau, share * curve_errors[FIXED], "um^-2", freedom),
        load_exponent=told_as(1, ""),
        occlusion_ratio=told_as(2, "", shift=1.0),
        moist_loss=told_as(3, ""),
        method_n=f0 * moved[0],
        method_per_um2=share * curve_moved[FIXED],
        laws=laws,
        largest_um=largest,
        log_share=(pieces.log_friction - rest) / (1 - best.x[3] * wet),
        amplitude_um=np.sqrt(square),
        pieces=len(pieces.contact_s),
        findings=(not_told("the friction law", f"{laws[0].name} or {laws[1].name}"),) if told == UNTOLD else (),
    )


def _moved(one: LawFit, other: LawFit) -> list[float]:
    """Return how far parameters are apart, as a standard error."""
    return [abs(a - b) / math.sqrt(3) for a, b in zip(one.x, other.x, strict=True)]


def _joined(parts: Sequence[Pieces]) -> Pieces:
    width = min(part.amplitude_um.shape[1] for part in parts)
    parts = [part._replace(amplitude_um=part.amplitude_um[:, :width]) for part in parts]
    return Pieces(*(np.concatenate(each) for each in zip(*parts, strict=True)))


def _refuse_no_effect(exponent: float, error: float, freedom: float) -> None:
    sure = float(student.ppf(1 - SURE / 2, freedom)) * error
    if exponent < -sure:
        rise = float(np.expm1(-exponent))
        raise must_be("recording: rise of friction with 'amplitude'", rise, "below 0: electroadhesion raises it")
    if exponent < sure:
        said = f"{-exponent:.3g} +- {error:.2g}"
        raise must_be("recording: log share of friction at the largest amplitude", said, "surely below 0")


def _refuse_unscaled(runs: Sequence[xr.Dataset]) -> None:
    for run in runs:
        name = next(each for each in AMPLITUDES if each in run)
        if (unit := run[name].attrs["units"]) != "um":
            raise must_be(f"recording: unit of {name!r}", unit, "um: kind 'scale' finds its scale")
