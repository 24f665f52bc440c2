"""The carrier as a timer makes it: pulses of a whole number of clock ticks, their width set by the amplitude.

A train of pulses of duty D has the fundamental (2/pi) sin(pi D) and harmonics (2/(n pi)) sin(n pi D) per volt. An
amplitude that is a share s of the largest (at D = 1/2) needs D = arcsin(s)/pi. Ticks make both the duty and the carrier
frequency whole: timer_hz/carrier_hz is rounded to C ticks a period, and floor(C/2) widths differ.

The band-pass between timer and amplifier: a Butterworth filter given by its zeros and poles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.signal import butter

from frictionloop.parameters.plate_design import Carrier
from frictionloop.quantities import must_be


def period_ticks(timer_hz: float, carrier_hz: float) -> int:
    """Return C, the whole number of clock ticks nearest to a carrier period.

    Raises
    ------
    FrictionloopError
        For a clock with fewer than four ticks a period, which could not even halve an amplitude.
    """
    ticks = round(timer_hz / carrier_hz)
    if ticks < 4:
        raise must_be("timer_hz", timer_hz, f"at least {4 * carrier_hz:g}", "Hz")
    return ticks


def duty_for(share: np.ndarray | float) -> np.ndarray:
    """Return the duty arcsin(s)/pi in 0 to 1/2 for shares s of the largest amplitude; beyond 0 and 1 they are cut."""
    return np.asarray(np.arcsin(np.clip(share, 0.0, 1.0)) / np.pi)


def pulse_ticks(share: np.ndarray | float, ticks: int) -> np.ndarray:
    """Return the pulse width in ticks nearest to the duty for each share, 0 to floor(C/2)."""
    return np.minimum(np.rint(duty_for(share) * ticks), ticks // 2).astype(int)


def share_of(width: np.ndarray | int, ticks: int) -> np.ndarray:
    """Return sin(pi width/C), the fundamental of pulses so wide as a share of the largest."""
    return np.asarray(np.sin(np.pi * np.asarray(width) / ticks))


def amplitude_step(share: float, ticks: int) -> float:
    """Return the distance between the two levels around a share, as a share: (pi/C) cos(pi D) or less."""
    width = min(int(duty_for(share) * ticks), ticks // 2 - 1)
    return float(share_of(width + 1, ticks) - share_of(width, ticks))


def pulses(width: np.ndarray, ticks: int, alignment: str) -> np.ndarray:
    """Return the level (0 or 1) of every tick, one row per carrier period.

    With alignment "centre" pulses grow from the middle of the period, to half a tick, so that their phase stays; with
    "edge" from its start, so that the phase of the fundamental moves by -pi D.
    """
    width = np.asarray(width)[:, None]
    start = (ticks - width) // 2 if alignment == "centre" else np.zeros_like(width)
    tick = np.arange(ticks)
    return ((tick >= start) & (tick < start + width)).astype(float)


class Analogue(NamedTuple):
    """H(s) = gain prod(s - zeros)/prod(s - poles), in rad/s."""

    zeros: np.ndarray
    poles: np.ndarray
    gain: float

    def response(self, frequency_hz: np.ndarray | float) -> np.ndarray:
        """Return H(j 2 pi f), complex, for frequencies in Hz of any shape."""
        s = 2j * np.pi * np.asarray(frequency_hz, dtype=float)[..., None]
        return np.asarray(self.gain * np.prod(s - self.zeros, axis=-1) / np.prod(s - self.poles, axis=-1))

    def residues(self) -> np.ndarray:
        """Return c of H(s) = sum c/(s - poles), for distinct poles that outnumber the zeros."""
        others = [np.prod(pole - np.delete(self.poles, i)) for i, pole in enumerate(self.poles)]
        return np.asarray(self.gain * np.prod(self.poles[:, None] - self.zeros, axis=1) / np.array(others))

    def then(self, other: Analogue) -> Analogue:
        """Return the series connection."""
        zeros, poles = np.append(self.zeros, other.zeros), np.append(self.poles, other.poles)
        return Analogue(zeros, poles, self.gain * other.gain)

    def group_delay_s(self, frequency_hz: np.ndarray | float) -> np.ndarray:
        """Return -d arg H/d omega: by how much the filter delays slow changes of a carrier's amplitude.

        d ln H/ds = sum 1/(s - zeros) - sum 1/(s - poles), and d arg H/d omega is its real part.
        """
        s = 2j * np.pi * np.asarray(frequency_hz, dtype=float)[..., None]
        return np.asarray(np.sum(1 / (s - self.poles), axis=-1).real - np.sum(1 / (s - self.zeros), axis=-1).real)


def band_pass(carrier: Carrier) -> Analogue:
    """Return the band-pass of a carrier's electronics (paper, Sec. 4.1; Butterworth and its order are assumed)."""
    edges = 2 * np.pi * np.array([carrier.band_low_hz, carrier.band_high_hz])
    return Analogue(*butter(carrier.filter_order, edges, btype="bandpass", analog=True, output="zpk"))
