"""D accumulated: sines, and a mean."""

from __future__ import annotations

import math

import numpy as np
import pytest
from streaming import streaming_index, weighted_residual, weighting_error_db

from frictionloop.perception import force_threshold_n

RATE = 5000.0


def sine(frequency_hz, duration_s, amplitude_n=0.01):
    return amplitude_n * np.sin(2 * np.pi * frequency_hz * np.arange(round(duration_s * RATE)) / RATE)


@pytest.mark.parametrize("frequency_hz", [1.0, 2.0, 10.0, 40.0, 100.0, 250.0, 400.0, 500.0])
def test_a_sine_is_its_rms_over_the_threshold_times_the_error_of_the_fit(frequency_hz):
    exact = 0.01 / math.sqrt(2) / float(force_threshold_n(frequency_hz))
    fit = 10 ** (float(weighting_error_db(RATE, frequency_hz=frequency_hz)) / 20)
    # Whole periods; after 5 s the start has decayed to e^-15.
    assert streaming_index(sine(frequency_hz, 10), RATE, skip_s=5.0) == pytest.approx(exact * fit, rel=1e-5)


def test_a_mean_does_not_enter_and_does_not_as_a_start():
    ripple = sine(60.0, 4)
    assert streaming_index(ripple + 2.0, RATE) == pytest.approx(float(streaming_index(ripple, RATE)), rel=1e-9)
    np.testing.assert_array_equal(weighted_residual(np.full(100, 0.4), RATE), 0.0)
