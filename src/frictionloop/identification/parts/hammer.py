"""Hits of a hammer that measures: what the frequency response says of the modes, and of the pole behind the springs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionloop.identification.channels import rate_of
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import FrequencyResponse, response
from frictionloop.identification.hit_runs import hits_of
from frictionloop.identification.long import Run
from frictionloop.identification.measured import Measured, measured
from frictionloop.identification.mode import Modes
from frictionloop.identification.parts.part import thin
from frictionloop.identification.project import Take
from frictionloop.identification.resonance import fit_resonance
from frictionloop.identification.response_modes import response_modes
from frictionloop.quantities import FrictionloopError

SAME = 0.05
"""Two modes closer than this share are one (assumed)."""
WORST_MISFIT = 0.2
"""Most of a frequency response that one resonance may leave unexplained (assumed)."""


class Hammered(NamedTuple):
    """What the force of a hammer adds to the free decays."""

    extra: list[Measured]
    """The pole behind the springs, where it can be told."""
    mode: tuple[float, float] | None
    """Frequency in Hz and Q of the mode in question, None where the response does not tell it."""
    told: str
    curve: dict[str, list[float]]


def hammered(take: Take, runs: Sequence[Run], free: Modes, near_hz: float, date: str) -> Hammered:
    """Return what the frequency response tells of the mode near a frequency, one of those that ring freely.

    One resonance with a pole behind it is tried first; where that leaves too much, several modes without a pole.
    """
    found = response(runs, take.segment_s or _segment(runs), exclude=take.exclude)
    try:
        fit = fit_resonance(found, (0.2 * near_hz, min(2.5 * near_hz, 0.4 * found.rate_hz)))
    except FrictionloopError:
        return _several(found, take, free, near_hz)
    if fit.misfit > WORST_MISFIT:
        return _several(found, take, free, near_hz)
    told = f"frequency response: resonance {fit.resonance}, Q {fit.q}, gain {fit.gain}"
    one, curve = (fit.resonance.value, fit.q.value), _drawn(found, fit.band_hz)
    if fit.gain.value < 0:
        told += "; the reading falls where the hammer pushes: one of them is inverted (sign = -1 in its map)"
    lag = fit.lag
    if not lag.value > 3 * lag.standard_error:
        return Hammered([], one, f"{told}; the pole behind it cannot be told ({lag})", curve)
    cutoff = Estimate(fit.cutoff_hz, fit.cutoff_hz * lag.standard_error / lag.value, "Hz", lag.freedom)
    how = f"H1 of {found.hits} hits, {fit.band_hz[0]:.0f} to {fit.band_hz[1]:.0f} Hz"
    return Hammered([measured("sensor.cutoff_hz", [cutoff], [0.0], how, take.files, date)], one, told, curve)


def _several(found: FrequencyResponse, take: Take, free: Modes, near_hz: float) -> Hammered:
    heard = [mode.frequency.value for mode in free.modes]
    try:
        several = response_modes(found, "first", take.band_hz or (0.5 * heard[0], 1.4 * heard[-1]))
    except FrictionloopError as refused:
        return Hammered([], None, f"the frequency response is not used: {refused}", {})
    near = [mode for mode in several.modes if abs(mode.frequency.value / near_hz - 1) < SAME]
    listed = ", ".join(f"{mode.frequency.value:.5g} Hz (Q {mode.q.value:.3g})" for mode in several.modes)
    told = f"frequency response: modes at {listed}; of several modes the pole behind them cannot be told"
    if not near:
        return Hammered([], None, f"{told}; none of them is at {near_hz:.5g} Hz", {})
    one = min(near, key=lambda mode: abs(mode.frequency.value - near_hz))
    band = several.modes[0].frequency.value / 2, 1.5 * several.modes[-1].frequency.value
    return Hammered([], (one.frequency.value, one.q.value), told, _drawn(found, band))


def _segment(runs: Sequence[Run]) -> float:
    """Return the longest piece that every recording allows, in s."""
    return min(found.length / rate_of(run) for run, found in hits_of(runs))


def _drawn(found: FrequencyResponse, band_hz: tuple[float, float]) -> dict[str, Any]:
    inside = (found.frequency_hz > 0.5 * band_hz[0]) & (found.frequency_hz < 1.5 * band_hz[1])
    hertz, size = thin(found.frequency_hz[inside], np.abs(found.response[inside]))
    _, coherence = thin(found.frequency_hz[inside], found.coherence[inside])
    return {"frequency_hz": hertz, "magnitude": size, "coherence": coherence}
