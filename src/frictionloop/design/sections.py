"""A controller as a processor runs it: sections of second order, and a PI behind them that has the integrator.

C(z) = (kp + ki Ts/(z - 1)) prod_i (b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2), every coefficient within +-2 (Q31 with
one bit of headroom), every section stable. A gain of any size goes into kp and ki, which a processor scales once.
A synthesis says what else is known of it, and what it leaves to the overdrive.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.analysis.state_space import Complex
from frictionloop.control.notch import Section, section_response
from frictionloop.design.noise_model import NoiseModel
from frictionloop.design.pairing import ANGLES, paired, zeros_of
from frictionloop.design.plants import lead
from frictionloop.design.quadruple import Quadruple, series
from frictionloop.design.weighted_plant import Weights
from frictionloop.parameters import FilteredPiController
from frictionloop.quantities import FrictionloopError

LARGEST = 2.0
"""Largest coefficient, by magnitude."""


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
        return {
            "controller.kind": "filtered_pi",
            "controller.kp": self.kp,
            "controller.ki": self.ki,
            "controller.sections": self.sections,
        }

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C at z = exp(j 2 pi f Ts), error to force command, f in Hz above 0."""
        turn = 2j * np.pi * np.asarray(frequency_hz, dtype=float) * self.period_s
        value = np.asarray(self.kp + self.ki * self.period_s / np.expm1(turn), dtype=complex)
        for section in self.sections:
            value = value * section_response(Section(*section), frequency_hz, 1.0 / self.period_s)
        return np.asarray(value)


def factorise(filter_: Quadruple, kp: float, ki: float, period_s: float) -> Cascade:
    """Return the cascade of a stable filter (one input, one output) behind which kp + ki Ts/(z - 1) stands.

    The first two have what is fast and what rings when it is inverted, as the law wants it (control/filtered_pi).
    Sections are scaled so that no frequency is larger behind any of them than in front of the first; the gain goes into
    kp and ki, its sign into the first section, which is free.

    Raises
    ------
    FrictionloopError
        A pole on or outside the unit circle, more than 12 states, or a coefficient that Q31 with one bit of headroom
        cannot hold.
    """
    poles = np.linalg.eigvals(filter_.A).astype(complex)
    _check_poles(poles)
    zeros, gain = zeros_of(filter_)
    back, so_far, sections = np.exp(-1j * ANGLES), np.ones(ANGLES.size, dtype=complex), []
    for b, a in paired(zeros, poles):
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


def _check_poles(poles: Complex) -> None:
    outside = np.abs(poles) >= 1.0 - 1e-9  # rounding
    if np.any(outside):
        worst = complex(np.asarray(poles)[np.argmax(np.abs(poles))])
        raise FrictionloopError(
            f"the controller is not stable by itself (a pole at {worst:.4g}): ask for less performance or more margin"
        )


Method = Literal["hinf", "lqg"]


@dataclass(frozen=True, eq=False)
class Synthesised:
    """A synthesised controller and how it holds."""

    cascade: Cascade
    """Sections and PI, as the law ``filtered_pi`` runs them."""
    decay: float
    """Of the believed plate over a period, where overdrive stands behind them; 0 without."""
    method: Method
    gamma: float
    """H-infinity norm that the full-order controller keeps; NaN for LQG."""
    order: int
    """States, the integrator included."""
    full_order: int
    """States before reduction."""
    weights: Weights
    """With the performance that was found."""
    noise: NoiseModel = field(repr=False)
    peaks: Mapping[float, float]
    """Largest Ms over the slip lengths by the share that the resonance is off."""
    command_noise_n: float
    """Rms of the command u that sensor noise causes on the bench as described, N."""
    residual_rms_n: float
    """Rms that is left of the disturbance from 1 to 500 Hz on the bench as described, N."""

    @property
    def overrides(self) -> dict[str, object]:
        """The controller as overrides for ``System.evolve``, with feed-forward of the set-point."""
        overdriven = self.decay > 0.0
        return self.cascade.overrides | {"controller.feedforward": True, "controller.overdrive": overdriven}

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C at z = exp(j 2 pi f Ts), error to the force command behind overdrive, f in Hz above 0."""
        return self.cascade.response(frequency_hz) * lead(self.decay, frequency_hz, self.cascade.period_s)


def lagged(controller: Quadruple, decay: float) -> Quadruple:
    """Return the controller in front of overdrive that does what one without it does: the lag 1/lead behind it."""
    p = np.array([[decay]])
    return series([controller, Quadruple(p, np.ones((1, 1)), (1.0 - p) * p, 1.0 - p)]) if decay else controller
