"""D accumulated and D over time: sines, events, starts, chunks, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from frictionloop.perception import (
    Fingertip,
    force_threshold_n,
    streaming_index,
    weighted_residual,
    weighting_error_db,
    windowed_index,
)
from frictionloop.quantities import FrictionloopError

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


def test_the_mean_square_of_all_windows_is_that_of_the_record():
    noise = np.random.default_rng(0).normal(size=round(5 * RATE))
    windows = windowed_index(noise, RATE, window_s=0.5)
    assert windows.shape == (19,)
    # Every second window tiles the record.
    assert math.sqrt(np.mean(windows[::2] ** 2)) == pytest.approx(float(streaming_index(noise, RATE)), rel=1e-12)


def test_an_event_is_found_where_it_is():
    event = np.zeros(round(10 * RATE))
    event[round(6.0 * RATE) : round(6.5 * RATE)] = sine(200.0, 0.5)
    windows = windowed_index(event, RATE)
    assert windows.shape == (19,)
    assert int(np.argmax(windows)) in (11, 12)  # 5.5 to 6.5 s and 6 to 7 s both hold all of it
    # Half of the window is filled: half the energy of the sine; the whole record holds a twentieth.
    assert windows.max() / streaming_index(event, RATE) == pytest.approx(math.sqrt(10), rel=0.01)
    # The filter's own rise and decay takes a few ms out of the 500.
    full = 0.01 / math.sqrt(2) / float(force_threshold_n(200.0))
    fit = 10 ** (float(weighting_error_db(RATE, frequency_hz=200.0)) / 20)
    assert windows.max() == pytest.approx(full * fit * math.sqrt(0.5), rel=0.02)


def test_lanes_and_fingers():
    noise = np.random.default_rng(1).normal(size=(2, 3, 10_000))
    together = windowed_index(noise, RATE)
    assert together.shape == (2, 3, 3)
    np.testing.assert_array_equal(together[1, 2], windowed_index(noise[1, 2], RATE))
    assert streaming_index(noise[0, 0], RATE, Fingertip(stiffness_n_m=2000.0)) < streaming_index(noise[0, 0], RATE)


@pytest.mark.parametrize(
    ("residual", "message"),
    [
        ([], r"residual_n has shape \(0,\)"),
        (1.0, r"residual_n has shape \(\)"),
        ([1.0, math.inf], "residual_n = inf N"),
        ("x", "residual_n = 'x'"),
    ],
)
@pytest.mark.parametrize("call", [weighted_residual, streaming_index, windowed_index])
def test_a_residual_holds_forces(call, residual, message):
    with pytest.raises(FrictionloopError, match=rf"^{message}"):
        call(residual, RATE)


def test_windows_and_skips_fit_the_record():
    with pytest.raises(FrictionloopError, match=r"^window_s = 1 s: must be from 0.0004 to the 0.5 s recorded$"):
        windowed_index(np.zeros(2500), RATE)
    for bad in (0.0, 1e-4, -1.0, math.nan):
        with pytest.raises(FrictionloopError, match=r"^window_s = "):
            windowed_index(np.zeros(2500), RATE, window_s=bad)
    with pytest.raises(FrictionloopError, match=r"^skip_s = 0.5 s: must be below the 0.5 s recorded$"):
        streaming_index(np.zeros(2500), RATE, skip_s=0.5)
    with pytest.raises(FrictionloopError, match=r"^skip_s = -1 s"):
        streaming_index(np.zeros(2500), RATE, skip_s=-1.0)
