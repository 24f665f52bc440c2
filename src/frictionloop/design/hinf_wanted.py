"""What a synthesised controller has to hold, and what of it a controller does not."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from frictionloop.design.high_order import Synthesised
from frictionloop.design.sections import SECTIONS
from frictionloop.design.weighted_plant import Weights
from frictionloop.quantities import FrictionloopError


@dataclass(frozen=True)
class HinfWanted:
    """What a synthesised controller has to hold."""

    sensitivity_peaks: tuple[float, float, float] = (1.7, 2.0, 2.6)
    """Largest Ms with the resonance as described, off by `resonance`, and by twice that, at the bench's own gain."""
    resonance: float = 0.05
    """Share by which the resonance may be off, either way."""
    gain: tuple[float, float] = (0.65, 2.0)
    """Factors on the loop gain at which it has to be stable with the resonance off by twice `resonance`.

    A finger's is F tau/(u tau_model) behind the lookup; at 0.6 N it is 1.05 to 1.86 from the first to the last decile
    of the capable among ``fingers(100, 3)`` on the bench.
    """
    contact: tuple[str, ...] = ("dahl", "slider")
    """Contact laws on which all that holds; the bench's own one first."""
    command_noise_n: float = 0.03
    """Largest rms of the command that sensor noise causes, N: beyond it the command strays into the clamp (assumed)."""
    overdrive: bool = True
    """Whether overdrive makes up for the plate, and not the sections."""
    order: int = 2 * SECTIONS
    """Most states of the sections, at most 12."""


def broken(found: Synthesised, wanted: HinfWanted) -> str:
    """Return in one line what does not hold, or nothing."""
    table = found.table.isel(speed_mm_s=0)
    near = table["sensitivity_peak"].sel(gain=1.0)
    for share, most in zip(np.arange(3) * wanted.resonance, wanted.sensitivity_peaks, strict=True):
        peak = near.where(np.abs(near["resonance"]) <= share + 1e-9)
        if not float(peak.max()) <= most:
            at = peak.isel(peak.argmax(...))
            return (
                f"sensitivity_peaks = {wanted.sensitivity_peaks}: the {found.method} controller gets to "
                f"{float(at):.3g} with the resonance off by {float(at['resonance']):.3g} "
                f"and contact {at['contact'].item()!r}"
            )
    if not found.command_noise_n <= wanted.command_noise_n:
        return (
            f"command_noise_n = {wanted.command_noise_n:g} N: sensor noise makes {found.command_noise_n:.3g} N of "
            f"command with the {found.method} controller"
        )
    if not bool(table["stable"].all()):
        return f"gain = {wanted.gain}: the {found.method} controller is not stable over these factors on the loop gain"
    return ""


def check(wanted: HinfWanted, weights: Weights) -> None:
    """Refuse what is out of range."""
    for name, value, low, high in (
        ("sensitivity_peaks", min(wanted.sensitivity_peaks), 1.01, 10.0),
        ("resonance", wanted.resonance, 0.0, 0.45),
        ("order", wanted.order, 1, 2 * SECTIONS),
        ("resonance_bias", weights.resonance_bias, -0.5, 0.5),
    ):
        if not (low <= value <= high):
            raise FrictionloopError(f"{name} = {value:g}: must be from {low:g} to {high:g}")
