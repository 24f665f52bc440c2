"""Several modes from the decays after hits, with or without a hammer that measures."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import least_squares
from scipy.signal import decimate

from frictionloop.identification.channels import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.hits import pick_hits, quiet_noise
from frictionloop.identification.poles import Pole, stabilisation
from frictionloop.identification.ring_down import damped
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
MOST_MODES = 8
STABLE_AT = 3
"""At so many orders in a row a pole must be stable to be a mode (assumed)."""
LEAST_SHARE = 0.01
"""Share of the energy of a decay below which a mode is not counted (assumed)."""
WORST_MISFIT = 0.25
"""Most of the rms of a decay that its modes may leave unexplained (assumed)."""
WORST_START = 0.8
"""The same of poles that are not yet fitted: beyond it no fit is tried (assumed)."""
LEAST_Q = 2.0
LONGEST = 2000
"""Samples of a decay that are fitted; a longer one is decimated as its frequencies allow."""
Which = Literal["first", "strongest"]


class Mode(NamedTuple):
    """One damped oscillation that hits have in common."""

    frequency: Estimate
    """Hz, undamped; the standard error is that of the scatter from hit to hit."""
    q: Estimate
    share: float
    """Of the energy of the decays."""
    agreement: float
    """1 - variance over hits of the frequency, in units of the mode's squared bandwidth: 1 is perfect, below 0 none."""


@dataclass(frozen=True)
class Modes:
    """The modes of a structure, from the lowest up."""

    modes: tuple[Mode, ...]
    """All that were found."""
    chosen: tuple[int, ...]
    """Which of them were asked for."""
    misfit: float
    """rms of what the modes leave over that of the decays."""
    method_hz: tuple[float, ...]
    """Standard error in Hz of each mode from window and order, and in Q below."""
    method_q: tuple[float, ...]
    hits: int
    told: str
    """Which hits were used, and what was left out."""
    diagram: tuple[Pole, ...]
    """Poles over order."""

    @property
    def asked(self) -> tuple[Mode, ...]:
        """The modes that were asked for."""
        return tuple(self.modes[k] for k in self.chosen)


def modes(
    recording: xr.Dataset | Sequence[xr.Dataset],
    which: Which | int,
    band_hz: tuple[float, float] | None = None,
    segment_s: float | None = None,
    exclude: Collection[int] = (),
) -> Modes:
    """Return modes from how the reading decays after hits: no force need be measured.

        y(t) = c + sum_k e^(-w_k t/(2 Q_k)) (a_k cos(w_dk t) + b_k sin(w_dk t))

    Poles that stay where they are as the order rises (`poles`) start the fit; then each hit is fitted by least squares,
    and what differs from hit to hit is the standard error.

    Parameters
    ----------
    recording : xarray.Dataset or sequence of them
        Column ``f_m`` in N, V or counts over ``time`` in s, and ``hammer`` if there is one: then the decay begins once
        the force has ended.
    which : str or int
        "first" (the lowest), "strongest", or how many from the lowest up.
    band_hz : tuple, optional
        Frequencies in Hz between which to choose.
    segment_s, exclude
        As in `pick_hits`.

    Raises
    ------
    FrictionloopError
        For too few good hits, no stable mode or fewer than asked for, or modes that leave more than a quarter of a
        decay unexplained.
    """
    runs = [recording] if isinstance(recording, xr.Dataset) else list(recording)
    decays, told, rate_hz = _decays(runs, segment_s, exclude)
    decays, rate_hz = _slower(decays, rate_hz)
    orders = range(1, MOST_MODES + 5)
    diagram = [pole for pole in stabilisation(decays, rate_hz, orders) if pole.frequency_hz < 0.45 * rate_hz]
    starts = _lasting(diagram)
    if not starts:
        raise FrictionloopError(
            "recording: no mode stays where it is as the order rises; accepted: hits on what rings freely, with "
            "nothing on the glass"
        )
    starts = _strong(decays, starts, rate_hz)
    _refuse_misfit(float(np.median([_left(decay, starts, rate_hz) for decay in decays])), starts, WORST_START)
    fits = np.array([_fit(decay, starts, rate_hz) for decay in decays])
    misfit = float(np.sqrt(np.mean(fits[:, -1, 0] ** 2)))
    _refuse_misfit(misfit, starts, WORST_MISFIT)
    found = _modes(fits[:, :-1, :])
    late = np.array([_fit(decay[decay.size // 8 :], starts, rate_hz)[:-1, :2] for decay in decays])
    moved = np.abs(late.mean(axis=0) - fits[:, :-1, :2].mean(axis=0)) / math.sqrt(3)
    return Modes(
        modes=tuple(found),
        chosen=_chosen(found, which, band_hz or (0.0, rate_hz)),
        misfit=misfit,
        method_hz=tuple(moved[:, 0].tolist()),
        method_q=tuple(moved[:, 1].tolist()),
        hits=len(decays),
        told=told,
        diagram=tuple(diagram),
    )


def _refuse_misfit(misfit: float, starts: Sequence[tuple[float, float]], most: float) -> None:
    if misfit > most:
        listed = ", ".join(f"{hertz:.5g}" for hertz, _ in starts)
        raise FrictionloopError(
            f"recording: modes at {listed} Hz leave {misfit:.0%} of the decays unexplained: must be at most "
            f"{WORST_MISFIT:.0%}; is something on the glass, or a band_hz needed?"
        )


def _left(decay: Array, starts: Sequence[tuple[float, float]], rate_hz: float) -> float:
    """Return what modes as they stand leave of a decay, as a share of its rms."""
    shape = damped(np.arange(decay.size) / rate_hz, starts)
    rest = decay - shape @ np.linalg.lstsq(shape, decay, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(decay - decay.mean()))


def _decays(
    runs: Sequence[xr.Dataset], segment_s: float | None, exclude: Collection[int]
) -> tuple[list[Array], str, float]:
    """Return what follows each good hit, from after its peak until it is lost in the noise."""
    decays, told, rates = [], [], set()
    for run in runs:
        reading, rate_hz = channel(run, READING, READING_UNITS), rate_of(run)
        found = pick_hits(run, segment_s, exclude)
        told.append(found.told())
        rates.add(rate_hz)
        force = run["hammer"].values if found.channel == "hammer" else None
        floor = quiet_noise(reading - np.median(reading))
        for start in found.starts:
            piece = reading[start : start + found.length] - reading[start : start + max(found.before - 2, 1)].mean()
            begin = found.before + _end_of_pulse(force, start, found.before, found.length)
            decay = _audible(piece[begin:], floor, rate_hz)
            if decay.size >= 32:
                decays.append(decay)
    if len(rates) > 1:
        raise FrictionloopError(f"recording: rates {sorted(rates)} Hz: must be one")
    if len(decays) < 2:
        raise FrictionloopError(f"recording: {len(decays)} good hits: must be at least two ({'; '.join(told)})")
    return decays, "; ".join(told), rates.pop()


def _end_of_pulse(force: Array | None, start: int, before: int, length: int) -> int:
    if force is None:
        return 0
    pulse = np.abs(force[start + before : start + length] - np.median(force))
    return int(np.flatnonzero(pulse > 0.02 * pulse.max())[-1]) + 2


def _audible(decay: Array, floor: float, rate_hz: float) -> Array:
    """Return a decay from its largest value to where it is lost in the noise."""
    top = int(np.argmax(np.abs(decay)))
    envelope = maximum_filter1d(np.abs(decay[top:]), max(int(decay.size / 50), 8))
    over = np.flatnonzero(envelope > max(4 * floor, 5e-3 * float(envelope.max())))
    return decay[top : top + int(over[-1]) + 1] if over.size else decay[top:top]


def _slower(decays: list[Array], rate_hz: float) -> tuple[list[Array], float]:
    """Decimate long decays as far as what they contain allows; a filter keeps poles where they are."""
    longest = max(decay.size for decay in decays)
    spectrum = np.mean([np.abs(np.fft.rfft(decay - decay.mean(), longest)) ** 2 for decay in decays], axis=0)
    hertz = np.fft.rfftfreq(longest, 1 / rate_hz)
    top_hz = float(hertz[np.searchsorted(np.cumsum(spectrum), 0.999 * spectrum.sum())])
    factor = min(int(rate_hz / (5 * top_hz)), max(longest // LONGEST, 1) * 4, 12)
    if factor > 1 and longest > 1000:
        decays = [decimate(decay, factor, ftype="fir")[12:] for decay in decays]
        rate_hz /= factor
    return [decay[:LONGEST] for decay in decays], rate_hz


def _lasting(diagram: Sequence[Pole]) -> list[tuple[float, float]]:
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


def _strong(
    decays: Sequence[Array], starts: Sequence[tuple[float, float]], rate_hz: float
) -> list[tuple[float, float]]:
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


def _fit(decay: Array, starts: Sequence[tuple[float, float]], rate_hz: float) -> Array:
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


def _modes(fits: Array) -> list[Mode]:
    """Return the modes from fits of shape (hits, modes, 3): means, and the scatter over hits."""
    hits = len(fits)
    found = []
    for k in range(fits.shape[1]):
        hertz, q, share = fits[:, k, 0], fits[:, k, 1], fits[:, k, 2]
        error_hz, error_q = (float(each.std(ddof=1)) / math.sqrt(hits) for each in (hertz, q))
        wide = float(hertz.mean() / q.mean())
        agreement = 1 - float(hertz.var(ddof=1)) / wide**2
        frequency = Estimate(float(hertz.mean()), error_hz, "Hz", hits - 1.0)
        found.append(
            Mode(frequency, Estimate(float(q.mean()), error_q, "", hits - 1.0), float(share.mean()), agreement)
        )
    return sorted(found, key=lambda mode: mode.frequency.value)


def _chosen(found: Sequence[Mode], which: Which | int, band_hz: tuple[float, float]) -> tuple[int, ...]:
    listed = ", ".join(f"{mode.frequency.value:.5g} Hz ({mode.share:.0%})" for mode in found)
    inside = [k for k, mode in enumerate(found) if band_hz[0] <= mode.frequency.value <= band_hz[1]]
    if not inside:
        raise FrictionloopError(f"band_hz = ({band_hz[0]:g}, {band_hz[1]:g}) Hz: holds no mode; there are {listed}")
    if which == "first":
        return (inside[0],)
    if which == "strongest":
        return (max(inside, key=lambda k: found[k].share),)
    if isinstance(which, int) and not isinstance(which, bool) and 1 <= which <= len(inside):
        return tuple(inside[:which])
    raise FrictionloopError(
        f"which = {which!r}: must be 'first', 'strongest' or a count from 1 to {len(inside)}; there are {listed}"
    )
