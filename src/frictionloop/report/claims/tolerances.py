"""What counts as agreement, by a few rules fixed once for all claims."""

from __future__ import annotations

import math

Interval = tuple[float, float]

LAST_DIGIT = "half a unit of the last printed digit"
STEP_125 = "rounds to the printed gain in the series 1, 2, 5, 10 that the text's gains come from"
HALF_DECADE = "half a decade either way: the text gives a power of ten"
ONE_PERCENT = "0.01 of R² or of the saturation index is what counts as a difference in this report (assumed)"


def as_printed(value: float, last_digit: float) -> Interval:
    """Return the numbers that round to a printed one, ``last_digit`` being the unit of its last digit.

    >>> as_printed(250, 10)
    (245.0, 255.0)
    """
    return value - last_digit / 2, value + last_digit / 2


def nearest_125(value: float) -> Interval:
    """Return the numbers nearer (by ratio) to ``value`` than to its neighbours in 1, 2, 5, 10, 20, ...

    >>> [round(end, 2) for end in nearest_125(5.0)]
    [3.16, 7.07]
    """
    series = [digit * 10.0**power for power in range(-3, 4) for digit in (1, 2, 5)]
    k = min(range(1, len(series) - 1), key=lambda i: abs(math.log(series[i] / value)))
    return math.sqrt(series[k - 1] * series[k]), math.sqrt(series[k] * series[k + 1])


def half_decade(value: float) -> Interval:
    """Return the numbers within a factor of sqrt(10)."""
    return value / math.sqrt(10), value * math.sqrt(10)
