"""What counts as agreement: one yardstick for each kind of quantity, fixed once for all claims."""

from __future__ import annotations

import math
from decimal import Decimal

Interval = tuple[float, float]

R2_STEP = 0.01
"""Smallest difference of R2 that counts: 1 % of the set-point's variance (assumed)."""
SATURATION_STEP = 0.01
"""Smallest difference of the saturation index that counts: one control period in a hundred (assumed)."""
RMS_FACTOR = 2.0
"""Smallest ratio of two rms forces that counts as louder: 6 dB, a quarter of the power (assumed)."""
SAME = 0.05
"""Largest difference of two computations of one number, as a share of it (assumed; the scatter is below 1 %)."""
DECADE_FACTOR = math.sqrt(10)
"""Half a decade: where a power of ten ends and the next begins."""

R2_RULE = f"R² that differs by less than {R2_STEP:g} is the same (assumed)"
SATURATION_RULE = f"a saturation index that differs by less than {SATURATION_STEP:g} is the same (assumed)"
RMS_RULE = f"a force is louder if its rms is at least {RMS_FACTOR:g} times as large (assumed)"
SAME_RULE = f"two computations of one number agree within {SAME:.0%} (assumed); scatter is below 1%"
LAST_DIGIT = "half a unit of the last digit that is not zero, which is how printed round numbers are taken (assumed)"
STEP_125 = "rounds to the printed gain in the series 1, 2, 5, 10 that the text's gains come from"
HALF_DECADE = "half a decade either way, where the next power of ten begins"
RULES = (
    R2_RULE,
    SATURATION_RULE,
    RMS_RULE,
    SAME_RULE,
    f"a printed number: {LAST_DIGIT}",
    f"a gain of the text: {STEP_125}",
    f"a printed power of ten: {HALF_DECADE}",
)
"""Every rule, for the page."""


def as_printed(value: float) -> Interval:
    """Return the numbers that round to a printed one at its last digit that is not zero.

    >>> as_printed(250.0), as_printed(0.5)
    ((245.0, 255.0), (0.45, 0.55))
    """
    printed = Decimal(repr(value)).normalize()
    half = Decimal(5).scaleb(int(printed.as_tuple().exponent) - 1)
    return float(printed - half), float(printed + half)


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
    return value / DECADE_FACTOR, value * DECADE_FACTOR
