"""Overdrive: the amplitude command overshoots so that the plate gets where it is wanted in one period (ref. [14])."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from frictionloop.parameters import Model
from frictionloop.quantities.arithmetic import fma, step


class OverdriveGains(NamedTuple):
    """Decay e^(-2 pi f_plate dt) of the believed plate, 1/(1 - decay), and the largest amplitude in um."""

    decay: float
    inverse: float
    largest_um: float


@step
def overdrive_step(amplitude_um: float, wanted_um: float, gains: OverdriveGains) -> tuple[float, float]:
    """c = clip((a_w - p a)/(1 - p), 0, a_max), then a' = p a + (1 - p) c: new belief, and command."""
    decay, inverse, largest = gains
    command = min(max(fma(-decay, amplitude_um, wanted_um) * inverse, 0.0), largest)
    return fma(decay, amplitude_um - command, command), command


def overdrive_gains(controller: Any) -> OverdriveGains:
    """Return the gains for a controller, with overdrive or without."""
    if not getattr(controller, "overdrive", False):
        return no_overdrive(controller.model)
    decay = math.exp(-2.0 * math.pi * controller.model.plate_hz / controller.rate_hz)
    return OverdriveGains(decay, 1.0 / (1.0 - decay), controller.model.max_amplitude_um)


def no_overdrive(model: Model) -> OverdriveGains:
    """Return the gains with which the believed plate follows at once, and nothing changes."""
    return OverdriveGains(0.0, 1.0, model.max_amplitude_um)
