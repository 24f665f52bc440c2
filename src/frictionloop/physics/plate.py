"""The envelope of the vibrating plate: first-order low-pass on the amplitude (paper, Sec. 2.2, after ref. [10])."""

from __future__ import annotations

import math
from typing import NamedTuple

from frictionloop.parameters import LowpassPlate, ResonantPlate
from frictionloop.parameters.block import Block
from frictionloop.quantities import Lti
from frictionloop.quantities.scalar_math import fma, step


@step
def lowpass_step(amplitude_um: float, command_um: float, decay: float) -> float:
    """a(t + h) = c + (a(t) - c) e^(-wc h): exact while the command c is held; ``decay`` is e^(-wc h)."""
    return fma(amplitude_um - command_um, decay, command_um)


@step
def limit_step(command_um: float, max_amplitude_um: float) -> float:
    """min(max(c, 0), a_max): what the drive can do of a command."""
    return min(max(command_um, 0.0), max_amplitude_um)


class PlateCoefficients(NamedTuple):
    """Of `plate_step`, for a time h in s."""

    half: float
    """e^(-wc h/2)."""
    whole: float
    """e^(-wc h)."""


def plate_coefficients(plate: LowpassPlate | ResonantPlate, h: float) -> PlateCoefficients:
    """Return the coefficients of `plate_step` for steps of h seconds."""
    rate = -2.0 * math.pi * plate.cutoff_hz
    return PlateCoefficients(math.exp(rate * h / 2.0), math.exp(rate * h))


@step
def plate_step(
    amplitude_um: float, command_um: float, max_amplitude_um: float, coefficients: PlateCoefficients
) -> tuple[float, float]:
    """Amplitude in the middle and at the end of a step in which the drive holds a command."""
    held = limit_step(command_um, max_amplitude_um)
    return lowpass_step(amplitude_um, held, coefficients.half), lowpass_step(amplitude_um, held, coefficients.whole)


@step
def pulse_step(command_um: float, largest_um: float, ticks: float) -> float:
    """a = a_max sin(pi n / C), n the whole number nearest to C arcsin(c / a_max) / pi; C ticks a carrier period.

    The fundamental of pulses of duty n/C is sin(pi n/C) of the largest (docs/plate); C = 783 at 36 MHz and 46 kHz.
    """
    share = min(max(command_um / largest_um, 0.0), 1.0)
    widest = math.floor(0.5 * ticks)
    width = min(math.floor(ticks * math.asin(share) / math.pi + 0.5), widest)
    return largest_um * math.sin(math.pi * width / ticks)


LINEAR_PLATE: dict[type[Block], str] = {
    LowpassPlate: "kind cutoff_hz max_amplitude_um",
    ResonantPlate: "kind frequency_hz q max_amplitude_um",
}
"""Fields of a plate that `linearise_plate` has, and the operating point; what is not here is refused."""


def linearise_plate(plate: LowpassPlate | ResonantPlate) -> Lti:
    """Return P(s) = 1 / (1 + s/wc), amplitude command to amplitude."""
    return Lti((1.0,), (1.0 / (2.0 * math.pi * plate.cutoff_hz), 1.0))
