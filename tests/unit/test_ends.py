"""Friction over a stretch of constant command, from value and derivatives at the two ends of the stretch."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad

from frictionloop.loop.kernel.endpoint_quadrature import end_step, end_terms, end_weights, segment_ends
from frictionloop.loop.kernel.quadrature import PLATE_PER_SEGMENT

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
