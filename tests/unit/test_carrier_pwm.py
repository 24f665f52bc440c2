"""Pulses of whole ticks: their spectrum, how fine they are, how they are placed."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from frictionloop.hardware.plate.carrier_pwm import (
    amplitude_step,
    duty_for,
    period_ticks,
    pulse_ticks,
    pulses,
    share_of,
)
from frictionloop.quantities import FrictionloopError


def test_391_levels_at_46_khz_from_36_mhz():
    ticks = period_ticks(36e6, 46e3)
    assert ticks == 783
    levels = share_of(np.arange(392), ticks)
    assert np.all(np.diff(levels) > 0)
    # An odd number of ticks misses half duty by half a tick: 1 - cos(pi/1566) = 2e-6.
    assert levels[-1] == pytest.approx(math.cos(math.pi / 1566), rel=1e-14)


def harmonic(order, duty):
    """The n-th harmonic of pulses over the fundamental at half duty."""
    return abs(math.sin(order * math.pi * duty)) / order


@given(st.integers(4, 2000), st.floats(0, 1), st.sampled_from(["centre", "edge"]))
def test_the_fundamental_and_harmonics_of_a_period(ticks, share, alignment):
    """A Fourier transform of the ticks against the series of a rectangular pulse."""
    width = int(pulse_ticks(share, ticks))
    level = pulses(np.array([width]), ticks, alignment)[0]
    assert level.sum() == width
    spectrum = np.fft.fft(level) / ticks
    for n in range(1, min(6, ticks // 2)):
        # Ticks are boxes: the series is the transform times sinc(n/ticks), half a tick late.
        series = 2 * abs(spectrum[n]) * np.sinc(n / ticks) * math.pi / 2
        assert series == pytest.approx(harmonic(n, width / ticks), abs=1e-12)
    assert harmonic(1, width / ticks) == pytest.approx(share_of(width, ticks), abs=1e-12)
    if width:
        box = np.exp(-1j * np.pi / ticks)  # from the start of a tick to its middle
        middle = -1.0 if alignment == "centre" else 1.0
        turn = -math.pi * width / ticks if alignment == "edge" else 0.0
        turned = np.angle(spectrum[1] * box * middle * np.exp(-1j * turn))
        assert abs(turned) <= math.pi / ticks + 1e-9  # a pulse is centred to half a tick


@given(st.floats(0, 1), st.integers(4, 5000))
def test_amplitude_through_the_arcsine(share, ticks):
    duty = float(duty_for(share))
    assert 0 <= duty <= 0.5
    assert math.sin(math.pi * duty) == pytest.approx(share, abs=1e-15)
    width = int(pulse_ticks(share, ticks))
    assert width <= ticks // 2
    # Half a tick of the width, or the half tick by which an odd period misses half duty.
    assert abs(float(share_of(width, ticks)) - share) <= math.pi / (2 * ticks) + 1e-15


@given(st.floats(0, 1), st.integers(8, 5000))
def test_steps_are_finest_near_full_amplitude(share, ticks):
    step = amplitude_step(share, ticks)
    width = min(int(duty_for(share) * ticks), ticks // 2 - 1)
    assert step == pytest.approx(float(share_of(width + 1, ticks) - share_of(width, ticks)), rel=1e-14)
    assert 0 < step <= math.pi / ticks
    assert step <= amplitude_step(0.0, ticks)


def test_shares_outside_are_cut():
    np.testing.assert_array_equal(pulse_ticks(np.array([-0.5, 0.0, 1.0, 2.0]), 100), [0, 0, 50, 50])


def test_a_clock_too_slow_is_refused():
    with pytest.raises(FrictionloopError, match=r"^timer_hz = 100000 Hz: .*184000$"):
        period_ticks(1e5, 46e3)
