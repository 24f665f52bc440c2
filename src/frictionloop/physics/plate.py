"""The envelope of the vibrating plate: first-order low-pass on the amplitude (paper, Sec. 2.2, after ref. [10])."""

from __future__ import annotations

import math

from frictionloop.parameters import LowpassPlate, ResonantPlate
from frictionloop.quantities import Lti
from frictionloop.quantities.arithmetic import fma, step


@step
def lowpass_step(amplitude_um: float, command_um: float, decay: float) -> float:
    """a(t + h) = c + (a(t) - c) e^(-wc h): exact while the command c is held; ``decay`` is e^(-wc h)."""
    return fma(amplitude_um - command_um, decay, command_um)


@step
def limit_step(command_um: float, max_amplitude_um: float) -> float:
    """min(max(c, 0), a_max): what the drive can do of a command."""
    return min(max(command_um, 0.0), max_amplitude_um)


def linearise_plate(plate: LowpassPlate | ResonantPlate) -> Lti:
    """Return P(s) = 1 / (1 + s/wc), amplitude command to amplitude."""
    return Lti((1.0,), (1.0 / (2.0 * math.pi * plate.cutoff_hz), 1.0))
