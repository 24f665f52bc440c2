"""What no controller can undo on a bench, and what is left to gain: delay and hold, Bode's integral, the residual."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from frictionloop.analysis.disturbance_spectrum import touch_spectrum
from frictionloop.analysis.linear import LinearLoop, linearise
from frictionloop.analysis.loop_elements import linearise_contact
from frictionloop.analysis.waterbed import waterbed_bound
from frictionloop.parameters import FingerFriction, LowpassSensor, Strokes, System
from frictionloop.perception.detection_thresholds import LOWEST_HZ as TOUCH_HZ
from frictionloop.quantities import Array, Complex, Lti

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


POINTS = 2500
LOWEST_HZ = 1e-3
"""Well below the drift of a load, whose period is some ten seconds."""


class Headroom(NamedTuple):
    """The loop at its mean force on a dry finger, and the best that any linear controller does there.

    Disturbance is what friction noise, tremor and drift of the load do to the force behind the contact, which passes
    them on with its lag. Nothing else is in it: feed-forward, not feedback, follows a set-point; occlusion is slower;
    and sensor noise, clamp, sticking and what a law makes of a measured load are for a simulation to show.
    """

    loop: LinearLoop
    frequency_hz: Array
    sensitivity: Array
    """|S|."""
    least: Array
    """|S| of the least residual (`waterbed_bound`); NaN without a finger that strokes."""
    disturbance_rms_n: float
    """What moves the force without control, N rms; NaN without a finger that strokes, as the next three."""
    disturbance_felt_rms_n: float
    """The part of it from 1 Hz on, where touch begins to count; the rest is drift, which any integral takes away."""
    residual_rms_n: float
    """What this loop leaves of it."""
    least_rms_n: float
    """What the best linear controller with the largest Ms asked for leaves."""
    zero_db_hz: float
    """Lowest frequency at which |S| is 1."""
    least_zero_db_hz: float
    """The same of the least residual."""
    delay_limit_hz: float
    """Highest crossover with 45 degrees of margin if all but delay and hold is inverted."""
    plain_limit_hz: float
    """The same if nothing is inverted."""
    lag: Lag
    """Phase lag at the zero-dB frequency of this loop (of the least residual if it has none), by cause."""
    bode_integral: float
    """Mean of ln|S|; `unstable_sum` says what it must be."""
    unstable_sum: float
    delay_periods: int
    """Periods from a force to the first that answers to it."""


def headroom(system: System, sensitivity_peak: float) -> Headroom:
    """Return what a System's controller leaves, and what any linear one must leave with so large an Ms.

    Parameters
    ----------
    system
        The loop.
    sensitivity_peak
        Largest |S| that the bound may use, above 1.

    Raises
    ------
    FrictionloopError
        The law has no linear analysis at the mean force.
    """
    loop = linearise(system)
    frequency = np.geomspace(LOWEST_HZ, loop.nyquist_hz, POINTS)
    S, fixed = np.abs(loop.responses(frequency)["S"]), stubborn(loop)
    least, rms, zero_db = np.full(POINTS, math.nan), (math.nan,) * 4, math.nan
    if isinstance(system.friction, FingerFriction) and isinstance(system.motion, Strokes):
        lag = np.abs(linearise_contact(system, loop.elements.force_n).response(frequency))
        power = touch_spectrum(system, 0.0)(frequency) * lag**2
        given = {"delay_periods": fixed.delay_periods, "zeros": fixed.zeros.tolist()}
        bound = waterbed_bound(frequency, power, sensitivity_peak, loop.nyquist_hz, **given)
        least, zero_db = bound.sensitivity, bound.zero_db_hz
        whole, felt, left = (
            _rms_n(frequency, each, loop) for each in (power, power * (frequency >= TOUCH_HZ), power * S**2)
        )
        rms = whole, felt, left, bound.residual_rms_n
    own_hz = _zero_db_hz(frequency, S)
    at_hz = next((hz for hz in (own_hz, zero_db) if math.isfinite(hz)), 0.1 * loop.nyquist_hz)
    return Headroom(
        loop, frequency, S, least, *rms, own_hz, zero_db,
        available_crossover_hz(loop), available_crossover_hz(loop, inverted=False), phase_lag(loop, at_hz),
        bode_integral(loop), unstable_sum(loop), fixed.delay_periods,
    )  # fmt: skip


def _rms_n(frequency: Array, power: Array, loop: LinearLoop) -> float:
    """Return the rms of a density, each frequency standing for its band as in `waterbed_bound`."""
    edges = np.concatenate([[0.0], (frequency[1:] + frequency[:-1]) / 2, [loop.nyquist_hz]])
    return math.sqrt(float(np.diff(edges) @ power))


def _zero_db_hz(frequency: Array, S: Array) -> float:
    """Return where |S| first is 1, NaN if it never is or already at the lowest frequency."""
    above = np.flatnonzero(S >= 1.0)
    return float(frequency[above[0]]) if above.size and above[0] > 0 else math.nan
