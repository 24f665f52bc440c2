"""Resonance, Q and envelope corner of the plate from a stepped sine: amplitude over drive frequency."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import xarray as xr
from scipy.optimize import least_squares

from frictionloop.identification.estimate import Estimate
from frictionloop.identification.frequency_response import sandwich
from frictionloop.identification.recording_columns import channel, rate_of
from frictionloop.quantities import Array, must_be

VIBRATIONS = ("um", "m/s", "V", "")
LEAST_INSIDE = 3
"""Steps that must lie above half the power of the resonance."""
LEAST = 8
"""Samples of a step that are needed."""
WORST_MISFIT = 0.1
"""Most of the rms amplitude that one resonance may leave unexplained (assumed)."""


@dataclass(frozen=True)
class PlateResonance:
    """The mode that the plate is driven at."""

    resonance: Estimate
    """Hz."""
    q: Estimate
    method_hz: float
    """Standard error in Hz of the choices of the method, and in Q below."""
    method_q: float
    misfit: float
    """rms of what the resonance leaves over that of the vibration."""
    how: str
    x: Array
    """What is drawn: frequency in Hz of a sweep, time in s of a decay."""
    y: Array
    fitted: Array

    @property
    def corner(self) -> Estimate:
        """Corner of the envelope in Hz, f/(2 Q)."""
        value = self.resonance.value / (2 * self.q.value)
        share = math.hypot(self.q.standard_error / self.q.value, self.resonance.standard_error / self.resonance.value)
        return Estimate(value, share * value, "Hz", self.q.freedom)

    @property
    def method_corner_hz(self) -> float:
        """Standard error in Hz of the corner from the choices of the method."""
        share = math.hypot(self.method_q / self.q.value, self.method_hz / self.resonance.value)
        return share * self.corner.value


def plate_sweep(recording: xr.Dataset) -> PlateResonance:
    """Return resonance and Q from the amplitude at a few drive frequencies.

        A(f) = G / sqrt((1 - (f/f0)^2)^2 + (f/(f0 Q))^2)

    by least squares, each row over its ``drive`` where that is there. Standard errors are HC3's (`sandwich`); that of
    the method is how far the values move when the rows below half the power are left out, which nearby modes bend.

    Parameters
    ----------
    recording : xarray.Dataset
        A table: ``frequency`` in Hz and ``vibration`` in um, m/s or V over ``row``, and ``drive`` in V if it changes.

    Raises
    ------
    FrictionloopError
        For a column that is missing, fewer than three rows above half the power, or more than a tenth of the amplitude
        that one resonance leaves unexplained.
    """
    frequency = channel(recording, "frequency", ("Hz",), dim="row")
    vibration = np.abs(channel(recording, "vibration", VIBRATIONS, dim="row"))
    if "drive" in recording:
        vibration = vibration / np.abs(channel(recording, "drive", ("V", ""), dim="row"))
    top = int(np.argmax(vibration))
    inside = vibration > vibration[top] / math.sqrt(2)
    if np.count_nonzero(inside) < LEAST_INSIDE or frequency.size < 5:
        seen = f"{np.count_nonzero(inside)} of {frequency.size}"
        raise must_be("recording: frequencies above half power", seen, f"{LEAST_INSIDE} of 5 at least")
    if frequency[top] in (frequency.min(), frequency.max()):
        raise must_be("recording: largest vibration", float(frequency[top]), "inside the sweep", "Hz")
    values, errors, misfit = _fit(frequency, vibration, top)
    if misfit > WORST_MISFIT:
        raise must_be(f"recording: misfit of {values[1]:.6g} Hz", misfit, f"at most {WORST_MISFIT:g}")
    near = vibration > vibration[top] / 2
    moved = values - _fit(frequency[near], vibration[near], int(np.argmax(vibration[near])))[0]
    method = np.abs(moved) / math.sqrt(3) if np.count_nonzero(near) > LEAST_INSIDE + 1 else np.zeros(3)
    order = np.argsort(frequency)
    fine = np.linspace(frequency.min(), frequency.max(), 400)
    return PlateResonance(
        errors[1],
        errors[2],
        float(method[1]),
        float(method[2]),
        misfit,
        f"stepped sine, {frequency.size} frequencies",
        frequency[order],
        vibration[order],
        np.interp(frequency[order], fine, _amplitude(fine, values)),
    )


def _amplitude(frequency: Array, values: Array) -> Array:
    relative = frequency / values[1]
    return np.asarray(values[0] / np.hypot(1 - relative**2, relative / values[2]))


def _fit(frequency: Array, vibration: Array, top: int) -> tuple[Array, list[Estimate], float]:
    """Return gain, resonance in Hz and Q, their errors, and the share that is left."""
    centre, largest = frequency[top], vibration[top]
    inside = frequency[vibration > largest / math.sqrt(2)]
    guess_q = centre / max(float(np.ptp(inside)), float(centre) * 1e-4)

    # Relative to the first guess, so that each parameter is near 0: 46 kHz are found to a part in a million.
    def values(x: Array) -> Array:
        q = guess_q * np.exp(x[2])
        return np.array([largest / q * np.exp(x[0]), centre * (1 + x[1] / guess_q), q])

    def left(x: Array) -> Array:
        return np.asarray((_amplitude(frequency, values(x)) - vibration) / largest)

    fit = least_squares(left, np.zeros(3), xtol=1e-12, ftol=1e-12)
    found = values(fit.x)
    scale = np.array([found[0], centre / guess_q, found[2]])
    errors = sandwich(fit.jac, fit.fun).estimates(found, scale, ("", "Hz", ""))
    return found, errors, float(np.linalg.norm(fit.fun) / np.linalg.norm(vibration / largest))


def stepped(recording: xr.Dataset) -> xr.Dataset:
    """Return a row for each step of the frequency: its amplitudes over the second half, when they have settled.

    Of a channel that goes to and fro the amplitude is that of a sine of the step's frequency, by least squares; of one
    that keeps its sign, as a lock-in's, the mean.
    """
    frequency, rate_hz = channel(recording, "frequency", ("Hz",)), rate_of(recording)
    edges = np.concatenate([[0], np.flatnonzero(np.diff(frequency)) + 1, [frequency.size]])
    halves = [(a + (b - a) // 2, b) for a, b in pairwise(edges.tolist()) if b - a >= 2 * LEAST]
    if 2 * len(halves) < edges.size:
        accepted = f"steps of {2 * LEAST} samples or more"
        raise must_be("recording: frequency", f"{edges.size - 2} changes in {frequency.size} samples", accepted)
    steps = np.array([frequency[b - 1] for _, b in halves])
    rows = {"frequency": ("row", steps, recording["frequency"].attrs)}
    for name in map(str, recording.data_vars):
        if name != "frequency":
            values = np.asarray(recording[name].values, dtype=float)
            found = np.array(
                [_step_amplitude(name, values[a:b], f / rate_hz) for (a, b), f in zip(halves, steps, strict=True)]
            )
            rows[name] = ("row", found, recording[name].attrs)
    return xr.Dataset(rows, attrs=recording.attrs)


def _step_amplitude(name: str, values: Array, periods: float) -> float:
    """Return the amplitude of a channel during a step; ``periods`` in a sample."""
    if abs(values.mean()) > values.std():
        return float(abs(values.mean()))
    if periods > 0.45:
        raise must_be(f"recording: samples of {name!r} per period", 1 / periods, "2.2 or more, or amplitudes")
    angle = 2 * np.pi * periods * np.arange(values.size)
    columns = np.column_stack([np.cos(angle), np.sin(angle), np.ones(values.size)])
    weight = np.linalg.lstsq(columns, values, rcond=None)[0]
    return float(np.hypot(weight[0], weight[1]))
