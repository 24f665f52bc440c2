"""Several modes of a frequency response: of a hammer with a force channel, of a stepped sine, of a table."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.identification.mode import Mode, Modes, Which, chosen_of
from frictionloop.identification.refused import Refused
from frictionloop.identification.response_fit import ResponseFit, fitted, rising, weighed

Array = NDArray[np.float64]
WORST_MISFIT = 0.25
"""Most of a response that its modes may leave unexplained (assumed)."""
WIDEST = 1.0
"""A mode whose 95 % interval is wider than this share of its frequency is none."""


def response_modes(
    found: FrequencyResponse,
    which: Which | int = "first",
    band_hz: tuple[float, float] | None = None,
    *,
    magnitude: bool = False,
) -> Modes:
    """Return the modes of a frequency response, from the lowest up.

        H(f) = c + sum_k (a_k + j b_k f/f_k) / (1 - (f/f_k)^2 + j f/(f_k Q_k))

    Modes are added where the most is left, until two more no longer lower the misfit by a fifth; the poles at each
    number of modes are the stabilisation diagram. Least squares go by the frequencies' power; standard errors are those
    of the sandwich (`sandwich`), and the method's come from leaving out every other frequency.

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
        raise Refused(f"band_hz: holds {hertz.size} frequencies: must hold at least twelve", "response", {})
    weight = np.sqrt(found.input_density[inside] / found.input_density[inside].mean())
    fits, diagram = rising(hertz, seen, weight, magnitude)
    best = fits[-1] if fits else None
    if best is not None and found.hits == 1:
        best, weight = weighed(hertz, seen, weight, best, magnitude)
    curves = {
        "response": {"frequency_hz": hertz.tolist(), "magnitude": np.abs(seen).tolist(),
                     "coherence": found.coherence[inside].tolist(),
                     "fitted": [] if best is None else np.abs(best.model).tolist()},
        "poles": [(pole.order, pole.frequency_hz, pole.stable) for pole in diagram],
        "modes_hz": [] if best is None else best.poles[:, 0].tolist(),
    }  # fmt: skip
    if best is None:
        raise Refused("the response has no peak that stands out of what is around it", "response", curves)
    if best.misfit > WORST_MISFIT:
        listed = ", ".join(f"{each:.5g}" for each in best.poles[:, 0])
        said = f"modes at {listed} Hz leave {best.misfit:.0%} of the response unexplained: must be at most"
        raise Refused(f"{said} {WORST_MISFIT:.0%}; is a band_hz needed?", "response", curves)
    half = fitted(hertz[::2], seen[::2], weight[::2], best.poles, magnitude)
    moved = np.abs(half.poles - best.poles) / math.sqrt(3)
    modes = _modes(best, found, hertz)
    wide = [k for k, mode in enumerate(modes) if _too_wide(mode)]
    if wide:
        bad = modes[wide[0]].frequency
        raise Refused(f"the mode at {bad} cannot be told: its interval is wider than itself", "response", curves)
    chosen = chosen_of(modes, which, band_hz or (0.0, math.inf))
    told = f"{found.hits} hits" if found.hits > 1 else "as the table lists it"
    drawn = tuple(zip(hertz.tolist(), np.abs(best.model).tolist(), strict=True))
    return Modes(
        tuple(modes),
        chosen,
        best.misfit,
        tuple(moved[:, 0]),
        tuple(moved[:, 1]),
        found.hits,
        told,
        tuple(diagram),
        drawn,
    )


def _too_wide(mode: Mode) -> bool:
    interval = mode.frequency.interval()
    return not interval.high - interval.low < WIDEST * mode.frequency.value


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
