"""Several modes from the decays after hits, with or without a hammer that measures, and which of them are asked for."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Finding
from frictionloop.identification.decays import decays_of, slower
from frictionloop.identification.long import Run
from frictionloop.identification.measured import Estimate
from frictionloop.identification.poles import MOST_MODES, Pole, fit_decay, lasting, left_of, stabilisation, strong
from frictionloop.identification.refused import Refused
from frictionloop.quantities import must_be

Array = NDArray[np.float64]
Which = Literal["first", "strongest"]
NO_MODE = "recording: modes = 0: must be 1 or more, with nothing on the glass"
WORST_MISFIT = 0.25
"""Most of the rms of a decay that its modes may leave unexplained (assumed)."""
WORST_START = 0.8
"""The same of poles that are not yet fitted: beyond it no fit is tried (assumed)."""
LONGEST_RING = 10.0
"""A mode that falls by e only after so many times what was heard of a decay is none (assumed)."""


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
    """Poles over order."""
    findings: tuple[Finding, ...] = ()
    """Which hits were left out."""
    bow: float = 0.0
    """Largest slow bow beneath the reading, which was taken off."""
    fitted: tuple[tuple[float, float], ...] = ()
    """Of a response: frequency in Hz, and the magnitude that the modes make there."""

    @property
    def asked(self) -> tuple[Mode, ...]:
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
    raise must_be("which", which, f"'first', 'strongest' or 1 to {len(inside)}: {listed}")


def modes(
    recording: Run | Sequence[Run],
    which: Which | int = "first",
    band_hz: tuple[float, float] | None = None,
    segment_s: float | None = None,
    exclude: Collection[int] = (),
    *,
    count: int | None = None,
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
    count : int, optional
        How many from the lowest up, in place of ``which``.

    Raises
    ------
    FrictionloopError
        For too few good hits, no stable mode or fewer than asked for, or modes that leave more than a quarter of a
        decay unexplained.
    """
    heard = decays_of(recording, segment_s, exclude)
    decays, rate_hz = slower(heard.pieces, heard.rate_hz)
    orders = range(1, MOST_MODES + 5)
    diagram = [pole for pole in stabilisation(decays, rate_hz, orders) if pole.frequency_hz < 0.45 * rate_hz]
    starts = lasting(diagram)
    curves = _drawn(diagram, starts, decays[0], rate_hz)
    if not starts:
        raise Refused(NO_MODE, "hits", curves)
    starts = strong(decays, starts, rate_hz)
    _refuse_misfit(float(np.median([left_of(decay, starts, rate_hz) for decay in decays])), starts, WORST_START, curves)
    fits, starts = _told_apart(decays, starts, rate_hz, curves)
    misfit = float(np.sqrt(np.mean(fits[:, -1, 0] ** 2)))
    _refuse_misfit(misfit, starts, WORST_MISFIT, curves)
    found = _modes(fits[:, :-1, :])
    late = np.array([fit_decay(decay[decay.size // 8 :], starts, rate_hz)[:-1, :2] for decay in decays])
    moved = np.abs(late.mean(axis=0) - fits[:, :-1, :2].mean(axis=0)) / math.sqrt(3)
    return Modes(
        modes=tuple(found),
        chosen=chosen_of(found, which if count is None else count, band_hz or (0.0, rate_hz)),
        misfit=misfit,
        method_hz=tuple(moved[:, 0].tolist()),
        method_q=tuple(moved[:, 1].tolist()),
        hits=len(decays),
        diagram=tuple(diagram),
        findings=tuple(heard.findings()),
        bow=max(each.bow for each in heard.picked),
    )


def _told_apart(
    decays: Sequence[Array], starts: list[tuple[float, float]], rate_hz: float, curves: Mapping[str, Any]
) -> tuple[Array, list[tuple[float, float]]]:
    """Return fits of all decays, shape (decays, modes + 1, 3), and the modes: one that hits do not share is none.

    Of such a mode the Q scatters by more than itself, or it rings on for far longer than anything was heard.
    """
    heard_s = max(decay.size for decay in decays) / rate_hz
    while starts:
        fits = np.array([fit_decay(decay, starts, rate_hz) for decay in decays])
        hertz, q = fits[:, :-1, 0].mean(axis=0), fits[:, :-1, 1]
        doubt = np.maximum(q.std(axis=0) / q.mean(axis=0), q.mean(axis=0) / (LONGEST_RING * math.pi * hertz * heard_s))
        if doubt.max() <= 1:
            return fits, starts
        # One at a time: a pole too many spoils the one beside it.
        starts = [start for k, start in enumerate(starts) if k != int(np.argmax(doubt))]
    raise Refused(NO_MODE, "hits", curves)


def _drawn(
    diagram: Sequence[Pole], starts: Sequence[tuple[float, float]], decay: Array, rate_hz: float
) -> dict[str, Any]:
    """Return what a refusal draws: the poles over order, and the first decay."""
    return {
        "poles": [(pole.order, pole.frequency_hz, pole.stable) for pole in diagram],
        "modes_hz": [hertz for hertz, _ in starts],
        "decay": {"time_s": (np.arange(decay.size) / rate_hz).tolist(), "reading": decay.tolist()},
    }


def _refuse_misfit(
    misfit: float, starts: Sequence[tuple[float, float]], most: float, curves: Mapping[str, Any]
) -> None:
    if misfit > most:
        listed = ", ".join(f"{hertz:.5g}" for hertz, _ in starts)
        said = f"recording: misfit of modes at {listed} Hz = {misfit:.2g}: must be at most {WORST_MISFIT:g}"
        raise Refused(said, "hits", curves)


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
