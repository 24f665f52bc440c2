"""The compiled polynomials against exact decimal arithmetic of the standard library."""

from __future__ import annotations

import math
import struct
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from numba import njit

from frictionloop.quantities import scalar_math

DIGITS = 50  # of the reference; an ulp of 1 is 2e-16
LIMITS = {"exp2": 4, "log2": 5, "sin": 2}  # ulp, what the module promises


def over_arrays(function):
    """Compile a loop over an array: the form in which the compiler vectorises the step."""

    @njit(error_model="numpy")
    def loop(x, out):
        for i in range(x.size):
            out[i] = function(x[i])

    def call(x):
        values = np.ascontiguousarray(np.atleast_1d(x), dtype=np.float64)
        out = np.empty_like(values)
        loop(values, out)
        return out

    return call


EXP2, LOG2 = over_arrays(scalar_math.exp2), over_arrays(scalar_math.log2)
SIN, COS = over_arrays(scalar_math.sin_turns), over_arrays(scalar_math.cos_turns)


@njit(error_model="numpy")
def scalar_exp2(x):
    return scalar_math.exp2(x)


@njit(error_model="numpy")
def scaled_exp2(x, factor):
    return scalar_math.exp2(x, factor)


@njit(error_model="numpy")
def scalar_log2(x):
    return scalar_math.log2(x)


@njit(error_model="numpy")
def scalar_sin_turns(x):
    return scalar_math.sin_turns(x)


@njit(error_model="numpy")
def multiply_add(a, b, c):
    return scalar_math.fma(a, b, c)


@njit
def there_and_back(x):
    return scalar_math.bits(x), scalar_math.double(scalar_math.bits(x))


def ulps(got, exact):
    """Return the distance of a double from an exact Decimal, in units of the double's last place."""
    return abs(Decimal(float(got)) - exact) / Decimal(math.ulp(float(exact)))


def exact_exp2(x, factor=1.0):
    return (Decimal(float(x)) * Decimal(factor) * Decimal(2).ln()).exp()


def exact_log2(x):
    return Decimal(float(x)).ln() / Decimal(2).ln()


def exact_sin_turns(x):
    """Return sin(2 pi x) by its Taylor series, after taking off half turns exactly."""
    halves = (2 * Decimal(float(x))).to_integral_value()
    angle = 2 * PI * (Decimal(float(x)) - halves / 2) * (-1 if halves % 2 else 1)
    term, total, k = angle, angle, 1
    while term and abs(term) > Decimal(10) ** (-DIGITS - 5):
        term *= -angle * angle / ((k + 1) * (k + 2))
        total += term
        k += 2
    return total


def machin():
    """Return pi = 16 atan(1/5) - 4 atan(1/239)."""

    def atan_inverse(n):
        return sum((-1) ** k / (Decimal(2 * k + 1) * Decimal(n) ** (2 * k + 1)) for k in range(60))

    return 16 * atan_inverse(5) - 4 * atan_inverse(239)


with localcontext(prec=DIGITS + 10):
    PI = machin()


def test_the_reference_itself():
    with localcontext(prec=DIGITS):
        assert str(PI).startswith("3.14159265358979323846264338327950288419716939937510")
        almost_none = Decimal(10) ** (5 - DIGITS)
        for x in (0.25, 0.125, 1.875, -0.75, 1234.625):
            square = exact_sin_turns(x) ** 2 + exact_sin_turns(x + 0.25) ** 2
            assert abs(square - 1) < almost_none
            assert abs(exact_sin_turns(x) - Decimal(math.sin(2 * math.pi * (x % 1)))) < Decimal("1e-15")
        assert exact_log2(1024.0) == 10
        assert ulps(math.sqrt(2), exact_exp2(0.5)) <= Decimal("0.5")


def worst(function, exact, values):
    with localcontext(prec=DIGITS):
        return max(ulps(got, exact(x)) for x, got in zip(values, function(values), strict=True))


# Dense where the polynomials change piece, and over the whole range that is promised.
GRIDS = {
    "exp2 near 0": (EXP2, exact_exp2, np.linspace(-2.0, 2.0, 4001)),
    "exp2 wide": (EXP2, exact_exp2, np.linspace(-1021.9, 1021.9, 4001)),
    "exp2 tiny": (EXP2, exact_exp2, np.concatenate([-np.geomspace(1e-300, 1, 300), np.geomspace(1e-300, 1, 300)])),
    "log2 near 1": (LOG2, exact_log2, np.linspace(0.5, 2.0, 4001)),
    "log2 at 1": (
        LOG2,
        exact_log2,
        1.0 + np.concatenate([-np.geomspace(1e-16, 0.1, 500), np.geomspace(3e-16, 1, 500)]),
    ),
    "log2 wide": (LOG2, exact_log2, np.geomspace(1e-307, 1e308, 4001)),
    "sin one turn": (SIN, exact_sin_turns, np.linspace(-1.0, 1.0, 4003)[1:-1]),
    "sin tiny": (SIN, exact_sin_turns, np.geomspace(1e-300, 0.25, 1000)),
    "sin many turns": (SIN, exact_sin_turns, np.linspace(-1e6, 1e6, 3000) + 0.123),
}


@pytest.mark.parametrize("name", GRIDS)
def test_within_the_promised_ulp_on_a_grid(name):
    assert worst(*GRIDS[name]) <= LIMITS[name.split()[0]]


def single(scalar, exact, x):
    with localcontext(prec=DIGITS):
        return ulps(scalar(x), exact(x))


@given(st.floats(-1021.9, 1021.9))
@example(0.5)
@example(-0.5)
def test_exp2_anywhere(x):
    assert single(scalar_exp2, exact_exp2, x) <= LIMITS["exp2"]


@given(st.floats(0.01, 100), st.floats(-1021.9, 1021.9))
def test_exp2_of_a_product(factor, product):
    """The product is not rounded before it is used: at 1000 that alone would cost 2^-44 ln 2 = 180 ulp."""
    x = product / factor
    with localcontext(prec=DIGITS):
        assert ulps(scaled_exp2(x, factor), exact_exp2(x, factor)) <= LIMITS["exp2"]


@given(st.floats(2.3e-308, 1.7e308))
@example(1.0)
@example(math.nextafter(1.0, 0.0))
@example(math.sqrt(0.5))
@example(math.nextafter(math.sqrt(0.5), 0.0))
def test_log2_anywhere(x):
    assert single(scalar_log2, exact_log2, x) <= LIMITS["log2"]


@given(st.floats(-(2.0**50), 2.0**50))
def test_sin_turns_anywhere(x):
    assert single(scalar_sin_turns, exact_sin_turns, x) <= LIMITS["sin"]


def test_exp2_is_exact_at_whole_numbers():
    n = np.arange(-1021, 1022)
    np.testing.assert_array_equal(EXP2(n), 2.0 ** n.astype(float))


def test_log2_is_exact_at_powers_of_two():
    n = np.arange(-1022, 1024)
    np.testing.assert_array_equal(LOG2(2.0 ** n.astype(float)), n)


def test_exact_quarter_turns():
    turns = np.arange(-8, 9) / 4
    np.testing.assert_array_equal(SIN(turns), np.round(np.sin(2 * np.pi * turns)))
    np.testing.assert_array_equal(COS(turns), np.round(np.cos(2 * np.pi * turns)))


@given(st.floats(-1e6, 1e6))
def test_sine_is_odd(x):
    assert scalar_sin_turns(-x) == -scalar_sin_turns(x)


def test_cosine_over_one_turn():
    # x + 0.25 is rounded by up to 2^-54 for x in [0, 1): 2 pi 2^-54 = 3.5e-16, and 2 ulp of 1 are 4.4e-16.
    x = np.linspace(0.0, 1.0, 5001)[:-1]
    np.testing.assert_allclose(COS(x), np.cos(2 * np.pi * x), rtol=0, atol=8e-16 + 2 * np.pi * 2.0**-53)


@pytest.mark.parametrize(
    ("loop", "scalar", "low", "high"),
    [(EXP2, scalar_exp2, -50, 50), (LOG2, scalar_log2, 1e-9, 1e9), (SIN, scalar_sin_turns, -9, 9)],
)
def test_a_vectorised_loop_gives_the_scalars_bits(loop, scalar, low, high):
    for size in (1, 3, 8, 32, 1001):  # vector bodies and their remainders
        x = np.random.default_rng(size).uniform(low, high, size)
        np.testing.assert_array_equal(loop(x), [scalar(v) for v in x])


finite = st.floats(-1e100, 1e100)


@given(finite, finite, finite)
@example(1.0 + 2.0**-30, 1.0 - 2.0**-30, -1.0)  # rounding the product first would give 0
def test_multiply_add_rounds_once(a, b, c):
    assert multiply_add(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))


@given(st.floats(allow_nan=False))
def test_bits_and_back(x):
    code, back = there_and_back(x)
    assert struct.pack("<q", code) == struct.pack("<d", x)
    assert back == x
