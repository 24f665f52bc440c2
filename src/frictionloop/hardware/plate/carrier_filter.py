"""The band-pass between timer and amplifier: a Butterworth filter given by its zeros and poles."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.signal import butter

from frictionloop.parameters.plate_design import Carrier


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
