"""A number found from data, with how far it may be off."""

from __future__ import annotations

import math
from typing import NamedTuple

from scipy.stats import t as student

from frictionloop.quantities import FrictionloopError


class Interval(NamedTuple):
    """Ends of a confidence interval."""

    low: float
    high: float


class Estimate(NamedTuple):
    """A value, its standard error (that of chance alone) and its unit."""

    value: float
    standard_error: float
    unit: str
    freedom: float = math.inf
    """Degrees of freedom behind the standard error; infinite where it is known."""

    def interval(self, confidence: float = 0.95) -> Interval:
        """Return the interval that holds the true value with this probability, from Student's distribution.

        Raises ``FrictionloopError`` for a confidence that is not between 0 and 1.
        """
        if not 0 < confidence < 1:
            raise FrictionloopError(f"confidence = {confidence!r}: must be between 0 and 1, for example 0.95")
        half = float(student.ppf((1 + confidence) / 2, self.freedom)) * self.standard_error
        return Interval(self.value - half, self.value + half)

    def __str__(self) -> str:
        """Value and half width of the 95 % interval, to its second digit, and unit."""
        half = self.interval().high - self.value
        if not 0 < half < math.inf:
            return f"{self.value:.6g} {self.unit}".rstrip()
        power = math.floor(math.log10(max(abs(self.value), half)))
        power = 0 if -3 <= power <= 5 else power
        digits = max(power + 1 - math.floor(math.log10(half)), 0)
        text = f"{self.value / 10**power:.{digits}f} +- {half / 10**power:.{digits}f}"
        return (f"({text})e{power} {self.unit}" if power else f"{text} {self.unit}").rstrip()
