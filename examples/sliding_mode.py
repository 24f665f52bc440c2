"""
A sliding mode as a law of your own
===================================

Super-twisting (paper, ref. [16]; Levant 1993) on the measured force, s = f_m - f_r:
``u = w - k1 |s|^(1/2) sign(s), w' = -k2 sign(s)``. It is stepped implicitly, so that
it has no sign to switch around s = 0 (Brogliato, Polyakov & Efimov 2020). Gains are
small: the force is read 300 us late, behind a resonance. So it chatters by some mN.

.. code-block:: console

    $ frictionloop --use examples/sliding_mode.py compare --laws sliding_mode
"""

import math
from typing import Literal, NamedTuple

import frictionloop as fl


class SlidingModeController(fl.Timing):
    """Gains of the super-twisting law, found by hand on ``fl.bench()``."""

    kind: Literal["sliding_mode"] = "sliding_mode"
    k1: float = 0.02
    """Gain on the root of the error, N^(1/2)."""
    k2: float = 10.0
    """Fastest change of w, N/s."""


class State(NamedTuple):
    """The integral, N; 0 stands for the believed friction without vibration."""

    w: float


class Gains(NamedTuple):
    """Fields of the controller by name, and the clamp, N."""

    k1: float
    k2: float
    low: float
    high: float


@fl.step
def sliding_mode(state, measured, setpoint_n, gains, dt):
    """One period: w moves by at most k2 dt, and by -s where that would overshoot."""
    s = measured.valid * (measured.force - setpoint_n)
    band = gains.k2 * dt
    w = state.w - min(max(s, -band), band)
    root = gains.k1 * math.sqrt(max(abs(s) - band, 0.0))
    v = gains.high + w - math.copysign(root, s)
    u = min(max(v, gains.low), gains.high)
    # The clamp stops w where it would go further into it.
    held = (v > u and s < 0.0) or (v < u and s > 0.0)
    return State(state.w if held else w), fl.ForceCommand(u, 1.0 if u != v else 0.0)


fl.register(fl.Law("sliding_mode", sliding_mode, State, Gains), SlidingModeController)

if __name__ == "__main__":
    for kind in ("lookup", "sliding_mode"):
        run = fl.simulate(fl.bench().evolve({"controller.kind": kind}), 5.0)
        print(f"{kind}: {1e3 * fl.rms_error(run):.0f} mN rms")
