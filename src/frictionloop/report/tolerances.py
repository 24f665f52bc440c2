"""What counts as agreement: one yardstick for each kind of quantity, fixed once for all claims."""

from __future__ import annotations

import math
from collections.abc import Callable
from decimal import Decimal
from typing import NamedTuple

Interval = tuple[float, float]

R2_STEP = 0.01
"""Smallest difference of R2 that counts: 1 % of the set-point's variance (assumed)."""
R2_MUCH = 0.1
"""Largest difference of R2 that is moderate: ten of the smallest, a tenth of the set-point's variance (assumed)."""
SATURATION_STEP = 0.01
"""Smallest difference of the saturation index that counts: one control period in a hundred (assumed)."""
RMS_FACTOR = 2.0
"""Smallest ratio of two rms forces that counts as louder: 6 dB, a quarter of the power (assumed)."""
SAME = 0.05
"""Largest difference of two computations of one number, as a share of it (assumed; the scatter is below 1 %)."""
OVERSHOOT = 0.1
"""Smallest overshoot that counts, over the step: the tenth that rise times leave out at either end (assumed)."""
MOST = 0.95
"""Share of a population that counts as all of it (assumed)."""
DECADE_FACTOR = math.sqrt(10)
"""Half a decade: where a power of ten ends and the next begins."""


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


def as_measured(value: float) -> Interval:
    """Return the numbers within a factor of ``RMS_FACTOR``."""
    return value / RMS_FACTOR, value * RMS_FACTOR


def as_measured_db(value: float) -> Interval:
    """Return the numbers of dB whose ratio is within a factor of ``RMS_FACTOR``."""
    step = 20.0 * math.log10(RMS_FACTOR)
    return value - step, value + step


def as_measured_r2(r2: float) -> Interval:
    """Return the R2 whose sqrt((1 - R2)/R2) is within a factor of ``RMS_FACTOR`` of the printed one's.

    >>> [round(end, 3) for end in as_measured_r2(0.98)]
    [0.925, 0.995]
    """
    share = (1.0 - r2) / r2
    return 1.0 / (1.0 + share * RMS_FACTOR**2), 1.0 / (1.0 + share / RMS_FACTOR**2)


class Yardstick(NamedTuple):
    """How the numbers that agree with a printed one are found, and the rule in words."""

    rule: str
    accepted: Callable[[float], Interval]


def _between(low: float, high: float) -> Callable[[float], Interval]:
    """Return the yardstick of a statement without a number: the same interval for each."""
    return lambda _: (low, high)


_DECADE = "power of ten: factor √10"
_R2 = f"same R²: within {R2_STEP:g} (assumed)"
_NUMBERS = f"two computations agree within {SAME:.0%} (assumed)"
_FORCE = f"measured force: factor {RMS_FACTOR:g} (assumed)"
_LEVEL = f"noise level: factor {RMS_FACTOR:g} (assumed)"
YARDSTICKS = {
    "rounding": Yardstick("printed number: its rounding (assumed)", as_printed),
    "gain": Yardstick(f"gain: rounding in 1–2–5; useful: R² within {R2_STEP:g} of the largest", nearest_125),
    "power of ten": Yardstick(_DECADE, half_decade),
    "beyond a power of ten": Yardstick(_DECADE, _between(DECADE_FACTOR, math.inf)),
    "same R²": Yardstick(_R2, _between(0.0, R2_STEP)),
    "moderately other R²": Yardstick(f"moderate: R² by at most {R2_MUCH:g} (assumed)", _between(0.0, R2_MUCH)),
    "more saturated": Yardstick(
        f"same saturation index: within {SATURATION_STEP:g} (assumed)", _between(SATURATION_STEP, math.inf)
    ),
    "louder": Yardstick(f"larger force: rms × {RMS_FACTOR:g} (assumed)", _between(RMS_FACTOR, math.inf)),
    "not louder": Yardstick(f"larger force: rms × {RMS_FACTOR:g} (assumed)", _between(0.0, RMS_FACTOR)),
    "same number": Yardstick(_NUMBERS, _between(1.0 - SAME, 1.0 + SAME)),
    "larger number": Yardstick(_NUMBERS, _between(1.0 / (1.0 - SAME), math.inf)),
    "smaller number": Yardstick(_NUMBERS, _between(0.0, 1.0 - SAME)),
    "measured force": Yardstick(_FORCE, as_measured),
    "at most a measured force": Yardstick(_FORCE, lambda value: (0.0, RMS_FACTOR * value)),
    "measured R²": Yardstick(f"measured R²: √(1/R²−1), factor {RMS_FACTOR:g} (assumed)", as_measured_r2),
    "noise level": Yardstick(_LEVEL, as_measured),
    "noise level in dB": Yardstick(_LEVEL, as_measured_db),
    "as fine as": Yardstick(f"residuals: {RMS_FACTOR:g} × noise (assumed)", lambda value: (0.0, RMS_FACTOR * value)),
    "overshoot": Yardstick(f"overshoot: from {OVERSHOOT:.0%} (assumed)", _between(OVERSHOOT, math.inf)),
    "all of them": Yardstick(f"{MOST:.0%} of people are all (assumed)", _between(MOST, 1.0)),
}
"""By the names that the texts of claims use."""
MORE_RULES = ("measured time: its standard deviation", "ends that words set")
"""Those of claims whose texts say what is accepted."""
RULES = tuple(dict.fromkeys([*(yardstick.rule for yardstick in YARDSTICKS.values()), *MORE_RULES]))
"""Every rule once, for the page."""
