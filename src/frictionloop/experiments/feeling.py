"""What a simulated participant feels of a force: weighted by thresholds, how strong a pattern, how wide."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr
from scipy.signal import sosfilt

from frictionloop.parameters import Skin
from frictionloop.perception import weighting_sos
from frictionloop.quantities.checks import Array
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.track import Track

UNCLEAR, FAINTEST = 0.5, 1e-3
"""Spread of a spacing at the threshold of its pattern, relative, and the least strength that it grows to (assumed)."""


def weigh(force: Array, keep: Array, rate_hz: float, skin: Skin) -> Array:
    """Return the scored part of a force in units of its threshold, its straight line taken off."""
    part = force[keep]
    index = np.arange(part.size)
    line = np.polynomial.Polynomial.fit(index, part, 1)
    return np.asarray(sosfilt(weighting_sos(rate_hz, skin), part - line(index)))


def strength_of_period(weighted: Array, place_mm: Array, period_mm: float) -> float:
    """Return the rms of what of a weighted force repeats with a period, wherever it begins."""
    return math.sqrt(2.0) * abs(complex(np.mean(weighted * np.exp(2j * math.pi * place_mm / period_mm))))


def strength_along(weighted: Array, known: Array) -> float:
    """Return the rms of what of a weighted force goes along with a known one, |f.g| / (|g| sqrt n); 0 without that."""
    size = float(np.linalg.norm(known))
    return abs(float(weighted @ known)) / (size * math.sqrt(known.size)) if size > 0.0 else 0.0


def asked_along(effect: Effect, run: xr.Dataset) -> Array:
    """Return the force that an effect asks for along a stroke, N."""
    along, speed, load, time = (run[name].values for name in ("position", "speed", "load", "time"))
    return np.asarray(effect.asked(Track().touch(1e3 * along, 1e3 * speed, load, time)), float)


SHORTEST_MM, LONGEST_MM = 0.5, 12.0
"""Spacings that a finger tells apart (assumed)."""


def felt_spacing_mm(weighted: Array, place_mm: Array) -> float:
    """Return the spacing at which a weighted force repeats most: the peak of its spectrum over place."""
    order = np.argsort(place_mm)
    x = np.linspace(place_mm.min(), place_mm.max(), 2048)
    even = np.interp(x, place_mm[order], weighted[order]) * np.hanning(x.size)
    power = np.abs(np.fft.rfft(even, 8 * x.size)) ** 2
    per_mm = np.fft.rfftfreq(8 * x.size, x[1] - x[0])
    inside = (per_mm >= 1.0 / LONGEST_MM) & (per_mm <= 1.0 / SHORTEST_MM)
    return float(1.0 / per_mm[inside][int(np.argmax(power[inside]))])
