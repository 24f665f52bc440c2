"""One second-order section, the block that filters of any order are made of."""

from __future__ import annotations

from frictionloop.quantities.arithmetic import fma, step


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
