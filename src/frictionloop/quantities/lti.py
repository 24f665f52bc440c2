"""The small linear system that every block linearises to, and arrays of real and of complex numbers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities.class_help import Brief

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Lti(metaclass=Brief):
    """A linear block H(s) = num(s) / den(s) * exp(-s delay_s), polynomials with the highest power first."""

    num: tuple[float, ...]
    den: tuple[float, ...]
    delay_s: float = 0.0

    def response(self, frequency_hz: np.ndarray) -> np.ndarray:
        """Return H(j 2 pi f), complex, for frequencies in Hz of any shape."""
        s = 2j * np.pi * np.asarray(frequency_hz)
        return np.asarray(np.polyval(self.num, s) / np.polyval(self.den, s) * np.exp(-s * self.delay_s))

    def __mul__(self, other: Lti) -> Lti:
        """Return the series connection."""
        num, den = np.polymul(self.num, other.num), np.polymul(self.den, other.den)
        return Lti(tuple(num), tuple(den), self.delay_s + other.delay_s)
