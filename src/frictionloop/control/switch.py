"""How the loop is opened and closed, as by the firmware (firmware/core/fl_switch.h).

Open, the lookup alone commands, u = clip(f_r). The law runs along with both ends of its clamp there, so that its
observers know what goes on. When the loop closes an integral begins with what open loop commands, and the lower end of
the clamp comes down from there to where it belongs, in a line: the amplitude begins with at most what the set-point
asks for, and the law's anti-windup knows why.
"""

from __future__ import annotations

from frictionloop.quantities.arithmetic import fma, step

CLOSING = 512
"""Control periods over which the clamp opens after closing, 0.1 s (assumed; as FL_CLOSING of the firmware)."""


@step
def switched_clamp(setpoint_n: float, low_n: float, high_n: float, since: int) -> tuple[float, float]:
    """Return the clamp of a law so many periods after the loop closed, below 0 while it is open."""
    open_n = min(max(setpoint_n, low_n), high_n)
    down = fma((CLOSING - since) / CLOSING, open_n - low_n, low_n)
    return (open_n if since <= 0 else down), (open_n if since < 0 else high_n)
