"""What pulses of a whole number of clock ticks leave of an amplitude command (docs/plate)."""

from __future__ import annotations

import math

from frictionloop.quantities.arithmetic import step


@step
def pulse_step(command_um: float, largest_um: float, ticks: float) -> float:
    """a = a_max sin(pi n / C), n the whole number nearest to C arcsin(c / a_max) / pi; C ticks a carrier period.

    The fundamental of pulses of duty n/C is sin(pi n/C) of the largest; C = 783 at 36 MHz and 46 kHz.
    """
    share = min(max(command_um / largest_um, 0.0), 1.0)
    widest = math.floor(0.5 * ticks)
    width = min(math.floor(ticks * math.asin(share) / math.pi + 0.5), widest)
    return largest_um * math.sin(math.pi * width / ticks)
