"""Compiled scalar arithmetic: the same bits in a scalar loop and in a vector loop, unlike libm's.

``exp2``, ``log2`` and the circular functions are branch-free polynomials, so LLVM vectorises a loop over lanes that
calls them. Fused multiply-adds are written out (``fma``) and never left to the compiler: a result then does not
depend on whether a loop was vectorised, which is what makes a run in a grid equal to the same run alone.
Coefficients: Chebyshev interpolation at 40 digits (mpmath.chebyfit); errors below 2 ulp, of log2 below 3 (tests/unit).
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import njit, types
from numba.extending import intrinsic

step = njit(error_model="numpy", forceinline=True)
"""Compile a scalar step function; division by zero gives inf as in NumPy, which keeps loops branch-free."""


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
ONE = 0x3FF0000000000000  # bits of 1.0
SQRT_HALF = 0x3FE6A09E667F3BCD  # bits of sqrt(1/2)


@step
def exp2(x: float) -> float:
    """Return 2^x for x < 1023; below -1000 the result is 2^-1000."""
    x = max(x, -1000.0)
    shifted = x + ROUND
    r = x - (shifted - ROUND)  # exact, |r| <= 1/2: base 2 needs no constant split in two
    r2 = r * r
    p0 = fma(fma(0.055504108664821625, r, 0.24022650695910158), r2, fma(0.6931471805599453, r, 1.0))
    p1 = fma(
        fma(1.5252733841556773e-05, r, 0.00015403530463724353), r2, fma(0.001333355814640647, r, 0.009618129107587256)
    )
    p2 = fma(
        fma(4.4558179083360645e-10, r, 7.074194297288521e-09),
        r2,
        fma(1.0178057087733941e-07, r, 1.3215432535912375e-06),
    )
    r4 = r2 * r2
    return fma(fma(p2, r4, p1), r4, p0) * double((bits(shifted) << 52) + ONE)


@step
def log2(x: float) -> float:
    """Return the binary logarithm of a normal x > 0."""
    exponent = (bits(x) - SQRT_HALF) >> 52
    f = double(bits(x) - (exponent << 52)) - 1.0
    s = f / (2.0 + f)  # log2(1 + f) = 2 atanh(s) / ln 2, |s| < 0.172
    z = s * s
    z2 = z * z
    p0 = fma(0.9617966939259898, z, 2.8853900817779268)
    p1 = fma(0.4121985858409005, z, 0.5770780163455203)
    p2 = fma(0.262334352504183, z, 0.32059853491395984)
    p3 = fma(0.2136589569431927, z, 0.2209130842311768)
    p = fma(fma(p3, z2, p2), z2 * z2, fma(p1, z2, p0))
    return fma(s, p, float(exponent))


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
