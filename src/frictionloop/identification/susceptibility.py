"""tau and f0 of a finger from recordings with amplitude commands, and the lookup table that these give."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from scipy.interpolate import PchipInterpolator
from scipy.optimize import isotonic_regression
from scipy.stats import t as student

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, measured
from frictionloop.identification.project_entry_result import EntryResult, Rows, Sensor, in_newtons, not_told, thinned
from frictionloop.identification.project_file import Take
from frictionloop.identification.susceptibility_fit import (
    AMPLITUDES,
    FIXED,
    LAWS,
    PRIORS,
    AmplitudeLaw,
    LawFit,
    Pieces,
    fit_law,
    relative_load,
    sliding_pieces,
    wet_share,
)
from frictionloop.quantities import Array, must_be
from frictionloop.quantities.value_checks import whole

POINTS = 400
TABLE = 33

PIECE_S = 0.1
"""Length of a piece: some tens of periods of the skin's resonance, a fraction of a stroke (assumed)."""
CANNOT_BE_TOLD = 4.0
"""Difference of AIC below which two laws are not told apart (Burnham and Anderson 2002: 4 to 7 is considerably less
support for the worse one)."""
UNTOLD = "cannot be told"
SURE = 0.01
"""Chance below which a slope over amplitude squared is called real (assumed)."""
BINS = 12
"""Stretches of the amplitude over each of which pieces are averaged (assumed: enough for a curve with one bend)."""
LEAST_PER_BIN = 3
LEAST_FALL = 1e-4
"""Least fall of log friction from stretch to stretch, so that each force has one amplitude."""


@dataclass(frozen=True)
class SusceptibilityFit:
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


def _susceptibility(law: AmplitudeLaw, x: float, largest_um: float) -> tuple[float, float]:
    """Return tau in um^-2 from the exponent at the largest amplitude, and how it changes with that."""
    if law.name == "exponential":
        return (x / largest_um) ** 2, 2 * abs(x) / largest_um**2
    return x / largest_um**2, 1 / largest_um**2


def susceptibility(recording: xr.Dataset | Sequence[xr.Dataset], plate_hz: float | None = None) -> SusceptibilityFit:
    """Return f0 and tau of a finger from one recording, or from several as one measurement.

        log f = log f0 + n log(N/0.5 N) + log(1 + g w) + log mean(share(a)^(1 - k w)),   w = 1 - exp(-t/T)

    over pieces of 0.1 s, t the time in contact, share the law: exp(-tau a^2) and two others (`LAWS`). The mean is over
    the samples of a piece, so amplitudes may step, sweep or be noise. Residuals follow each other as an
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
        raise must_be("recording: amplitude, its largest", largest, "reached and left", "um")
    fits = [fit_law(law, pieces, largest) for law in LAWS]
    smooth, their_errors, their_freedom = min(fits[:2], key=lambda each: each[0].aic)
    _refuse_no_effect(smooth.x[FIXED], their_errors[FIXED], their_freedom)
    for run in runs:
        name = next(each for each in AMPLITUDES if each in run)
        if (unit := run[name].attrs["units"]) != "um":
            raise must_be(f"recording: unit of {name!r}", unit, "um, by kind 'scale'")
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

    def told_as(k: int, shift: float = 0.0) -> Estimate:
        return Estimate(shift + best.x[k], errors[k], "", freedom)

    return SusceptibilityFit(
        nominal=Estimate(f0, f0 * errors[0], "N", freedom),
        susceptibility=Estimate(tau, share * curve_errors[FIXED], "um^-2", freedom),
        load_exponent=told_as(1),
        occlusion_ratio=told_as(2, shift=1.0),
        moist_loss=told_as(3),
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
        raise must_be("recording: friction over 'amplitude'", rise, "below 0: electroadhesion raises it")
    if exponent < sure:
        said = f"{-exponent:.3g} +- {error:.2g}"
        raise must_be("recording: log share left", said, "surely below 0")


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


def monotone_table(found: SusceptibilityFit, entries: int = 33) -> MonotoneTable:
    """Return the table a^2(u) that the recordings themselves give.

    The mean of log share over twelve stretches of amplitude is made falling by isotonic regression (pool adjacent
    violators), joined from (0, 0) on by a monotone cubic (Fritsch and Carlson 1980), and inverted.

    Parameters
    ----------
    found : SusceptibilityFit
        From `susceptibility`.
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
    means = [float(found.log_share[row].mean()) for row in rows]
    falling = isotonic_regression(means, weights=weight, increasing=False)
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


def amplitude_entry(take: Take, runs: Sequence[xr.Dataset], sensor: Sensor) -> EntryResult:
    """Return f0 and tau, and what else the recordings tell better than what is known of fingers beforehand."""
    scaled, doubts = in_newtons(runs, sensor)
    found = [susceptibility(run, take.plate_hz) for run in scaled]
    whole = found[0] if len(found) == 1 else susceptibility(scaled, take.plate_hz)
    how = f"{sum(f.log_share.size for f in found)} pieces under amplitude commands, {whole.law} law"
    taus = [f.susceptibility for f in found]
    values = [
        measured("friction.nominal_n", [f.nominal for f in found], [f.method_n for f in found], how),
        measured("friction.susceptibility_per_um2", taus, [f.method_per_um2 for f in found], how),
    ]
    more = {"load_exponent": "load", "occlusion_ratio": "occlusion", "moist_loss": "loss"}
    for name, prior in more.items():
        each = [getattr(f, name) for f in found]
        value = measured(f"friction.{name}", [one._replace(value=max(one.value, 0.0)) for one in each], None, how)
        # What the recordings do not tell is what was known before, and stays assumed.
        if value.error < 0.5 * PRIORS[prior][1]:
            values.append(value)
    curves: dict[str, Any] = {"law": _drawn(whole), "overrides": _overrides(whole)}
    if take.finger is not None:
        curves["person"] = {"finger": take.finger, "found": [_logs(f) for f in found]}
    rows: Rows = [("law", "AIC above the best", "scatter", "what it says")]
    best = whole.laws[0].aic
    rows += [(each.name, f"{each.aic - best:.1f}", f"{each.residual:.1%}", each.words) for each in whole.laws]
    numbers: dict[str, Any] = {"law": whole.law, "pieces": whole.pieces}
    numbers |= {f"aic_above_the_best_{each.name}": each.aic - best for each in whole.laws}
    numbers["scatter_percent"] = 100 * whole.laws[0].residual
    return EntryResult(values, [*doubts, *whole.findings], numbers, rows, curves)


def _overrides(found: SusceptibilityFit) -> dict[str, Any]:
    """Return the law and the table where the law is told and is not the Gaussian, which needs no table."""
    if found.law in ("gaussian", UNTOLD):
        return {}
    kind = {"friction.kind": "rough_contact"} if found.law == "exponential" else {}
    return kind | monotone_table(found, TABLE).overrides()


def _logs(found: SusceptibilityFit) -> dict[str, Any]:
    """Return logarithms of f0 and tau with their errors, those of the method among them."""
    f0, tau = found.nominal, found.susceptibility
    errors = [math.hypot(f0.standard_error, found.method_n), math.hypot(tau.standard_error, found.method_per_um2)]
    return {
        "friction.nominal_n": [math.log(f0.value), errors[0] / f0.value],
        "friction.susceptibility_per_um2": [math.log(tau.value), errors[1] / tau.value],
    }


def _drawn(found: SusceptibilityFit) -> dict[str, Any]:
    fine = np.linspace(0.0, found.largest_um, 60)
    laws, level = {law.name: law for law in LAWS}, math.log(found.nominal.value)
    # Each law has an f0 of its own, and what is drawn is the share of the f0 that is told.
    curves = {
        fit.name: np.exp(
            fit.x[0] - level - laws[fit.name].exponent(fine, np.array(fit.x[FIXED:]), found.largest_um)
        ).tolist()
        for fit in found.laws
    }
    drawn = thinned(POINTS, amplitude_um=found.amplitude_um, share=np.exp(found.log_share))
    return {**drawn, "fine_um": fine.tolist(), "laws": curves}
