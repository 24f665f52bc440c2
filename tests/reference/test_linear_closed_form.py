"""Equation (2) against loops simple enough to solve by hand."""

from __future__ import annotations

import math
from typing import get_args

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

from frictionloop.analysis import Reading, kp_limit, linearise, output_noise_rms_n
from frictionloop.parameters import System, bench, feasible, paper

FAST_HZ = 1e9
"""A cutoff so high that the block is 1: what is left of it is of order 1e-6 (5 kHz / 1e9 Hz)."""
TS = 1 / 5000


def first_order(kp: float, ki: float = 0.0, periods: int = 0) -> System:
    """The 100 Hz plate alone: pole p = exp(-2 pi 100 Ts) in z."""
    changes = {"controller.kp": kp, "controller.ki": ki, "controller.delay_s": periods * TS}
    return paper().evolve(changes | {"sensor.cutoff_hz": FAST_HZ})


POLE = math.exp(-2 * math.pi * 100 * TS)


@pytest.mark.parametrize("kp", [0.0, 1.0, 10.0, 15.0])
def test_pole_of_the_first_order_loop(kp: float) -> None:
    """z = p - kp (1 - p); the other pole is the sensor's, at 0."""
    poles = linearise(first_order(kp)).poles()
    assert poles[np.argmax(np.abs(poles))] == pytest.approx(POLE - kp * (1 - POLE), abs=1e-5)


def test_limit_of_the_first_order_loop() -> None:
    """p - kp (1 - p) = -1."""
    assert kp_limit(first_order(1.0)) == pytest.approx((1 + POLE) / (1 - POLE), rel=1e-5)


def test_limit_of_the_first_order_loop_one_period_late() -> None:
    """Z^2 - p z + kp (1 - p) = 0 has two complex roots of product 1 at the limit."""
    assert kp_limit(first_order(1.0, periods=1)) == pytest.approx(1 / (1 - POLE), rel=1e-5)


@pytest.mark.parametrize("periods", [0, 1, 2, 5])
def test_limit_of_the_pure_integral_loop(periods: int) -> None:
    """G = ki Ts z^-(m+1) / (z - 1) meets -1 at the angle t = pi / (2 m + 3), where ki Ts = 2 sin(t / 2)."""
    angle = math.pi / (2 * periods + 3)
    ki = 2 * math.sin(angle / 2) / TS
    system = first_order(0.0, ki, periods).evolve({"plate.cutoff_hz": FAST_HZ})
    margins = linearise(system).margins()
    assert margins.gain_margin == pytest.approx(1.0, rel=1e-5)
    assert margins.phase_crossover_hz == pytest.approx(angle / (2 * math.pi * TS), rel=1e-5)
    for factor, stable in ((0.999, True), (1.001, False)):
        assert linearise(system.evolve({"controller.ki": factor * ki})).is_stable() is stable


def test_crossover_and_phase_margin_of_the_pure_integral_loop() -> None:
    """|G| = ki Ts / (2 sin(w Ts / 2)) = 1; arg G = -90 deg - 3/2 w Ts."""
    ki = 400.0
    margins = linearise(first_order(0.0, ki).evolve({"plate.cutoff_hz": FAST_HZ})).margins()
    angle = 2 * math.asin(ki * TS / 2)
    assert margins.crossover_hz == pytest.approx(angle / (2 * math.pi * TS), rel=1e-5)
    assert margins.phase_margin_deg == pytest.approx(90 - math.degrees(1.5 * angle), rel=1e-5)
    assert margins.delay_margin_s == pytest.approx((math.pi / 2 / angle - 1.5) * TS, rel=1e-5)


def test_noise_of_the_first_order_loop() -> None:
    """x' = p x - kp (1 - p) (x + n): variance kp^2 (1 - p)^2 / (1 - (p - kp (1 - p))^2)."""
    for kp in (1.0, 5.0, 12.0):
        gain = kp * (1 - POLE)
        expected = gain / math.sqrt(1 - (POLE - gain) ** 2)
        system = first_order(kp).evolve({"sensor.noise_rms_n": 0.01})
        assert output_noise_rms_n(system) == pytest.approx(0.01 * expected, rel=1e-5)


def test_final_values() -> None:
    """Proportional: f_a = (d + kp f_r)/(1 + kp); with integral action f_m = f_r, so f_a = f_r - n."""
    proportional = linearise(paper().evolve({"controller.ki": 0.0})).state_space().response(0.0)[0].real
    np.testing.assert_allclose(proportional[0], np.array([10, 1, -10]) / 11, atol=1e-12)
    integral = linearise(paper()).state_space().response(0.0)[0].real
    # 1 - A has the slow pole's distance ki Ts / (1 + kp) = 4e-5 to zero: 12 of 16 digits are left.
    np.testing.assert_allclose(integral[:2], [[1, 0, -1], [1, 0, 0]], atol=1e-11)


@pytest.mark.parametrize("reading", get_args(Reading))
def test_identities(reading: Reading) -> None:
    """S + T = 1, S (1 + G) = 1, and 1 - f_a_from_f_r tends to S at low frequency."""
    frequency = np.geomspace(0.01, 2500, 300)
    r = linearise(feasible()).frequency_response(frequency, reading)
    np.testing.assert_allclose(r.S + r.T, 1, atol=1e-13)
    np.testing.assert_allclose(r.S * (1 + r.G), 1, atol=1e-12)
    assert r.frequency.attrs["units"] == "Hz"
    assert all(variable.attrs["units"] == "N/N" for variable in r.values())


def test_printed_reading_is_equation_2_in_laplace() -> None:
    frequency = np.geomspace(0.1, 2500, 50)
    s = 2j * np.pi * frequency
    C, P, S = 10 + 2 / s, 1 / (1 + frequency * 1j / 100), 1 / (1 + frequency * 1j / 1000)
    G = C * P * S
    late = paper().evolve({"controller.delay_s": 150e-6})
    r = linearise(late).frequency_response(frequency, "printed")
    np.testing.assert_allclose(r.f_a_from_f_r, C * P / (1 + G), rtol=1e-12)
    np.testing.assert_allclose(r.f_a_from_d, 1 / (1 + G), rtol=1e-12)
    np.testing.assert_allclose(r.f_a_from_n, -G / (1 + G), rtol=1e-12)
    lag = linearise(late).frequency_response(frequency, "lag")
    np.testing.assert_allclose(lag.G, G * np.exp(-s * 250e-6), rtol=1e-12)
    held = linearise(late).frequency_response(frequency, "held")
    sinc = np.sinc(frequency * TS) * np.exp(-s * TS / 2)
    np.testing.assert_allclose(held.G, G * np.exp(-s * 150e-6) * sinc, rtol=1e-12)


def test_readings_meet_at_low_frequency() -> None:
    """Sampling at rate R changes G by aliases of order f/R: at 1/1000 of the rate all readings agree to 1 %."""
    G = {reading: linearise(paper()).responses([5.0], reading)["G"][0] for reading in get_args(Reading)}
    for reading, value in G.items():
        assert value == pytest.approx(G["sampled"], rel=0.01), reading


def test_sampled_loop_tends_to_the_continuous_one() -> None:
    """Ten times the rate brings the sampled G ten times nearer to the printed one (hold: half a period of lag)."""
    frequency = np.geomspace(1, 1000, 20)
    apart = []
    for rate in (2e4, 2e5, 2e6):
        loop = linearise(paper().evolve({"controller.rate_hz": rate}))
        sampled, printed = (loop.responses(frequency, r)["G"] for r in ("sampled", "printed"))
        apart.append(np.max(np.abs(sampled / printed - 1)))
    assert apart[0] / apart[1] == pytest.approx(10, rel=0.1)
    assert apart[1] / apart[2] == pytest.approx(10, rel=0.1)


@pytest.mark.parametrize("delay_s", [0.0, 0.3e-4, 1e-4, 2e-4, 3e-4])
def test_limit_near_the_one_of_the_half_period_rule(delay_s: float) -> None:
    """In continuous time |G| = 1 at -180 degrees with a lag of delay + Ts/2.

    Aliases make the two differ: PS(z) sums P S over f + m / Ts, and the nearest alias of the two-pole loop is
    (f / (1/Ts - f))^2 of it at the crossover f. Twice that bounds the difference.
    """
    system = paper().evolve({"controller.delay_s": delay_s})
    frequency = np.linspace(100, 2500, 100_000)
    PS = 1 / ((1 + 1j * frequency / 100) * (1 + 1j * frequency / 1000))
    q = -1 / (PS * np.exp(-2j * np.pi * frequency * (delay_s + TS / 2))) - 2 / (2j * np.pi * frequency)
    k = int(np.argmax(q.imag[1:] * q.imag[:-1] < 0))
    alias = (frequency[k] / (1 / TS - frequency[k])) ** 2
    assert kp_limit(system) == pytest.approx(q[k].real, rel=2 * alias)


gains = {"kp": st.floats(0.1, 30), "ki": st.floats(0.1, 2000), "delay_s": st.floats(0, 1e-3)}


@pytest.mark.slow
@settings(max_examples=60, deadline=None)
@given(**gains)
def test_stability_changes_at_the_limit(kp: float, ki: float, delay_s: float) -> None:
    system = paper().evolve({"controller.kp": kp, "controller.ki": ki, "controller.delay_s": delay_s})
    limit = kp_limit(system)
    grid = np.linspace(0, 40, 81)
    loop = linearise(system)
    stable = [loop.with_gains(k, ki).is_stable() for k in grid.tolist()]
    if math.isnan(limit):
        assert not any(stable)
        return
    assert linearise(system.evolve({"controller.kp": limit * (1 - 1e-6)})).is_stable()
    assert not linearise(system.evolve({"controller.kp": limit * (1 + 1e-6)})).is_stable()
    assert not any(s for k, s in zip(grid, stable, strict=True) if k > limit)


@settings(max_examples=60, deadline=None)
@given(**gains)
def test_margins_lead_to_the_edge_of_stability(kp: float, ki: float, delay_s: float) -> None:
    system = paper().evolve({"controller.kp": kp, "controller.ki": ki, "controller.delay_s": delay_s})
    loop = linearise(system)
    m = loop.margins()
    assert m.stable == loop.is_stable()
    edge = {"controller.kp": m.gain_margin * kp, "controller.ki": m.gain_margin * ki}
    # At the edge two poles lie on the unit circle; kp and ki are known to 1e-12.
    assert np.min(np.abs(np.abs(linearise(system.evolve(edge)).poles()) - 1)) < 1e-8
    at_180 = loop.responses([m.phase_crossover_hz])["G"][0]
    assert at_180 == pytest.approx(-1 / m.gain_margin, rel=1e-8)
    assert abs(loop.responses([m.crossover_hz])["G"][0]) == pytest.approx(1, rel=1e-9)
    everywhere = np.abs(loop.responses(np.linspace(0.5, 2500, 5000))["S"])
    assert np.max(everywhere) <= m.sensitivity_peak * (1 + 1e-9)


@pytest.mark.parametrize("delay_s", [0.0, 3e-5, 2e-4])
def test_delay_margin_is_the_delay_that_destabilises(delay_s: float) -> None:
    """Added delay turns G(z) by nearly exp(-s tau); what is left is the inter-sample shape of the held command."""
    system = paper().evolve({"controller.kp": 3.0, "controller.delay_s": delay_s})
    margin = linearise(system).margins().delay_margin_s
    for factor, stable in ((0.95, True), (1.05, False)):
        later = system.evolve({"controller.delay_s": delay_s + factor * margin})
        assert linearise(later).is_stable() is stable


def test_delay_margin_is_the_least_of_all_crossings() -> None:
    """The sensor's resonance crosses 1 twice more, and less delay turns the last crossing to -1 than the first."""
    integral = {"controller.kp": 0.0, "controller.ki": 160.0, "finger.slip_length_um": 0.0}
    system = bench().evolve(integral)
    loop = linearise(system)
    first_hz = brentq(lambda f: abs(loop.responses([f])["G"][0]) - 1, 10, 100)
    first_s = np.angle(-loop.responses([first_hz])["G"][0]) / (2 * np.pi * first_hz)
    margin_s = loop.margins().delay_margin_s
    assert margin_s < 0.6 * first_s
    for factor, stable in ((0.95, True), (1.05, False)):
        later = system.evolve({"controller.delay_s": system.controller.delay_s + factor * margin_s})
        assert linearise(later).is_stable() is stable
