"""Controllers as sections, against the state space they come from; the disturbance that one is made for."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, sosfilt, zpk2ss

from frictionloop.design.friction_noise import fit_shaping, identify_noise
from frictionloop.design.second_order_sections import factorise
from frictionloop.design.slicot import Quadruple
from frictionloop.parameters import bench
from frictionloop.physics.roughness import WAVES

PERIOD_S = 2e-4
F = np.append(np.geomspace(0.1, 2499.0, 400), 2500.0)
Z = np.exp(2j * np.pi * F * PERIOD_S)
inside = st.floats(-0.98, 0.98)
pairs = st.tuples(st.floats(0.05, 0.98), st.floats(0.02, 3.1)).map(
    lambda p: [p[0] * np.exp(1j * p[1] * s) for s in (1, -1)]
)


@st.composite
def filters(draw: st.DrawFn) -> tuple[Quadruple, np.ndarray, np.ndarray, float]:
    """A stable filter of at most 12 states with a direct path, whose poles and zeros lie apart, and these."""
    poles = [*np.ravel(draw(st.lists(pairs, max_size=4))), *draw(st.lists(inside, max_size=4))]
    zeros = [*np.ravel(draw(st.lists(pairs, min_size=len(poles) // 2, max_size=len(poles) // 2)))]
    zeros += draw(st.lists(inside, min_size=len(poles) % 2, max_size=len(poles) % 2))
    gain = draw(st.floats(1e-3, 1e3))
    poles, zeros = np.array(poles, dtype=complex), np.array(zeros, dtype=complex)
    apart = np.abs(poles[:, None] - poles[None, :]) + 9 * np.eye(len(poles))
    if poles.size and apart.min() < 0.02:
        poles = poles[:0]
        zeros = zeros[:0]
    if not poles.size:  # zpk2ss would make up a state
        empty = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[gain]])
        return Quadruple(*empty), zeros[:0], poles, gain
    gain *= draw(st.sampled_from([1.0, -1.0]))
    return Quadruple(*zpk2ss(zeros, poles, gain)), zeros, poles, gain


@settings(max_examples=60)
@given(made=filters(), kp=st.floats(0.01, 10), ki=st.floats(0, 500))
def test_sections_are_the_filter_and_hold_their_bounds(made, kp, ki) -> None:
    filter_, zeros, poles, gain = made
    found = factorise(filter_, kp, ki, PERIOD_S)
    wanted = gain * np.prod(Z[:, None] - zeros, axis=1) / np.prod(Z[:, None] - poles, axis=1)
    wanted = wanted * (kp + ki * PERIOD_S / (Z - 1))
    assert found.response(F) == pytest.approx(wanted, rel=1e-4, abs=1e-6 * np.abs(wanted).max())
    assert len(found.sections) == (len(poles) + 1) // 2
    assert found.kp > 0 and found.ki >= 0  # which the law refuses otherwise
    so_far = 1.0
    for b0, b1, b2, a1, a2 in found.sections:
        assert max(map(abs, (b0, b1, b2, a1, a2))) <= 2.0
        assert abs(a2) < 1 and abs(a1) < 1 + a2  # the triangle of stable sections
        so_far = so_far * (b0 + b1 / Z + b2 / Z**2) / (1 + a1 / Z + a2 / Z**2)
        assert np.abs(so_far).max() <= 1 + 1e-2


def test_sections_run_as_the_state_space_does() -> None:
    rng = np.random.default_rng(0)
    filter_ = Quadruple(
        *zpk2ss(
            [0.9, 0.5, 0.97 * np.exp(0.2j), 0.97 * np.exp(-0.2j), -0.6],
            [0.99, -0.3, 0.8 * np.exp(0.3j), 0.8 * np.exp(-0.3j), 0.2],
            3.0,
        )
    )
    cascade, e = factorise(filter_, 0.7, 90.0, PERIOD_S), rng.normal(size=400)
    x, filtered = np.zeros(5), []
    for value in e:
        filtered.append(float((filter_.C @ x + filter_.D[0] * value)[0]))
        x = filter_.A @ x + filter_.B[:, 0] * value
    wanted = 0.7 * np.array(filtered) + lfilter([0.0, 90.0 * PERIOD_S], [1.0, -1.0], filtered)
    sos = np.array([[*s[:3], 1.0, *s[3:]] for s in cascade.sections])
    y = sosfilt(sos, e)
    found = cascade.kp * y + lfilter([0.0, cascade.ki * PERIOD_S], [1.0, -1.0], y)
    assert found == pytest.approx(wanted, rel=1e-9, abs=1e-9 * np.abs(wanted).max())


def test_no_sections_is_a_pi() -> None:
    empty = Quadruple(np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.array([[2.0]]))
    found = factorise(empty, 0.5, 60.0, PERIOD_S)
    assert (found.kp, found.ki, found.sections) == (1.0, 120.0, ())
    assert found.overrides["controller.kind"] == "filtered_pi"


STILL = {
    "motion.load_drift": 0.0,
    "friction.occlusion_ratio": 1.0,
    "friction.moist_loss": 0.0,
    "finger.slip_length_um": 0.0,
}
ROUGH = bench().evolve(STILL | {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0})
TREMBLES = bench().evolve(STILL | {"motion.tremor_um": 0.0, "friction.roughness_rms": 0.0})


def test_roughness_is_one_over_f_of_the_given_rms() -> None:
    found = identify_noise(ROUGH, seeds=range(6))
    f = found.spectrum["frequency"].values
    band = (f > 5) & (f < 100)
    # Mean square (0.05 F)^2 spread as 1/k over WAVES waves; a slider of stiff skin passes it on below 100 Hz.
    wanted = (0.05 * 0.6) ** 2 / (f * np.sum(1 / np.arange(1.0, WAVES + 1)))
    ratio = found.spectrum.values[band] / wanted[band]
    assert np.mean(ratio) == pytest.approx(1.0, abs=0.15)
    slope = np.polyfit(np.log(f[band]), np.log(found.spectrum.values[band]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.15)
    grid = np.geomspace(5.0, 100.0, 50)
    assert np.mean(10 * np.log10(found.density(grid) * grid / np.mean(wanted * f))) == pytest.approx(0.0, abs=1.0)


def test_tremor_is_a_peak_where_it_should_be_of_the_right_size() -> None:
    found = identify_noise(TREMBLES, seeds=range(6))
    f, density = found.spectrum["frequency"].values, found.spectrum.values
    assert 8.0 <= f[np.argmax(density)] <= 12.0
    assert 8.0 <= (grid := np.geomspace(1, 100, 2000))[np.argmax(found.density(grid))] <= 12.0
    # f0 (N/N0)^n: a force of 30 mN on 0.5 N, to first order.
    band = np.geomspace(3.0, 40.0, 2000)
    rms_n = np.sqrt(np.trapezoid(found.density(band), band))
    assert rms_n == pytest.approx(0.9 * 0.6 / 0.5 * 0.03, rel=0.15)


@settings(max_examples=15)
@given(
    level=st.floats(-8, -2),
    corner=st.floats(3, 60),
    centre=st.floats(7, 14),
    width=st.floats(2, 5),
    ratio=st.floats(1, 30),
)
def test_fit_finds_a_filter_of_its_own_kind(level, corner, centre, width, ratio) -> None:
    f = np.arange(1.0, 400.0, 0.5)
    background = 10**level / (1 + (f / corner) ** 2)
    peak = ratio * 10**level * centre**2 * width**2 / ((centre**2 - f**2) ** 2 + (width * f) ** 2)
    A, B, C, D = filter_ = fit_shaping(f, background + peak)
    assert np.all(np.linalg.eigvals(A).real < 0) and np.all(np.linalg.eigvals(A - B @ C / D).real < 0)
    below = f <= 200
    error = 10 * np.log10(np.abs(filter_.at(2j * np.pi * f[below])[:, 0, 0]) ** 2 / (background + peak)[below])
    assert np.sqrt(np.mean(error**2)) < 1.5
