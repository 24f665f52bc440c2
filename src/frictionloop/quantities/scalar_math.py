"""Compiled scalar arithmetic: the same bits in a scalar loop and in a vector loop, unlike libm's.

``exp2``, ``log2`` and the circular functions are branch-free polynomials, so LLVM vectorises a loop over lanes that
calls them. Fused multiply-adds are written out (``fma``) and never left to the compiler: a result then does not
depend on whether a loop was vectorised, which is what makes a run in a grid equal to the same run alone.
Coefficients: Chebyshev interpolation at 40 digits (mpmath.chebyfit). Errors stay below 4 ulp for ``exp2``, 5 for
``log2`` (near 1; 1 elsewhere) and 2 for the circular functions (tests/unit).
"""

from __future__ import annotations

from types import FunctionType
from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from numba.extending import intrinsic

from frictionloop.quantities.units import FrictionloopError

_OPTIONS = {"error_model": "numpy", "forceinline": True, "no_cfunc_wrapper": True}


class _Step(CPUDispatcher):
    """A compiled function that compiled code calls without what a call from Python needs.

    Numba's wrappers of arguments take a fifth of a first run's compilation, and Python calls few steps.
    """

    def __init__(self, function: Any, *settings: Any, **options: Any) -> None:
        super().__init__(function, *settings, **options)
        self._within = njit(**_OPTIONS, no_cpython_wrapper=True)(function)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        """Return what a call from compiled code with arguments of these types is, compiled."""
        return self._within.get_call_template(args, kws)

    def get_overload(self, sig: Any) -> Any:
        """Return the function that such a call calls."""
        return self._within.get_overload(sig)


def step(function: Any) -> Any:
    """Compile a scalar step, a function of numbers and named tuples of numbers; a decorator.

    Division by zero gives inf as in NumPy, which keeps loops branch-free.

    Parameters
    ----------
    function
        What to compile, at its first call (Numba: numbers, tuples, `math`, and other steps).

    Raises
    ------
    FrictionloopError
        For what is no Python function.
    """
    if not isinstance(function, FunctionType):
        raise FrictionloopError(f"step: {function!r} is no Python function")
    return _Step(function, targetoptions={**_OPTIONS, "nopython": True})


def is_compiled(function: Any) -> bool:
    """Tell whether a function is compiled, as by `step`."""
    return isinstance(function, Dispatcher)


@intrinsic
def fma(_context: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a*b + c, rounded once."""
    signature = types.float64(types.float64, types.float64, types.float64)
    return signature, lambda _ctx, builder, _sig, args: builder.fma(*args)


@intrinsic
def bits(_context: Any, x: Any) -> Any:
    """Return the 64 bits of a double as an integer."""
    return types.int64(types.float64), lambda _ctx, builder, _sig, args: builder.bitcast(args[0], ir.IntType(64))


@intrinsic
def double(_context: Any, x: Any) -> Any:
    """Return the double that has these 64 bits."""
    return types.float64(types.int64), lambda _ctx, builder, _sig, args: builder.bitcast(args[0], ir.DoubleType())


ROUND = 6755399441055744.0  # 1.5 * 2**52: adding it leaves the nearest integer in the low bits
BIASED = ROUND + 1023.0  # the low bits then are those of the exponent of a double
SQRT_HALF = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)


@step
def exp2(x: float, factor: float = 1.0) -> float:
    """Return 2^(x factor) for |x factor| < 1022; the product is not rounded before it is used."""
    shifted = fma(x, factor, BIASED)
    r = fma(x, factor, BIASED - shifted)  # exact but for one rounding, |r| <= 1/2
    r2 = r * r
    p0 = fma(fma(0.05550410866444772, r, 0.24022650695910097), r2, fma(0.69314718055995, r, 1.0))
    p1 = fma(
        fma(1.5252657260200837e-05, r, 0.0001540353044173605), r2, fma(0.0013333558230164974, r, 0.009618129107606888)
    )
    p2 = fma(7.072585949269223e-09, r2, fma(1.0208690299958306e-07, r, 1.321544258792169e-06))
    r4 = r2 * r2
    # The integer part of the product becomes the exponent of a factor, which is ready before the polynomial.
    return fma(fma(p2, r4, p1), r4, p0) * double(bits(shifted) << 52)


@step
def log2(x: float) -> float:
    """Return the binary logarithm of a normal x > 0."""
    exponent = (bits(x) - SQRT_HALF) >> 52
    f = double(bits(x) - (exponent << 52)) - 1.0
    s = f / (2.0 + f)  # log2(1 + f) = 2 atanh(s) / ln 2, |s| < 0.172
    z = s * s
    z2 = z * z
    p0 = fma(0.9617966939243345, z, 2.885390081777927)
    p1 = fma(0.4121984020482752, z, 0.5770780172463286)
    p2 = fma(fma(0.2429160853987535, z, 0.2614442493522915), z, 0.32061638813224547)
    return fma(s, fma(fma(p2, z2, p1), z2, p0), float(exponent))


@step
def sin_turns(x: float) -> float:
    """Return sin(2 pi x) for |x| < 2**50."""
    # Nearest half turn: sin(2 pi x) = (-1)^n sin(2 pi y), |y| <= 1/4.
    shifted = fma(x, 2.0, ROUND)
    y = fma(shifted - ROUND, -0.5, x)
    z = y * y
    p = fma(0.10089695501646812, z, -0.7177337921413454)
    p = fma(p, z, 3.8199280942271643)
    p = fma(p, z, -15.0946416761179)
    p = fma(p, z, 42.058693925428685)
    p = fma(p, z, -76.70585975282492)
    p = fma(p, z, 81.60524927607362)
    p = fma(p, z, -41.341702240399755)
    p = fma(p, z, 6.283185307179586)
    return double(bits(p * y) ^ (bits(shifted) << 63))


@step
def cos_turns(x: float) -> float:
    """Return cos(2 pi x) for |x| < 2**50."""
    return sin_turns(x + 0.25)


@step
def biquad_step(
    s1: float, s2: float, x: float, b0: float, b1: float, b2: float, a1: float, a2: float
) -> tuple[float, float, float]:
    """y = b0 x + s1, then s1 = b1 x - a1 y + s2 and s2 = b2 x - a2 y: one section, transposed direct form II.

    Returns the new s1 and s2, and y. The coefficients are a row of a `scipy.signal` filter
    in sections (sos) without its a0 = 1.
    """
    y = fma(b0, x, s1)
    return fma(b1, x, fma(-a1, y, s2)), fma(b2, x, -a2 * y), y
