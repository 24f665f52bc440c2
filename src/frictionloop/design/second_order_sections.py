"""A controller as a processor runs it: sections of second order, and a PI behind them that has the integrator.

C(z) = (kp + ki Ts/(z - 1)) prod_i (b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2), every coefficient within +-2 (Q31 with
one bit of headroom), every section stable. A gain of any size goes into kp and ki, which a processor scales once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.control.filtered_pi import FREE
from frictionloop.control.notch import Section, section_response
from frictionloop.design.slicot import Quadruple
from frictionloop.parameters import FilteredPiController
from frictionloop.quantities import Array, Complex, FrictionloopError

LARGEST = 2.0
"""Largest coefficient, by magnitude."""
ANGLES = np.append(np.geomspace(1e-5, np.pi, 2000), 0.0)
"""Angles of z at which the gain of sections is looked at."""
LEAST_DAMPING = 0.2
"""Damping ratio of zeros below which a section is better left free (assumed)."""


@dataclass(frozen=True)
class Cascade:
    """Sections b0, b1, b2, a1, a2 and the PI behind them."""

    kp: float
    """Proportional gain, N/N."""
    ki: float
    """Integral gain, 1/s."""
    sections: tuple[tuple[float, float, float, float, float], ...]
    """Coefficients of every section, in the order in which they run."""
    period_s: float
    """Control period Ts."""

    @property
    def overrides(self) -> dict[str, object]:
        """The controller as overrides for ``System.evolve``."""
        gains = {name: getattr(self, name) for name in ("kp", "ki", "sections")}
        return {"controller.kind": "filtered_pi"} | {f"controller.{name}": value for name, value in gains.items()}

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C at z = exp(j 2 pi f Ts), error to force command, f in Hz above 0."""
        turn = 2j * np.pi * np.asarray(frequency_hz, dtype=float) * self.period_s
        value = np.asarray(self.kp + self.ki * self.period_s / np.expm1(turn), dtype=complex)
        for section in self.sections:
            value = value * section_response(Section(*section), frequency_hz, 1.0 / self.period_s)
        return np.asarray(value)


def factorise(filter_: Quadruple, kp: float, ki: float, period_s: float) -> Cascade:
    """Return the cascade of a stable filter (one input, one output) behind which kp + ki Ts/(z - 1) stands.

    The filter has a direct path, D other than 0: its zeros are the eigenvalues of A - B C/D.
    Sections are scaled so that no frequency is larger behind any of them than in front of the first; the gain goes into
    kp and ki, its sign into the first section, which is free.

    Raises
    ------
    FrictionloopError
        A pole on or outside the unit circle, more than 12 states, or a coefficient that Q31 with one bit of headroom
        cannot hold.
    """
    A, B, C, D = filter_
    gain, poles = float(D[0, 0]), np.linalg.eigvals(A).astype(complex)
    if np.any(np.abs(poles) >= 1.0 - 1e-9):  # rounding
        worst = complex(poles[np.argmax(np.abs(poles))])
        raise FrictionloopError(f"unstable controller (pole at {worst:.4g})")
    back, so_far, sections = np.exp(-1j * ANGLES), np.ones(ANGLES.size, dtype=complex), []
    for b, a in paired(np.linalg.eigvals(A - B @ C / gain).astype(complex), poles):
        shape = so_far * np.polyval(b[::-1], back) / np.polyval(a[::-1], back)
        size = max(float(np.abs(shape).max()), float(np.abs(b).max()) / LARGEST)
        so_far, gain = shape / size, gain * size
        b0, b1, b2, a1, a2 = map(float, (*(b / size), *a[1:]))
        sections.append((b0, b1, b2, a1, a2))
    if gain < 0.0 and sections:  # as with a zero beyond z = 1: the first section turns the sign, not the PI
        b0, b1, b2, a1, a2 = sections[0]
        sections[0], gain = (-b0, -b1, -b2, a1, a2), -gain
    cascade = Cascade(kp * gain, ki * gain, tuple(sections), period_s)
    FilteredPiController(kp=cascade.kp, ki=cascade.ki, sections=cascade.sections)  # refuses what the law cannot run
    return cascade


def paired(zeros: Complex, poles: Complex) -> list[tuple[Array, Array]]:
    """Return b and a of each section, highest power of 1/z last, those farthest from z = 1 first.

    Each pair of poles takes the pair of zeros with which its gain varies least over frequency, but zeros whose inverse
    would ring (`_poorly_damped`) go to the first two sections, which the law leaves free (control/filtered_pi).
    """
    from scipy.optimize import linear_sum_assignment

    back, overs = np.exp(-1j * ANGLES[::8]), _pairs(zeros)
    unders = sorted(_pairs(poles), key=lambda a: -float(np.abs(1 - np.roots(a)).min()))
    swing = np.array(
        [[_swing(b, a, back) + 1e3 * (i >= FREE and _poorly_damped(b)) for b in overs] for i, a in enumerate(unders)]
    )
    mates = linear_sum_assignment(swing)[1] if unders else []
    return [(overs[mate], a) for a, mate in zip(unders, mates, strict=True)]


def _pairs(roots: Complex) -> list[Array]:
    """Return 1 + c1/z + c2/z^2 for each conjugate pair, and for neighbours among the real roots."""
    real = np.sort(roots[np.abs(roots.imag) <= 1e-12].real)[::-1]
    found = [np.array([1.0, -2 * r.real, abs(r) ** 2]) for r in roots[roots.imag > 1e-12]]
    found += [np.poly(real[i : i + 2]) for i in range(0, len(real), 2)]
    return [np.concatenate([c, np.zeros(3 - len(c))]) for c in found]


def _swing(b: Array, a: Array, back: Complex) -> float:
    """Return by how much the logarithm of a section's gain varies over frequency."""
    size = np.abs(np.polyval(b[::-1], back) / np.polyval(a[::-1], back))
    return float(np.ptp(np.log(np.maximum(size, 1e-12))))


def _poorly_damped(b: Array) -> bool:
    """Return whether 1/b is unstable or rings: a root of b not inside the unit circle, or with little damping."""
    roots = np.roots(b).astype(complex)
    roots = np.log(roots[np.abs(roots) > 1e-6])
    return bool(np.any(-roots.real < np.maximum(LEAST_DAMPING * np.abs(roots), 1e-9)))
