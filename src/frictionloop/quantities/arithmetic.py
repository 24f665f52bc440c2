"""Compiled scalar arithmetic: the same bits in a scalar loop and in a vector loop, unlike libm's.

``exp``, ``log`` and the circular functions are branch-free polynomials, so LLVM vectorises a loop over lanes that
calls them. Fused multiply-adds are written out (``fma``) and never left to the compiler: a result then does not
depend on whether a loop was vectorised, which is what makes a run in a grid equal to the same run alone.
Coefficients: Chebyshev interpolation at 40 digits (mpmath.chebyfit); errors below 2 ulp (tests/unit).
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

step = njit(error_model="numpy", forceinline=True)
"""Compile a scalar step function; division by zero gives inf as in NumPy, which keeps loops branch-free."""


@intrinsic  # type: ignore[untyped-decorator]
def fma(_context: Any, a: Any, b: Any, c: Any) -> Any:
    """Return a*b + c, rounded once."""
    signature = types.float64(types.float64, types.float64, types.float64)
    return signature, lambda _ctx, builder, _sig, args: builder.fma(*args)


@intrinsic  # type: ignore[untyped-decorator]
def bits(_context: Any, x: Any) -> Any:
    """Return the 64 bits of a double as an integer."""
    return types.int64(types.float64), lambda _ctx, builder, _sig, args: builder.bitcast(args[0], ir.IntType(64))


@intrinsic  # type: ignore[untyped-decorator]
def double(_context: Any, x: Any) -> Any:
    """Return the double that has these 64 bits."""
    return types.float64(types.int64), lambda _ctx, builder, _sig, args: builder.bitcast(args[0], ir.DoubleType())


LOG2_E = 1.4426950408889634
LN2_HIGH = 6.93147180369123816490e-01  # ln 2 split so that n * LN2_HIGH is exact (fdlibm)
LN2_LOW = 1.90821492927058770002e-10
ROUND = 6755399441055744.0  # 1.5 * 2**52: adding it leaves the nearest integer in the low bits
ONE = 0x3FF0000000000000  # bits of 1.0
SQRT_HALF = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)


@step
def exp(x: float) -> float:
    """Return e^x for x < 709; below -700 the result is e^-700 = 1e-304."""
    x = max(x, -700.0)
    shifted = fma(x, LOG2_E, ROUND)
    n = shifted - ROUND
    r = fma(n, -LN2_LOW, fma(n, -LN2_HIGH, x))
    r2 = r * r
    p0 = fma(fma(0.1666666666666668, r, 0.5000000000000019), r2, fma(1.0, r, 1.0))
    p1 = fma(
        fma(0.00019841269890047113, r, 0.0013888888952314775), r2, fma(0.008333333333319601, r, 0.0416666666664881)
    )
    p2 = fma(
        fma(2.5110037605963777e-08, r, 2.763263963904103e-07),
        r2,
        fma(2.755724091857897e-06, r, 2.4801485482328494e-05),
    )
    r4 = r2 * r2
    return fma(fma(p2, r4, p1), r4, p0) * double((bits(shifted) << 52) + ONE)


@step
def log(x: float) -> float:
    """Return ln x for normal x > 0."""
    exponent = (bits(x) - SQRT_HALF) >> 52
    f = double(bits(x) - (exponent << 52)) - 1.0
    s = f / (2.0 + f)
    z = s * s
    z2 = z * z
    p0 = fma(0.39999999999899505, z, 0.666666666666667)
    p1 = fma(0.2222221113479508, z, 0.28571428625975487)
    p2 = fma(fma(0.14616449685043406, z, 0.15331721600556042), z, 0.18182889125261723)
    p = fma(fma(p2, z2, p1), z2, p0)
    n = float(exponent)
    return fma(n, LN2_HIGH, fma(s * z, p, fma(n, LN2_LOW, 2.0 * s)))


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
