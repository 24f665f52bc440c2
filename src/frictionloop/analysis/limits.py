"""What no controller can undo on a bench: the lag of delay and hold, and Bode's integral of any loop."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.analysis.linear import LinearLoop
from frictionloop.analysis.state_space import Array, Complex
from frictionloop.parameters import LowpassSensor
from frictionloop.quantities import Lti

LEFT_DEG = 180.0 - 90.0 - 45.0
"""What an integral's slope and a margin of 45 degrees leave."""

APART = 1e-9
"""Least relative distance of two panel edges: what is nearer is one, to rounding."""


class Stubborn(NamedTuple):
    """What a law cannot divide out of the sampled plant without becoming unstable or acausal."""

    delay_periods: int
    """Periods from a measured force to the first that answers to it: zeros at infinity."""
    zeros: Complex
    """Zeros outside the unit circle, which sampling makes of many poles in a row."""


class Lag(NamedTuple):
    """Phase lag of the loop without its controller at one frequency, degrees, by cause."""

    delay: float
    """Computing delay."""
    hold: float
    """Half a control period."""
    electronics: float
    """The sensor's pole."""
    springs: float
    """The sensor's resonance."""
    plate: float
    """Plate and contact."""

    @property
    def fixed(self) -> float:
        """What no controller inverts: delay and hold."""
        return self.delay + self.hold

    @property
    def total(self) -> float:
        """All of it, which a controller without inversions has to live with."""
        return sum(self)


def stubborn(loop: LinearLoop) -> Stubborn:
    """Return delay and zeros outside the unit circle of the sampled plant, force command to measured force.

    z^-m (C (z - A)^-1 (new + old/z)): m whole periods of delay, one more by sampling. Many poles slower than the
    sampling leave zeros of the Euler-Frobenius polynomials (Astrom, Hagander, Sternby, "Zeros of sampled systems",
    Automatica 20, 1984), -23.2 and -2.32 for five.
    """
    plant = loop.plant
    zeros = np.roots(plant.numerators()[1])
    return Stubborn(plant.whole_periods + 1, zeros[np.abs(zeros) > 1.0])


def bode_integral(loop: LinearLoop) -> float:
    """Return the mean of ln|S| over 0 to the Nyquist frequency, by quadrature; NaN if the loop is unstable.

    Bode's integral of a stable sampled loop with a delay of at least a period: it equals `unstable_sum`, 0 where
    plant and law are stable, whatever the law. What is pushed down somewhere comes up elsewhere.
    """
    if not loop.is_stable():
        return math.nan

    def log_sensitivity(frequency: Array) -> Array:
        return np.log(np.abs(loop.responses(frequency.ravel())["S"])).reshape(frequency.shape)

    # ln|S| is steep near the poles of S and near its zeros, the poles of law and plant.
    zeros = np.concatenate([loop.law.poles(), np.linalg.eigvals(loop.plant.transition)])
    edges = panel_edges(loop, np.concatenate([loop.poles(), zeros]))
    from scipy.integrate import tanhsinh

    panels = tanhsinh(log_sensitivity, edges[:-1], edges[1:], rtol=1e-9, atol=1e-9 * loop.nyquist_hz / edges.size)
    return float(np.sum(panels.integral)) / loop.nyquist_hz


def panel_edges(loop: LinearLoop, poles: Complex) -> Array:
    """Return the frequencies that cut 0 to the Nyquist frequency into panels on which what has these poles is smooth.

    A pole makes a peak at its frequency, as wide as its damping: panels grow from there by factors of 8.
    """
    logs = np.log(poles[np.abs(poles) > 1e-6]) / (2 * np.pi * loop.plant.period_s)
    widths = np.abs(logs.real)[:, None] * 8.0 ** np.arange(-1, 20)
    centres = np.abs(logs.imag)[:, None]
    edges = np.concatenate([centres, centres - widths, centres + widths], axis=1).ravel()
    tiny = 1e-12 * loop.nyquist_hz  # the spectrum is finite at 0, only its formula is not
    found = np.unique([tiny, *edges[(edges > 2 * tiny) & (edges < loop.nyquist_hz)], loop.nyquist_hz])
    return found[np.append(np.diff(found) > APART * found[1:], True)]


def unstable_sum(loop: LinearLoop) -> float:
    """Return the sum of ln|p| over the poles p of law and plant outside the unit circle: that of `bode_integral`."""
    poles = np.concatenate([loop.law.poles(), np.linalg.eigvals(loop.plant.transition)])
    outside = np.abs(poles)[np.abs(poles) > 1.0 + 1e-9]
    return float(np.sum(np.log(outside)))


def phase_lag(loop: LinearLoop, frequency_hz: float) -> Lag:
    """Return the phase lag of the loop without its controller at a frequency in Hz, by cause."""
    elements = loop.elements

    def lag(*blocks: Lti) -> float:
        return -float(sum(_phase_deg(block, frequency_hz) for block in blocks))

    springs = () if isinstance(loop.system.sensor, LowpassSensor) else elements.stages[:-1]
    return Lag(
        delay=360.0 * frequency_hz * elements.delay_s,
        hold=180.0 * frequency_hz * loop.plant.period_s,
        electronics=lag(elements.stages[-1]),
        springs=lag(*springs),
        plate=lag(elements.plate),
    )


def _phase_deg(block: Lti, frequency_hz: float) -> float:
    """Return the unwrapped phase of a stable block with poles and zeros on the left: the sum of their angles."""
    s = 2j * np.pi * frequency_hz
    zeros, poles = np.roots(block.num), np.roots(block.den)
    # A pair's angles add up to what starts at 0, as those of a real root do.
    turn = float(np.sum(np.angle(s - zeros)) - np.sum(np.angle(s - poles)))
    return math.degrees(turn)


def available_crossover_hz(loop: LinearLoop, inverted: bool = True) -> float:
    """Return the highest frequency at which |G|, falling as 1/f, can be 1 with a phase margin of 45 degrees.

    The rule of Astrom ("Limitations on control system performance", European J. Control 6, 2000): what is not
    invertible may take what slope and margin leave of 180 degrees; a rule of design, not a strict bound. The loop's
    law is not used. ``inverted``: a law undoes plate, contact, springs and the electronics' pole, and delay and hold
    are left; without, nothing is inverted.
    """

    def excess(frequency_hz: float) -> float:
        lag = phase_lag(loop, frequency_hz)
        return (lag.fixed if inverted else lag.total) - LEFT_DEG

    # The hold alone takes 90 degrees at half the rate.
    from scipy.optimize import brentq

    return float(brentq(excess, 1e-9 * loop.nyquist_hz, loop.nyquist_hz, xtol=1e-9, rtol=1e-12))
