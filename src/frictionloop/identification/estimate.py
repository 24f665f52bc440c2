"""A number found from data, and one of a bench with its uncertainty: within a file, between files, of the method."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, NamedTuple

import numpy as np
from scipy.stats import t as student

from frictionloop.quantities import Array, must_be


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
            raise must_be("confidence", confidence, "between 0 and 1")
        half = float(student.ppf((1 + confidence) / 2, self.freedom)) * self.standard_error
        return Interval(self.value - half, self.value + half)

    def over(self, known: float, unit: str) -> Estimate:
        """Return it over a number that is known."""
        return Estimate(self.value / known, self.standard_error / abs(known), unit, self.freedom)

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


def averaged(values: Array, unit: str) -> Estimate:
    """Return the mean of values, its standard error from their scatter."""
    error = float(values.std(ddof=1)) / math.sqrt(values.size)
    return Estimate(float(values.mean()), error, unit, values.size - 1.0)


@dataclass(frozen=True)
class Measured:
    """One measured value."""

    path: str
    """Dotted name in the System, or a name of its own for what a System has not."""
    value: float
    unit: str
    within: float
    """Standard error of chance within a file."""
    between: float | None
    """Standard error from file to file, beyond that; None, not known, of one file."""
    method: float
    """Standard error of the choices of the method: window, order, band."""
    freedom: float
    """Degrees of freedom of the three together."""
    how: str
    """The method in words."""
    files: tuple[str, ...] = ()
    date: str = ""

    @property
    def error(self) -> float:
        """Standard error of all three: sqrt(within^2 + between^2 + method^2)."""
        return math.sqrt(self.within**2 + (self.between or 0.0) ** 2 + self.method**2)

    @property
    def estimate(self) -> Estimate:
        """The value with the error of all three."""
        return Estimate(self.value, self.error, self.unit, self.freedom)

    def interval(self, confidence: float = 0.95) -> Interval:
        """Return the interval that holds the true value with this probability."""
        return self.estimate.interval(confidence)

    def to_dict(self) -> dict[str, Any]:
        """Return everything for JSON, the interval of 95 % too."""
        freedom = self.freedom if math.isfinite(self.freedom) else None
        return asdict(self) | {"freedom": freedom, "interval_95": list(self.interval())}

    @classmethod
    def from_dict(cls, tree: Mapping[str, Any]) -> Measured:
        """Return a value from what `to_dict` gave."""
        own = {each.name: tree[each.name] for each in fields(cls)}
        freedom = math.inf if tree["freedom"] is None else tree["freedom"]
        return cls(**own | {"freedom": freedom, "files": tuple(tree["files"])})


def measured(path: str, found: Sequence[Estimate], methods: Sequence[float] | None, how: str) -> Measured:
    """Return the mean over files with its three lines; which files they are, the entry says.

        within^2 = sum s_i^2 / n^2,   between^2 = max(scatter^2/n - within^2, 0),   method = mean m_i

    The degrees of freedom are Welch and Satterthwaite's; those of the method count as many, since it is a half range
    and no sample.

    Parameters
    ----------
    path, how
        As in `Measured`.
    found : sequence of Estimate
        The value of each file.
    methods : sequence of float
        Standard error of the method for each file; None: 0.
    """
    count = len(found)
    values = np.array([each.value for each in found])
    within2 = sum(each.standard_error**2 for each in found) / count**2
    between2 = max(float(values.var(ddof=1)) / count - within2, 0.0) if count > 1 else 0.0
    method2 = float(np.mean(methods or 0.0)) ** 2
    parts = [(each.standard_error**2 / count**2, each.freedom) for each in found] + [(between2, count - 1.0)]
    below = sum(part**2 / freedom for part, freedom in parts if part and freedom)
    total = within2 + between2 + method2
    freedom = total**2 / below if below else math.inf
    return Measured(
        path, float(values.mean()), found[0].unit, math.sqrt(within2), math.sqrt(between2) if count > 1 else None,
        math.sqrt(method2), freedom, how,
    )  # fmt: skip
