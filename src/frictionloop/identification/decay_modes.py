"""Several modes from the decays after hits, with or without a hammer that measures, and which of them are asked for."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter1d
from scipy.optimize import linear_sum_assignment
from scipy.signal import decimate

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate, averaged
from frictionloop.identification.hit_onsets import noise_of, without_bow
from frictionloop.identification.hits import Hits, hits_left_out, hits_of, left_out_hits, too_few
from frictionloop.identification.matrix_pencil import (
    LEAST_SHARE,
    MOST_MODES,
    Pole,
    drawn_poles,
    fit_decay,
    lasting,
    rest_of,
    stabilisation,
    strong,
    with_weak,
)
from frictionloop.identification.project_entry_result import Refused
from frictionloop.identification.recording_columns import READING, READING_UNITS, channel, rate_of
from frictionloop.identification.recording_file import Run
from frictionloop.quantities import Array, must_be

PULSE = 0.02
"""Share of its peak below which a hammer's force has ended (assumed)."""
ABOVE_HAMMER = 8.0
"""Standard deviations of the hammer's noise that count as force; quiet times tell the noise somewhat low (assumed)."""
LONGEST = 2000
"""Samples of a decay that are fitted; a longer one is decimated as its frequencies allow."""
Which = Literal["first", "strongest"]
NO_MODE = str(must_be("recording: modes", 0, "1 or more"))
WORST_MISFIT = 0.25
"""Most of the rms of a decay that its modes may leave unexplained (assumed)."""
WORST_START = 0.8
"""The same of poles that are not yet fitted: beyond it no fit is tried (assumed)."""
UNLIKE = 3.0
"""A hit of which so many times as much is left as of the median one is none of these (assumed)."""
LONGEST_RING = 10.0
"""A mode that falls by e only after so many times what was heard of a decay is none (assumed)."""


def decays_of(
    runs: Run | Sequence[Run], segment_s: float | None, exclude: Collection[int]
) -> tuple[dict[int, Array], float, list[Hits], list[Finding]]:
    """Return what follows each good hit until it is lost in the noise, the rate, all hits, and which are left out.

    With fewer than two good hits those that are cut off are used as well: a free decay need not come to its end.
    """
    decays: dict[int, Array] = {}
    cut: dict[int, Array] = {}
    picked, rates = [], set()
    for run, found in hits_of(runs, segment_s, exclude):
        reading, rate_hz = without_bow(channel(run, READING, READING_UNITS))[0], rate_of(run)
        picked.append(found)
        rates.add(rate_hz)
        force = run["hammer"].values if found.channel == "hammer" else None
        floor = noise_of(reading, rate_hz)
        for hit in found.table:
            onset = round((hit.time_s - float(run["time"][0])) * rate_hz)
            if hit.verdict in ("good", "cut off"):
                decay = _decay(reading, force, onset, found, floor)
                if decay.size >= 32:
                    (decays if hit.verdict == "good" else cut)[hit.number] = decay
    if len(rates) > 1:
        raise must_be("recording: rates", sorted(rates), "one", "Hz")
    used = cut if len(decays) < 2 <= len(decays) + len(cut) else {}
    if len(decays) + len(used) < 2:
        raise too_few(picked, len(decays))
    left_out = hits_left_out(picked, ("good", "cut off") if used else ("good",))
    return decays | used, rates.pop(), picked, left_out


def _decay(reading: Array, force: Array | None, onset: int, found: Hits, floor: float) -> Array:
    """Return what follows one hit."""
    start, stop = max(onset - found.before, 0), onset - found.before + found.length
    ahead = reading[start : max(onset - 2, start + 1)]
    piece = reading[start:stop] - (ahead.mean() if ahead.size > 8 else np.median(reading[start:stop]))
    begin = onset - start
    return _audible(piece[begin + _end_of_pulse(force, start, begin, stop - start, found.noise) :], floor)


def _end_of_pulse(force: Array | None, start: int, before: int, length: int, noise: float) -> int:
    """Return how many rows after a hit its force has ended: below a fiftieth of its peak, or its noise, for as long."""
    if force is None:
        return 0
    pulse = np.abs(force[start + before : start + length] - np.median(force))
    pushed = np.flatnonzero(pulse > max(PULSE * pulse.max(), ABOVE_HAMMER * noise))
    pushed = pushed[pushed >= int(np.argmax(pulse))]
    over = np.flatnonzero(np.diff(pushed) > 4 * pushed[0] + 16)
    return int(pushed[over[0] if over.size else -1]) + 2


def _audible(decay: Array, floor: float) -> Array:
    """Return a decay from its largest value to where it is lost in the noise."""
    top = int(np.argmax(np.abs(decay)))
    envelope = maximum_filter1d(np.abs(decay[top:]), max(int(decay.size / 50), 8))
    over = np.flatnonzero(envelope > max(4 * floor, 5e-3 * float(envelope.max())))
    # A copy: a view would keep the whole piece of each hit in the memory.
    return decay[top : top + int(over[-1]) + 1].copy() if over.size else decay[top:top]


def slower(decays: list[Array], rate_hz: float) -> tuple[list[Array], float]:
    """Decimate long decays as far as what they contain allows; a filter keeps poles where they are."""
    longest = max(decay.size for decay in decays)
    spectrum = np.zeros(longest // 2 + 1)
    for decay in decays:
        spectrum += np.abs(np.fft.rfft(decay - decay.mean(), longest)) ** 2
    hertz = np.fft.rfftfreq(longest, 1 / rate_hz)
    top_hz = float(hertz[np.searchsorted(np.cumsum(spectrum), 0.999 * spectrum.sum())])
    factor = min(int(rate_hz / (5 * top_hz)), max(longest // LONGEST, 1) * 4, 12)
    if factor > 1 and longest > 1000:
        decays = [decimate(decay, factor, ftype="fir")[12:] for decay in decays]
        rate_hz /= factor
    return [decay[:LONGEST] for decay in decays], rate_hz


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
    diagram: tuple[Pole, ...]
    """Poles over order; none of a response."""
    findings: tuple[Finding, ...] = ()
    """Which hits were left out."""
    bow: float = 0.0
    """Largest slow bow beneath the reading, which was taken off."""
    fitted: tuple[tuple[float, float], ...] = ()
    """Of a response: frequency in Hz, and the magnitude that the modes make there."""

    def drawn(self) -> dict[str, Any]:
        """Return the poles over order, and the modes."""
        return drawn_poles(self.diagram, [mode.frequency.value for mode in self.modes])

    @property
    def chosen_modes(self) -> tuple[Mode, ...]:
        """The modes that were asked for."""
        return tuple(self.modes[k] for k in self.chosen)


def chosen_of(found: Sequence[Mode], which: Which | int, band_hz: tuple[float, float]) -> tuple[int, ...]:
    """Return which modes are asked for, listing what there is where they are not."""
    listed = ", ".join(f"{mode.frequency.value:.5g} Hz ({mode.share:.0%})" for mode in found)
    inside = [k for k, mode in enumerate(found) if band_hz[0] <= mode.frequency.value <= band_hz[1]]
    if not inside:
        raise must_be("band_hz", band_hz, f"around a mode: {listed}", "Hz")
    if which == "first":
        return (inside[0],)
    if which == "strongest":
        return (max(inside, key=lambda k: found[k].share),)
    if isinstance(which, int) and not isinstance(which, bool) and 1 <= which <= len(inside):
        return tuple(inside[:which])
    raise must_be("which", which, f"'first', 'strongest', 1 to {len(inside)}: {listed}")


def modes(
    recording: Run | Sequence[Run],
    which: Which | int = "first",
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
    pieces, rate_hz, picked, left_out = decays_of(recording, segment_s, exclude)
    decays, rate_hz = slower([*pieces.values()], rate_hz)
    orders = range(1, MOST_MODES + 5)
    diagram = [pole for pole in stabilisation(decays, rate_hz, orders) if pole.frequency_hz < 0.45 * rate_hz]
    starts = lasting(diagram)
    first = {"time_s": (np.arange(decays[0].size) / rate_hz).tolist(), "reading": decays[0].tolist()}
    curves = {**drawn_poles(diagram, [hertz for hertz, _ in starts]), "decay": first}
    if not starts:
        raise Refused(NO_MODE, "hits", curves)
    starts = strong(decays, starts, rate_hz)
    left = np.median(
        [np.linalg.norm(rest_of(each, starts, rate_hz)) / np.linalg.norm(each - each.mean()) for each in decays]
    )
    refuse_misfit("hits", float(left), starts, curves, WORST_START)
    fits, starts = _told_apart(decays, with_weak(decays, starts, rate_hz), rate_hz, curves)
    alike = _alike(decays, fits[:, -1, 0])
    if not alike.all():
        others = [number for number, one in zip(pieces, alike, strict=True) if not one]
        why = f"{fits[~alike, -1, 0].max():.0%} unexplained, {np.median(fits[alike, -1, 0]):.1%} of the others"
        left_out.append(left_out_hits(others, why))
    decays, fits = [decay for decay, one in zip(decays, alike, strict=True) if one], fits[alike]
    misfit = float(np.sqrt(np.mean(fits[:, -1, 0] ** 2)))
    refuse_misfit("hits", misfit, fits[:, :-1, :2].mean(axis=0).tolist(), curves)
    hertz, share = fits[:, :-1, 0].mean(axis=0), fits[:, :-1, 2].mean(axis=0)
    part = np.array([k for k in np.argsort(hertz) if share[k] >= min(LEAST_SHARE, share.max())])
    late = _fits([decay[decay.size // 8 :] for decay in decays], starts, rate_hz)[:, part, :2]
    fits = fits[:, part]
    found = _modes(fits)
    moved = np.abs(late.mean(axis=0) - fits[:, :, :2].mean(axis=0))
    return Modes(
        modes=tuple(found),
        chosen=chosen_of(found, which, band_hz or (0.0, rate_hz)),
        misfit=misfit,
        method_hz=tuple(moved[:, 0].tolist()),
        method_q=tuple(moved[:, 1].tolist()),
        hits=len(decays),
        diagram=tuple(diagram),
        findings=tuple(left_out),
        bow=max(each.bow for each in picked),
    )


def _told_apart(
    decays: Sequence[Array], starts: list[tuple[float, float]], rate_hz: float, curves: Mapping[str, Any]
) -> tuple[Array, list[tuple[float, float]]]:
    """Return fits of all decays, shape (decays, modes + 1, 3), and the modes: one that hits do not share is none.

    Of such a mode the Q scatters by more than itself, or it rings on for far longer than anything was heard.
    """
    heard_s = max(decay.size for decay in decays) / rate_hz
    while starts:
        fits = _fits(decays, starts, rate_hz)
        hertz, q = fits[:, :-1, 0].mean(axis=0), fits[:, :-1, 1]
        doubt = np.maximum(q.std(axis=0) / q.mean(axis=0), q.mean(axis=0) / (LONGEST_RING * math.pi * hertz * heard_s))
        if doubt.max() <= 1:
            return fits, starts
        # One at a time: a pole too many spoils the one beside it.
        starts = [start for k, start in enumerate(starts) if k != int(np.argmax(doubt))]
    raise Refused(NO_MODE, "hits", curves)


def _fits(decays: Sequence[Array], starts: Sequence[tuple[float, float]], rate_hz: float) -> Array:
    """Return fits of all decays, modes in the order of those they came from: two of a hit may have changed places."""
    fits = []
    for fit in (fit_decay(decay, starts, rate_hz) for decay in decays):
        apart = np.abs(np.log(fit[:-1, None, :2] / np.array(starts))) @ np.array([1.0, 0.1])
        fits.append(np.concatenate([fit[:-1][linear_sum_assignment(apart.T)[1]], fit[-1:]]))
    return np.array(fits)


def _alike(decays: Sequence[Array], misfits: Array) -> NDArray[np.bool_]:
    """Return which hits the modes explain as well as the others; nothing else shows a second blow in a ringing."""
    left = misfits * np.array([np.std(decay) for decay in decays])
    alike = (misfits <= UNLIKE * np.median(misfits)) | (left <= UNLIKE * np.median(left))
    return alike if np.count_nonzero(alike) > 1 else np.ones(len(decays), dtype=bool)


def refuse_misfit(
    kind: str, misfit: float, found: Sequence[Sequence[float]], curves: Mapping[str, Any], most: float = WORST_MISFIT
) -> None:
    """Refuse modes that leave too much, and say which these are: frequency in Hz and Q of each."""
    if misfit > most:
        listed = ", ".join(f"{hertz:.5g} Hz (Q {q:.3g})" for hertz, q in found)
        what = "response" if kind == "response" else "recording"
        said = must_be(f"{what}: misfit of {listed}", float(f"{misfit:.2g}"), f"at most {WORST_MISFIT:g}")
        raise Refused(str(said), kind, curves)


def _modes(fits: Array) -> list[Mode]:
    """Return the modes from fits of shape (hits, modes, 3): means, and the scatter over hits."""
    found = []
    for hertz, q, share in fits.transpose(1, 2, 0):
        wide = float(hertz.mean() / q.mean())
        agreement = 1 - float(hertz.var(ddof=1)) / wide**2
        found.append(Mode(averaged(hertz, "Hz"), averaged(q, ""), float(share.mean()), agreement))
    return found
