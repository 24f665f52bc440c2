"""Position, speed and load as measured."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from scipy.linalg import solve_discrete_lyapunov

from frictionloop.parameters.motion import LoadCells, PositionSensor, Touch
from frictionloop.sensing.finger_tracking import CREEP_M_S, TouchState, touch_coefficients, touch_step

DT = 2e-4
QUIET = Touch(position=PositionSensor(noise_um=0.0), load=LoadCells(noise_n=0.0))


@njit
def track(state, position, load, z_position, z_load, coefficients):
    out = np.empty((position.size, 4))
    for k in range(position.size):
        state, seen = touch_step(state, position[k], load[k], z_position[k], z_load[k], coefficients)
        out[k] = seen
    return out


@njit
def touch_lanes(tracked, speed, position, load, z, coefficients):
    out = np.empty((position.size, 11))
    for i in range(position.size):
        state = (tracked[i], speed[i], 0.4, 1e-3, 1e-4, -1.0, 0.02)
        state, seen = touch_step(state, position[i], load[i], z[i], -z[i], coefficients)
        out[i, 0], out[i, 1], out[i, 2], out[i, 3], out[i, 4], out[i, 5], out[i, 6] = state
        out[i, 7], out[i, 8], out[i, 9], out[i, 10] = seen
    return out


def test_a_quiet_sensor_follows_a_stroke_without_lag():
    t = np.arange(0, 1, DT)
    still = np.zeros_like(t)
    seen = track(TouchState(0.0, 0.0), 0.02 * t, still + 0.5, still, still, touch_coefficients(QUIET, DT))
    np.testing.assert_array_equal(seen[:, 0], 0.02 * t)
    np.testing.assert_array_equal(seen[:, 2], 0.5)
    # Error of a critically damped filter after a step of speed: v (1 + w t) e^(-w t) at most.
    wt = 2 * math.pi * 20 * t
    assert np.all(np.abs(seen[:, 1] - 0.02) <= 0.02 * (1 + wt) * np.exp(-wt) + 1e-12)
    np.testing.assert_array_equal(seen[:, 3], seen[:, 1] >= 0.002)


def speed_noise_m_s(sensor, dt):
    """(sigma/dt) sqrt(2 beta^2 / (alpha (4 - 2 alpha - beta))): Kalata, IEEE Trans. AES 20 (1984) 174-182."""
    pole = math.exp(-2 * math.pi * sensor.tracking_hz * dt)
    alpha, beta = 1 - pole * pole, (1 - pole) ** 2
    return 1e-6 * sensor.noise_um / dt * beta * math.sqrt(2 / (alpha * (4 - 2 * alpha - beta)))


def test_a_position_is_rounded_to_its_resolution_after_its_noise():
    rng, q = np.random.default_rng(0), 25e-6
    x, z, still = rng.uniform(-0.1, 0.1, 20_000), rng.standard_normal(20_000), np.full(20_000, 0.5)
    sensor = Touch(position=PositionSensor(noise_um=10.0, resolution_um=25.0), load=LoadCells(noise_n=0.0))
    seen = track(TouchState(0.0, 0.0), x, still, z, 0.0 * z, touch_coefficients(sensor, DT))[:, 0]
    np.testing.assert_allclose(seen, q * np.floor((x + 1e-5 * z) / q + 0.5), atol=1e-15)
    error = seen - (x + 1e-5 * z)
    assert np.abs(error).max() <= 0.5 * q * (1 + 1e-9)
    assert np.std(error) == pytest.approx(q / math.sqrt(12), rel=0.02)  # uniform over a step


def test_noise_of_each_reading():
    n = 400_000
    z = np.random.default_rng(0).standard_normal((2, n))
    way = 0.02 * DT * np.arange(n)
    seen = track(TouchState(0.0, 0.02), way, 0.0 * way + 0.5, *z, touch_coefficients(Touch(), DT))
    assert np.std(seen[:, 0] - way) == pytest.approx(10e-6, rel=5 / math.sqrt(2 * n))
    assert np.std(seen[:, 2]) == pytest.approx(2e-3, rel=5 / math.sqrt(2 * n))
    # The speed decays as e^(-w t): some w n dt/2 = 5000 independent values.
    assert np.std(seen[:, 1]) == pytest.approx(speed_noise_m_s(PositionSensor(), DT), rel=5 / math.sqrt(2 * 5000))


@given(st.floats(0.1, 500), st.floats(0.1, 100))
def test_speed_noise_against_the_covariance_of_the_filter(tracking_hz, noise_um):
    sensor = PositionSensor(tracking_hz=tracking_hz, noise_um=noise_um)
    c = touch_coefficients(Touch(position=sensor), DT)
    gain = np.array([c.position_gain, c.speed_gain * DT])  # speeds per period, so that both are lengths
    predict = np.array([[1.0, 1.0], [0.0, 1.0]])
    keep = predict - np.outer(gain, predict[0])
    covariance = solve_discrete_lyapunov(keep, np.outer(gain, gain), method="bilinear")
    exact = math.sqrt(covariance[1, 1]) * 1e-6 * noise_um / DT
    # Both poles lie at 1 - w dt, from 1e-4 of the circle on: the equation loses (w dt)^-3 of its digits.
    lost = 1e-15 / (2 * math.pi * tracking_hz * DT) ** 3
    assert speed_noise_m_s(sensor, DT) == pytest.approx(exact, rel=1e-9 + lost)


def test_a_lifted_finger_gives_no_valid_reading_and_lands_without_a_jump_of_speed():
    n = 5000
    t = np.arange(n) * DT
    load = np.where((t > 0.3) & (t < 0.6), 0.0, 0.5)
    z = np.random.default_rng(1).standard_normal((2, n))
    seen = track(TouchState(0.0, 0.02), 0.02 * t, load, *z, touch_coefficients(Touch(), DT))
    assert np.all(seen[load == 0.0, 3] == 0.0)
    assert np.all(seen[load == 0.0, 1] == CREEP_M_S)
    assert np.all(seen[(t > 0.01) & (t < 0.3), 3] == 1.0)
    landed = seen[t >= 0.6]
    assert np.max(np.abs(landed[:, 1])) < 0.02 + 0.005  # overshoot of a filter with two equal poles: 13.5 %
    assert np.all(landed[250:, 3] == 1.0)  # 50 ms: 0.75 mm take 38 ms


def test_friction_counts_only_once_the_skin_is_stretched_and_under_most_of_the_load():
    t = np.arange(10_000) * DT
    # Lifts over 50 ms from 1 s on, lands over 50 ms from 1.4 s on.
    load = 0.5 * np.interp(t, [1.0, 1.05, 1.4, 1.45], [1.0, 0.0, 0.0, 1.0])
    still = np.zeros_like(t)
    start = TouchState(0.0, 0.02, 0.5)
    seen = track(start, 0.02 * t, load, still, still, touch_coefficients(QUIET, DT))
    valid = seen[:, 3] == 1.0
    cells = QUIET.load
    assert np.all(valid[load == 0.5] | (t[load == 0.5] > 1.4))
    # The running mean has hardly moved while the load fell to its share; when the finger is back it has followed 0.1 s.
    left = t[np.flatnonzero(~valid)[0]]
    assert left == pytest.approx(1.0 + 0.05 * (1 - cells.touch_share), abs=2e-3)
    back = t[np.flatnonzero(~valid)[-1]]
    presses = 1.4 + 0.05 * cells.touch_share * np.exp([-0.1 / cells.mean_s, 0.0])
    takes = 1e-3 * cells.developed_mm / 0.02
    # The tracked speed has risen to 0.02 and, with two equal poles, up to 13.5 % beyond.
    assert presses[0] + takes / 1.135 <= back <= presses[1] + takes
    assert np.all(valid[t > back])


def test_a_dip_of_the_load_costs_the_dip_alone():
    """Of a finger that trembles, on a stroke backwards: the sign of its readings is that of its measured speed."""
    t = np.arange(10_000) * DT
    load = 0.5 - 0.25 * ((t > 1.0) & (t < 1.02))
    still = np.zeros_like(t)
    seen = track(
        TouchState(0.0, -0.02, 0.5, direction=-1.0), -0.02 * t, load, still, still, touch_coefficients(QUIET, DT)
    )
    np.testing.assert_allclose(seen[t > 0.5, 1], -0.02, rtol=1e-9)
    np.testing.assert_array_equal(seen[:, 3], load == 0.5)


def test_a_finger_that_presses_less_from_now_on_is_believed():
    """The mean follows load N' from N: N' is the share s of it after tau ln((N - N')/(N'/s - N'))."""
    t = np.arange(20_000) * DT
    load, cells = np.where(t < 1.0, 0.5, 0.3), QUIET.load
    still = np.zeros_like(t)
    seen = track(TouchState(0.0, 0.02, 0.5), 0.02 * t, load, still, still, touch_coefficients(QUIET, DT))
    waits = cells.mean_s * math.log(0.2 / (0.3 / cells.touch_share - 0.3))
    away = t[seen[:, 3] == 0.0]
    assert (away[0], away[-1]) == pytest.approx((1.0, 1.0 + waits), abs=2 * DT)


def test_a_finger_at_rest_is_not_sliding():
    state = TouchState(0.0, 0.0)
    for _ in range(100):
        state, (_, speed, load, valid) = touch_step(state, 0.0, 0.5, 0.0, 0.0, touch_coefficients(QUIET, DT))
    assert (speed, load, valid) == (CREEP_M_S, 0.5, 0.0)
    anything = Touch(load=LoadCells(least_speed_mm_s=0.0))
    assert touch_step(state, 0.0, 0.5, 0.0, 0.0, touch_coefficients(anything, DT))[1][3] == 1.0


def stretched(position, half_m, turn_m):
    """Where the skin is stretched, and the direction: its tip stays in the middle of a play that the finger drags."""
    tip, direction, farthest, found = position[0] - half_m, 1.0, position[0], []
    for x in position:
        tip = min(max(tip, x - half_m), x + half_m)
        farthest = max(farthest, x) if direction > 0 else min(farthest, x)
        if (farthest - x) * direction > turn_m:
            direction, farthest = -direction, x
        found.append((direction * (x - tip) >= half_m - 1e-9, direction))
    return np.array(found).T


@given(st.integers(0, 1000), st.sampled_from([0.1, 0.3, 1.0, 3.0]))
def test_a_turn_and_a_tremor_go_through_the_play_of_the_skin(seed, half_way_mm):
    """Against a tip that is dragged, on a smooth random path; the tracked position follows by less than 0.1 mm."""
    rng, t = np.random.default_rng(seed), np.arange(20_000) * DT
    x = 1e-3 * sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in rng.uniform([0, 0.2, 0], [4, 2, 6], (3, 3)))
    touch = QUIET.model_copy(
        update={"load": LoadCells(noise_n=0.0, least_speed_mm_s=0.0, speed_share=0.0, developed_mm=half_way_mm)}
    )
    seen = track(TouchState(x[0], (x[1] - x[0]) / DT), x, 0 * x + 0.5, 0 * x, 0 * x, touch_coefficients(touch, DT))
    valid, direction = stretched(x, 1e-3 * half_way_mm, 1e-3 * touch.load.turn_mm)
    turns = np.sum(np.diff(np.sign(np.diff(x))) != 0)
    # Both switch once a turn, a few milliseconds apart where the finger is slow.
    assert np.mean(seen[:, 3] != valid) <= 0.05 + 0.01 * turns
    assert np.mean(np.sign(seen[:, 1]) != direction) <= 0.05 + 0.01 * turns


@given(st.integers(0, 1000))
def test_a_path_and_its_mirror_are_felt_alike(seed):
    rng, t = np.random.default_rng(seed), np.arange(5000) * DT
    x = 1e-3 * sum(a * np.sin(2 * np.pi * f * t + p) for a, f, p in rng.uniform([0, 0.5, 0], [4, 9, 6], (3, 3)))
    x[2000:2500] = x[2000]  # a pause
    load = np.where(rng.uniform(size=t.size // 500).repeat(500) < 0.2, 0.0, 0.5)
    forth, back = (
        track(TouchState(s * x[0], 0.0, direction=s), s * x, load, 0 * x, 0 * x, touch_coefficients(QUIET, DT))
        for s in (1.0, -1.0)
    )
    np.testing.assert_array_equal(back, forth * [-1.0, -1.0, 1.0, 1.0])
    assert np.ptp(np.sign(forth[2100:2500, 1])) == 0.0  # once the filter has followed


def test_a_turn_takes_twice_the_way_of_a_landing():
    t = np.arange(10_000) * DT
    x = 0.02 * np.abs(t - 1.0)
    seen = track(
        TouchState(x[0], -0.02, 0.5, direction=-1.0), x, 0 * t + 0.5, 0 * t, 0 * t, touch_coefficients(QUIET, DT)
    )
    invalid = np.flatnonzero(seen[:, 3] == 0.0)
    back_m = x[invalid[-1] + 1] - x.min()
    # The tracked position sets out late, by as much as its filter needs to turn: 2 v/w.
    assert back_m == pytest.approx(2e-3 * QUIET.load.developed_mm, abs=2 * 0.04 / (2 * math.pi * 45))
    assert np.all(np.diff(invalid) == 1)


@given(st.lists(st.tuples(*[st.floats(-0.1, 0.1)] * 3, st.floats(0, 1), st.floats(-5, 5)), min_size=32, max_size=32))
def test_lanes_have_the_bits_of_a_single_step(lanes):
    coefficients = touch_coefficients(Touch(), DT)
    together = touch_lanes(*np.array(lanes).T.copy(), coefficients)
    for row, (tracked, speed, position, load, z) in zip(together, lanes, strict=True):
        state, seen = touch_step((tracked, speed, 0.4, 1e-3, 1e-4, -1.0, 0.02), position, load, z, -z, coefficients)
        assert tuple(row) == (*state, *seen)
