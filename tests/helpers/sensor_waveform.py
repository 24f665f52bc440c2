"""The sensor at the level of its voltages, many samples per period of the excitation.

Every filter is stepped exactly for an input that is straight between samples (first-order hold), which costs
(pi/N)^2/3 in gain at the carrier per stage with N samples per period, 0.04 % over both at 128. The
capacitances change with the motion, C(t) V(t) is formed sample by sample, amplifiers clip, and the demodulator
multiplies. The op-amp's own loop is taken at the capacitance of rest.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from scipy import signal

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.front_end import capacitance_f
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError, Lti

Array = np.ndarray
Noise = Callable[[float, int], Array]
"""Density per root hertz and number of samples to white noise of that density at the rate of the waveform."""

LEAD_S = 5e-3
"""Time before zero in which the electronics settle on the first force: over 20 time constants."""
BLOCK = 4096
"""Periods of the excitation computed at once."""


class Waveform(NamedTuple):
    """What comes out, one value per period of the excitation (its mean over that period)."""

    time_s: Array
    """Middle of each period."""
    force_n: Array
    """Measured force before the converter."""
    clipped: float
    """Share of the samples in which an amplifier was at the end of its swing."""


class _Filter:
    """A linear block stepped through consecutive blocks of samples."""

    def __init__(self, lti: Lti, step_s: float, start: float = 0.0) -> None:
        num, den, _ = signal.cont2discrete((lti.num, lti.den), step_s, method="foh")
        self._num, self._den = num.ravel(), den
        self._state = signal.lfilter_zi(self._num, den) * start if start else np.zeros(len(den) - 1)

    def __call__(self, samples: Array) -> Array:
        out, self._state = signal.lfilter(self._num, self._den, samples, zi=self._state)
        return np.asarray(out)


class _Side:
    """Charge amplifier, band-pass, demodulator and low-pass of one electrode, with its noise."""

    def __init__(self, design: SensorDesign, noise: Noise, step_s: float) -> None:
        amplifier = design.amplifier
        blocks = front_end.charge_amplifier(design, sum(capacitance_f(design)) / 2)
        self._charge, self._voltage, self._current = (_Filter(block, step_s) for block in blocks)
        self._bandpass = _Filter(front_end.bandpass(design), step_s)
        self._lowpass = _Filter(front_end.lowpass(design), step_s)
        self._noise, self._swing_v = noise, amplifier.swing_v
        feedback_ohm = amplifier.feedback_mohm * 1e6
        thermal_a = front_end.thermal_v_rthz(design, feedback_ohm) / feedback_ohm
        self._current_a = math.hypot(thermal_a, amplifier.current_noise_fa_rthz * 1e-15)
        self._voltage_v = amplifier.noise_nv_rthz * 1e-9
        self._resistor_v = front_end.thermal_v_rthz(design, front_end.bandpass_parts(design).resistor_ohm)
        self._buffer_v = design.filters.buffer_noise_nv_rthz * 1e-9
        self._lowpass_v = front_end.thermal_v_rthz(design, front_end.lowpass_resistor_ohm(design))

    def __call__(self, charge: Array, reference: Array) -> tuple[Array, int]:
        n, noise = charge.size, self._noise
        volts = self._charge(charge)
        volts += self._voltage(noise(self._voltage_v, n)) + self._current(noise(self._current_a, n))
        clipped = int(np.count_nonzero(np.abs(volts) > self._swing_v))
        np.clip(volts, -self._swing_v, self._swing_v, out=volts)
        tuned = self._bandpass(volts + noise(self._resistor_v, n)) + noise(self._buffer_v, n)
        return self._lowpass(tuned * reference + noise(self._lowpass_v, n)), clipped


def waveform(
    design: SensorDesign,
    force: Callable[[Array], Array],
    duration_s: float,
    samples_per_period: int = 128,
    seed: int | None = None,
) -> Waveform:
    """Simulate the sensor from the force on its plate to the measured force, carrier and all.

    Parameters
    ----------
    design : SensorDesign
        The sensor.
    force : callable
        Times in s (an array) to force in N; before time zero the first force is held.
    duration_s : float
        Duration in s, rounded to whole periods of the excitation, at least one.
    samples_per_period : int
        Samples per period of the excitation, at least 8; 128 are 15.4 MHz.
    seed : int, optional
        Seed of the electronic noise; without it there is none.

    Raises
    ------
    FrictionloopError
        For fewer samples per period, or a duration of less than one.
    """
    carrier_hz = design.excitation.frequency_hz
    periods = round(duration_s * carrier_hz) if math.isfinite(duration_s) else 0
    if periods < 1:
        raise FrictionloopError(f"duration_s = {duration_s:g} s: must be at least one period, {1 / carrier_hz:g} s")
    if samples_per_period < 8:
        raise FrictionloopError(f"samples_per_period = {samples_per_period}: must be at least 8")
    lead = math.ceil(LEAD_S * carrier_hz)
    volts, clipped = np.empty((2, periods + lead)), 0
    done = 0
    for plus, minus, count in _blocks(design, force, periods + lead, lead, samples_per_period, seed):
        each = plus.size // samples_per_period
        for row, side in enumerate((plus, minus)):
            volts[row, done : done + each] = side.reshape(each, samples_per_period).mean(axis=1)
        done, clipped = done + each, clipped + count
    middle = (samples_per_period - 1) / (2 * samples_per_period)
    measured = front_end.readings(design, *volts[:, lead:]).force_n
    share = clipped / (2 * samples_per_period * (periods + lead))
    return Waveform((np.arange(periods) + middle) / carrier_hz, measured, share)


def _blocks(
    design: SensorDesign,
    force: Callable[[Array], Array],
    periods: int,
    lead: int,
    samples_per_period: int,
    seed: int | None,
) -> Iterator[tuple[Array, Array, int]]:
    """Yield the demodulated voltages of both sides and the number of clipped samples, block after block."""
    carrier_hz = design.excitation.frequency_hz
    rate_hz = carrier_hz * samples_per_period
    random = None if seed is None else np.random.default_rng(seed)

    def noise(density: float, n: int) -> Array:
        return np.zeros(n) if random is None else random.standard_normal(n) * (density * math.sqrt(rate_hz / 2))

    first_n = float(force(np.zeros(1))[0])
    suspension = _Filter(front_end.suspension(design), 1 / rate_hz, first_n)
    sides = tuple(_Side(design, noise, 1 / rate_hz) for _ in range(2))
    turns = np.arange(samples_per_period) / samples_per_period
    carrier = design.excitation.amplitude_v * np.sin(2 * np.pi * turns)
    reference = 2 * np.sin(2 * np.pi * turns + np.angle(front_end.carrier_gain(design)))
    # Held over a period, its density is flat to some 10 kHz and has zeros at the carrier's multiples.
    relative = design.excitation.amplitude_noise_rthz * math.sqrt(carrier_hz / 2)
    for start in range(0, periods, BLOCK):
        count = min(BLOCK, periods - start)
        time_s = (np.arange(count * samples_per_period) + (start - lead) * samples_per_period) / rate_hz
        pushed_n = suspension(np.where(time_s < 0, first_n, force(np.maximum(time_s, 0.0))))
        envelope = np.ones(count) if random is None else 1 + relative * random.standard_normal(count)
        exciting = np.outer(envelope, carrier).ravel()
        capacitances = _capacitances(design, pushed_n)
        (plus, over), (minus, under) = (
            side(c * exciting, np.tile(reference, count)) for side, c in zip(sides, capacitances, strict=True)
        )
        yield plus, minus, over + under


def _capacitances(design: SensorDesign, force_n: Array) -> tuple[Array, Array]:
    rest, gap_m = capacitance_f(design), design.electrodes.gap_um * 1e-6
    moved = force_n / springs.stiffness(design.springs).x_n_per_m / gap_m
    return rest.plus / (1 - moved), rest.minus / (1 + moved)
