"""The pieces of the tracker against scipy, numpy.interp, their formulas and finite differences; what it learns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.signal import lsim

import frictionloop as fl
from frictionloop.control.limit_observer import (
    QUICK_M_S,
    limit_of,
    place_of,
    scheduled,
    sensor_step,
    share_of,
    stuck_share,
)
from frictionloop.control.tracker_gains import observed, sensor_matrices, sensor_step_of, slopes_of, tracker_gains
from frictionloop.control.tracker_state import ScheduleColumns
from frictionloop.parameters.tracking import PLACES, SCHEDULE, TrackerController

DT = 1.0 / 5000
MODEL = fl.bench().controller.model
LN2 = np.log(2.0)


def controller(**changes):
    return TrackerController(**{"model": MODEL, "rate_hz": 5000, "delay_s": 2e-4} | changes)


@pytest.mark.parametrize(("share", "q"), [(0.91, 6.0), (1.0, 20.0), (1.1, 0.7)])
def test_the_observer_is_given_another_resonance(share, q):
    """Only the springs differ from the model: 145 Hz times the share, and a Q of their own."""
    given = observed(controller(resonance_share=share, broadened_q=q)).model_dump()
    assert given == MODEL.model_dump() | {"resonance_hz": pytest.approx(145.0 * share), "resonance_q": q}
    w, p = 2 * np.pi * 145.0 * share, 2 * np.pi * MODEL.sensor_hz
    A = np.array([[0, w, 0], [-w, -w / q, 0], [p, 0, -p]])
    a11, a12, a21, a22, a31, a32, a33 = tracker_gains(controller(resonance_share=share, broadened_q=q)).sensor[:7]
    np.testing.assert_allclose([[a11, a12, 0], [a21, a22, 0], [a31, a32, a33]], expm(A * DT), atol=1e-12)


@pytest.mark.parametrize(
    ("resonance_hz", "q", "sensor_hz"), [(140.0, 4.0, 1000.0), (145.0, 20.0, 300.0), (600.0, 0.6, 80.0)]
)
def test_sensor_step_against_lsim(resonance_hz, q, sensor_hz):
    """A force that goes from sample to sample in lines, as lsim takes it."""
    w, p = 2 * np.pi * resonance_hz, 2 * np.pi * sensor_hz
    A, b = np.array([[0, w, 0], [-w, -w / q, 0], [p, 0, -p]]), np.array([[0], [w], [0]])
    force = np.random.default_rng(0).normal(size=200)
    _, _, expected = lsim((A, b, np.eye(3), np.zeros((3, 1))), force, DT * np.arange(200), interp=True)
    model = MODEL.model_copy(update={"resonance_hz": resonance_hz, "resonance_q": q, "sensor_hz": sensor_hz})
    s, x = sensor_step_of(model, DT), (0.0, 0.0, 0.0)
    for k in range(199):
        x = sensor_step(*x, force[k], force[k + 1], s)
        np.testing.assert_allclose(x, expected[k + 1], atol=1e-9)


def test_stuck_gains_against_the_riccati_recursion():
    """P = F (P - P h h' P / (h' P h + r)) F' + Q until it stays, for a force with a steady slope."""
    A, b0, b1 = sensor_matrices(observed(controller()), DT)
    F = np.zeros((5, 5))
    F[0, :2], F[1, 1], F[2:, 2:], F[2:, 0], F[2:, 1] = 1.0, 1.0, A, b0 + b1, b1
    Q = np.diag([1e-6, 1e-10, 1e-14, 1e-14, 1e-14])
    P = Q.copy()
    for _ in range(5000):
        K = P[:, 4] / (P[4, 4] + 1e-8)
        P = F @ (P - np.outer(K, P[4])) @ F.T + Q
    found = tracker_gains(controller()).own
    given = (found.stuck_friction, found.stuck_spring, found.stuck_rate, found.stuck_reading)
    np.testing.assert_allclose(given, K[[0, 2, 3, 4]], rtol=1e-6)


@given(st.floats(0.0, PLACES[-1]), st.integers(0, len(ScheduleColumns._fields) - 1))
def test_schedule_against_interp(place, column):
    slopes = slopes_of(SCHEDULE)[column]
    expected = np.interp(place, PLACES, [row[column] for row in SCHEDULE])
    assert scheduled(place, slopes) == pytest.approx(expected, rel=1e-12, abs=1e-12)


@given(st.floats(0.0, 1.0), st.floats(0.002, QUICK_M_S))
def test_only_a_slider_s_place_moves_with_the_speed_of_slow_strokes(share, speed_m_s):
    place = place_of(share, speed_m_s)
    assert share * (1 - 1e-15) <= place <= 1.25
    if share <= 0.75 or speed_m_s <= 0.02:
        assert place == pytest.approx(share, rel=1e-15)
    assert place_of(1.0, max(speed_m_s, 0.04)) == 1.25
    assert place_of(0.875, 0.04) == pytest.approx(1.0)


@given(st.floats(0.0, 1.0), st.floats(QUICK_M_S, 1.0, exclude_min=True))
def test_quick_strokes_come_down_the_schedule_to_the_slider_s_row(share, speed_m_s):
    place = place_of(share, speed_m_s)
    assert 1.25 <= place <= PLACES[-1]
    if 0.125 <= share <= 0.75:
        assert place == pytest.approx(2.0 - share)
    assert place_of(1.0, speed_m_s) == 1.25
    assert place_of(0.0, speed_m_s) == PLACES[-1]


@given(st.floats(0, 1000), st.floats(-1, 12), st.floats(0.002, 1.0))
def test_share_is_the_backward_step_of_the_contact(compliance_um_per_n, limit_n, speed_m_s):
    """T = c L / v, share = dt/(dt + T)."""
    T = 1e-6 * compliance_um_per_n * max(limit_n, 0.05) / speed_m_s
    assert share_of(compliance_um_per_n, limit_n, speed_m_s * DT * 1e6) == pytest.approx(DT / (DT + T), rel=1e-12)


@given(st.floats(-3, 3), st.floats(0.2, 1.6), st.floats(0, 2.5))
def test_limit_is_the_law_of_friction(d, fall, a):
    assert limit_of(d, fall, a) == pytest.approx(2.0**d * np.exp(-fall * LN2 * a * a), rel=1e-12)


@pytest.mark.parametrize(
    ("friction", "rising", "valid", "expected"),
    [(1.0, 9, 1, 0.0), (0.9, 9, 1, 0.0), (0.85, 9, 1, 0.5), (0.8, 9, 1, 1.0), (0.5, 9, 1, 1.0), (0.5, 2, 1, 0.0),
     (-0.1, 2, 1, 1.0), (1.0, 9, 0, 1.0)],
)  # fmt: skip
def test_what_looks_stuck(friction, rising, valid, expected):
    """A limit of 1 N, skin that loads by 10 N/s."""
    assert stuck_share(friction, 1.0, float(rising), 10.0, float(valid)) == pytest.approx(expected, abs=1e-12)
