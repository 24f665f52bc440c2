"""The modifiers of the friction limit: each against its equation, together never negative, and 0 when lifted."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numba import njit
from scipy.integrate import quad, solve_ivp

import frictionloop as fl
from frictionloop.analysis.linear import operating_band
from frictionloop.analysis.operating_point import missed, occlusions
from frictionloop.design import controller_synthesis
from frictionloop.design.controller_findings import out_of_reach
from frictionloop.design.grid_corners import corners
from frictionloop.design.requirements import Requirements, feedforward
from frictionloop.loop.kernel.endpoint_quadrature import end_step, end_terms, end_weights, segment_ends
from frictionloop.loop.kernel.period_quadrature import PLATE_PER_SEGMENT
from frictionloop.parameters import Friction
from frictionloop.parameters.plant import FingerFriction, FrictionLaw
from frictionloop.physics.friction import friction_force, halving_amplitude_um
from frictionloop.physics.limit_scaling import limit_coefficients, limit_step, occlusion_coefficients, occlusion_step
from frictionloop.physics.vibration import vibrated_step

DT = 2e-4
EPS = 2.0**-52
frictions = st.builds(
    FingerFriction,
    load_exponent=st.floats(0, 2),
    speed_slope=st.floats(-0.15, 0.15),
    reference_load_n=st.floats(0.1, 2),
    reference_speed_mm_s=st.floats(1, 200),
    slow_mm_s=st.floats(0.01, 10),
    occlusion_ratio=st.floats(0.1, 10),
    moist_loss=st.floats(0, 0.9),
)
loads, speeds, shares = st.floats(1e-6, 20), st.floats(-1, 1), st.floats(0, 1)


@njit
def limits(load, speed, occluded, roughness, coefficients):
    out = np.empty(load.size)
    for i in range(load.size):
        out[i] = limit_step(load[i], speed[i], occluded[i], roughness[i], coefficients)
    return out


@given(frictions, loads, speeds, shares, st.floats(-0.9, 2))
def test_the_factor_is_the_product_of_its_parts(friction, load, speed, occluded, roughness):
    slow, reference = 1e-3 * friction.slow_mm_s, 1e-3 * friction.reference_speed_mm_s
    exact = (
        (load / friction.reference_load_n) ** friction.load_exponent
        * (math.hypot(speed, slow) / math.hypot(reference, slow)) ** friction.speed_slope
        * (1 + (friction.occlusion_ratio - 1) * occluded)
        * (1 + roughness)
    )
    got = limit_step(load, speed, occluded, roughness, limit_coefficients(friction))
    # Exponents of up to 60 octaves are rounded a few times; so is 1 + roughness, at 0.1 and above.
    assert got == pytest.approx(exact, rel=200 * EPS)


def test_it_is_one_at_the_reference():
    friction = FingerFriction(speed_slope=0.1)
    assert limit_step(0.5, 0.02, 0.0, 0.0, limit_coefficients(friction)) == pytest.approx(1.0, rel=4 * EPS)
    assert limit_step(0.5, -0.02, 0.0, 0.0, limit_coefficients(friction)) == pytest.approx(1.0, rel=4 * EPS)


@given(frictions, st.floats(-100, 100), speeds, shares, st.floats(-10, 10))
def test_it_is_never_negative_and_zero_without_load(friction, load, speed, occluded, roughness):
    got = limit_step(load, speed, occluded, roughness, limit_coefficients(friction))
    assert 0 <= got < math.inf
    if load <= 0 or roughness <= -1:
        assert got == 0.0


@given(frictions, shares)
def test_slow_sliding_has_a_limit(friction, occluded):
    coefficients = limit_coefficients(friction)
    still = limit_step(0.5, 0.0, occluded, 0.0, coefficients)
    assert 0 < still < math.inf
    slow = 1e-3 * friction.slow_mm_s
    # (1 + 1e-6)^(p/2) - 1 at a thousandth of the slow speed.
    assert limit_step(0.5, 1e-3 * slow, occluded, 0.0, coefficients) == pytest.approx(still, rel=1e-7)


def test_the_slope_far_from_slow():
    friction = FingerFriction(speed_slope=-0.12, slow_mm_s=0.1)
    coefficients = limit_coefficients(friction)
    ratio = limit_step(0.5, 0.1, 0.0, 0.0, coefficients) / limit_step(0.5, 0.05, 0.0, 0.0, coefficients)
    # vs^2 changes the logarithmic slope by its share in v^2, 4e-6 at 50 mm/s.
    assert math.log2(ratio) == pytest.approx(-0.12, rel=1e-5)


@given(st.floats(1, 100), st.floats(1, 100))
def test_occlusion_follows_its_equation(occlusion_s, drying_s):
    coefficients = occlusion_coefficients(FingerFriction(occlusion_s=occlusion_s, drying_s=drying_s), 0.1)
    w, load = 0.0, [1.0] * 50 + [0.0] * 30 + [0.2] * 20
    for each in load:
        w = occlusion_step(w, each, coefficients)
    exact = 0.0
    for seconds, target, t in ((5, 1, occlusion_s), (3, 0, drying_s), (2, 1, occlusion_s)):
        exact = target + (exact - target) * math.exp(-seconds / t)
    assert w == pytest.approx(exact, abs=100 * 4 * EPS)


def test_occlusion_against_an_integrator():
    friction = FingerFriction(occlusion_s=2.0, drying_s=5.0)
    coefficients, w = occlusion_coefficients(friction, DT), 0.0
    for k in range(10_000):
        w = occlusion_step(w, float(k < 6000), coefficients)
    rise = solve_ivp(lambda _, y: (1 - y) / 2.0, (0, 1.2), [0.0], rtol=1e-11, atol=1e-13).y[0, -1]
    fall = solve_ivp(lambda _, y: -y / 5.0, (0, 0.8), [rise], rtol=1e-11, atol=1e-13).y[0, -1]
    assert w == pytest.approx(fall, rel=1e-9)


def test_a_lifted_finger_neither_slides_nor_occludes():
    friction = FingerFriction()
    assert occlusion_step(0.0, 0.0, occlusion_coefficients(friction, DT)) == 0.0
    assert occlusion_step(0.5, 0.0, occlusion_coefficients(friction, DT)) < 0.5
    assert limit_step(0.0, 0.02, 0.5, 0.0, limit_coefficients(friction)) == 0.0


@given(st.floats(0, 2.5), shares, st.floats(0, 0.9), st.floats(0.05, 2))
def test_moisture_lowers_the_susceptibility(a, occluded, loss, tau):
    moist = Friction(nominal_n=1.0, susceptibility_per_um2=tau * (1 - loss * occluded))
    y = a / float(halving_amplitude_um(tau))
    exact = float(friction_force(a, moist))
    assert vibrated_step(y, occluded, loss) == pytest.approx(exact, rel=8 * EPS * (1 + tau * a * a))


@given(frictions, st.lists(st.tuples(loads, speeds, shares, st.floats(-1, 1)), min_size=32, max_size=32))
def test_lanes_have_the_bits_of_a_single_step(friction, lanes):
    coefficients = limit_coefficients(friction)
    together = limits(*np.array(lanes).T.copy(), coefficients)
    assert list(together) == [limit_step(*lane, coefficients) for lane in lanes]


def test_a_finger_has_the_friction_law_of_the_paper_within_it():
    assert isinstance(FingerFriction(), FrictionLaw)
    assert float(friction_force(0.0, FingerFriction(nominal_n=0.7))) == 0.7


BENCH = {
    "plate.max_amplitude_um": 2.0,
    "controller.model.max_amplitude_um": 2.0,
    "friction.nominal_n": 1.1,
    "sensor.resonance_hz": 170.0,
    "setpoint": fl.Sine(offset_n=0.5, amplitude_n=0.3),
}


def bench(amplitude_n: float) -> fl.System:
    return fl.bench().evolve(BENCH).evolve({"setpoint.amplitude_n": amplitude_n})


@pytest.mark.slow
def test_a_force_that_no_amplitude_leaves_counts_as_the_nearest_that_it_does():
    found = controller_synthesis.synthesised(bench(0.3), "pi", Requirements())[0].corners
    dry = [each.loop.elements.force_n for each in found if each.loop.elements.occluded == 0.0]
    (beyond,) = missed(bench(0.3))
    assert (beyond.force_n, beyond.instead_n) == (pytest.approx(0.2), pytest.approx(min(dry)))


def test_where_none_can_be_had_the_design_is_refused_before_any_search(monkeypatch):
    monkeypatch.setitem(controller_synthesis.SYNTHESES, "notch_pi", lambda *_: pytest.fail("it searched"))
    weak = bench(0.02).evolve({"setpoint.offset_n": 0.2})
    with pytest.raises(fl.FrictionloopError, match="in reach") as refused:
        controller_synthesis.synthesised(weak, "notch_pi", Requirements())
    more_um, less_n = (
        float(each) for each in re.search(r"takes (\S+) um, .* below (\S+) N", str(refused.value)).groups()
    )
    for change in ({"plate.max_amplitude_um": 1.001 * more_um, "controller.model.max_amplitude_um": 1.001 * more_um},
                   {"friction.nominal_n": 0.995 * less_n}):  # fmt: skip
        assert missed(weak.evolve(change | {"setpoint.offset_n": 0.22, "setpoint.amplitude_n": 0.0})) == []


def test_the_force_evaluated_in_place_of_another_is_that_of_the_loops():
    system = bench(0.2)
    states = occlusions(system)
    (beyond,) = missed(system, states)
    evaluated = [loop.elements for loop in operating_band(system, occluded=states)]
    assert min(each.force_n for each in evaluated if each.occluded > 0) == pytest.approx(beyond.instead_n, rel=1e-12)


def test_a_force_out_of_reach_is_told_with_the_nearest_where_that_is_worst():
    """Over speeds the least force is that of the speed with most friction."""
    tilt = bench(0.2).evolve({"friction.speed_slope": -0.15, "controller.kind": "pi", "controller.ki": 5.0})
    over = Requirements(speeds_mm_s=(10.0, 60.0), slip_lengths_um=(11.5,)).grid(2, 1)
    state = occlusions(tilt)[-1]
    least_n = [missed(each, [state])[0].instead_n for each in over.systems(tilt)]
    (told,) = out_of_reach(corners(tilt, over))
    assert (told.code, told.value, told.where.occluded) == ("FORCE-REACH", pytest.approx(0.3), state)
    assert told.limit == pytest.approx(max(least_n)) and min(least_n) < max(least_n)
    fine = tilt.evolve({"setpoint.offset_n": 0.75, "setpoint.amplitude_n": 0.05})
    assert list(out_of_reach(corners(fine, over))) == []


def test_no_feed_forward_where_the_set_point_reaches_the_believed_friction():
    bench = fl.bench()
    assert feedforward(bench) == (True, ())
    forward, (why,) = feedforward(bench.evolve({"setpoint.offset_n": 0.9}))
    assert not forward and (why.code, why.value) == ("FORWARD-CLIPPED", 1.0)
    assert feedforward(bench.evolve({"setpoint.offset_n": 0.9, "controller.model.nominal_n": 1.3}))[0]


THETAS = [1e-9, 1e-3, 0.3, 1.2566, 12.566, 125.66, 1e4]


def moment(theta, degree):
    """Return int_0^1 theta e^(-theta x') (1 - x')^degree dx' by adaptive quadrature."""
    reach = min(1.0, 50.0 / theta)  # e^-50 = 2e-22 beyond
    return quad(lambda x: theta * math.exp(-theta * x) * (1 - x) ** degree, 0.0, reach, epsabs=1e-15, epsrel=1e-13)[0]


@pytest.mark.parametrize("theta", THETAS)
def test_the_weights_are_exact_for_polynomials_up_to_degree_7(theta):
    start, end = end_weights(theta)
    for degree in range(8):
        falling = [math.perm(degree, j) for j in range(4)]  # derivatives of x^degree at 1
        at_0 = [math.factorial(degree) if j == degree else 0.0 for j in range(4)]
        assert start @ at_0 + end @ falling == pytest.approx(moment(theta, degree), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("theta", [0.3, 1.2566, 12.566])
def test_no_further_than_degree_7(theta):
    _, end = end_weights(theta)
    assert abs(end @ [math.perm(8, j) for j in range(4)] - moment(theta, 8)) > 1e-6


@given(st.floats(0.0, 4.0), st.floats(0.0, 4.0), st.sampled_from(THETAS), st.floats(1e-3, 1.0))
def test_the_terms_are_the_derivatives_of_friction(y, command, theta, turned):
    """Closed form: with D = d/dx, y' = -l z and z' = -l z, from the Leibniz rule applied to g' = -2 ln 2 y y' g."""
    z = y - command
    u = [y * z, None, None]  # y z and its derivatives
    u[1] = -turned * (z * z + y * z)
    u[2] = turned**2 * (2 * z * z + z * z + y * z)
    k = 2 * math.log(2) * turned
    g = [1.0]
    for n in range(3):
        g.append(k * sum(math.comb(n, j) * u[j] * g[n - j] for j in range(n + 1)))
    for end, terms in zip(end_weights(theta), end_terms(theta, turned), strict=True):
        scale = np.abs(end) @ (1.0 + np.abs(g)) + np.abs(terms).sum() * (1 + abs(y * z) + z * z) ** 3
        assert end_step(y, z, *terms) == pytest.approx(end @ g, abs=1e-13 * scale)


@pytest.mark.parametrize("sensor_hz", [1.0, 1e3, 3e3, 1e4, 1e5])
@pytest.mark.parametrize(("plate", "bound_n"), [(0.02, 3e-10), (PLATE_PER_SEGMENT, 2e-8)])
def test_the_reading_of_a_full_swing(sensor_hz, plate, bound_n):
    """Against Gauss-Legendre with many points, for all swings within the paper's 2.5 um; friction of 1 N."""
    length, ceiling = 2e-4, 2.5 * math.sqrt(0.38 / math.log(2))
    decay, terms = segment_ends(plate / length, sensor_hz, 0.0, length, 0, 1)
    start, end = terms[0]
    theta = 2 * math.pi * sensor_hz * length
    x, w = np.polynomial.legendre.leggauss(200)
    reach = min(1.0, 40.0 / theta)
    back = (x + 1) / 2 * reach
    kernel = w / 2 * reach * theta * np.exp(-theta * back)
    for y in np.linspace(0, ceiling, 9):
        for command in np.linspace(0, ceiling, 9):
            z = y - command
            exact = kernel @ 2 ** -((command + z * np.exp(-2 * math.pi * plate * (1 - back))) ** 2)
            last = z * decay[0]
            found = end_step(y, z, *start) * 2 ** -(y**2)
            found += end_step(command + last, last, *end) * 2 ** -((command + last) ** 2)
            assert found == pytest.approx(exact, abs=bound_n)
