"""What a synthesised controller has to hold, and the plants on which it is looked at."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.analysis.state_space import Complex
from frictionloop.design.plants import Plants, detuned
from frictionloop.design.weighted_plant import Weights
from frictionloop.parameters import Skin, SuspendedSensor, System
from frictionloop.parameters.filtered import FILTERS
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
    order: int = 2 * FILTERS
    """Most states of the sections, at most 12."""


@dataclass(frozen=True, eq=False)
class Cases:
    """The plants on which that is looked at, the bench as described first."""

    plants: Plants
    offs: tuple[float, ...]
    """Of each plant: share by which the resonance is off, and contact."""
    contacts: tuple[str, ...]

    @classmethod
    def of(cls, system: System, wanted: HinfWanted, force_n: float | None) -> Cases:
        """Return every contact with every error of the resonance, at an operating point (`linearise`)."""
        r = wanted.resonance
        offs = (0.0, -r, r, -2.0 * r, 2.0 * r) if isinstance(system.sensor, SuspendedSensor) and r else (0.0,)
        skin = isinstance(system.finger, Skin)
        contacts = wanted.contact if skin else ("none",)
        benches = [system.evolve({"finger.contact": each}) if skin else system for each in contacts]
        points = [linearise(bench, force_n=force_n) for bench in benches]
        loops = [detuned(point, 1.0 + off) if off else point for off in offs for point in points]
        where = [(off, contact) for off in offs for contact in contacts]
        return cls(Plants.of(loops, wanted.overdrive), *zip(*where, strict=True))

    def peaks(self, controller: Complex) -> Iterator[tuple[float, float, str]]:
        """Return Ms of every plant, with its error of the resonance and its contact."""
        return zip(self.plants.peaks(controller).tolist(), self.offs, self.contacts, strict=True)

    def broken(self, controller: Complex, wanted: HinfWanted, method: str) -> str:
        """Return in one line which margin does not hold, or nothing."""
        for share, most in zip(np.arange(3) * wanted.resonance, wanted.sensitivity_peaks, strict=True):
            peak, off, contact = max(each for each in self.peaks(controller) if abs(each[1]) <= share + 1e-9)
            if not peak <= most:
                return (
                    f"sensitivity_peaks = {wanted.sensitivity_peaks}: the {method} controller gets to {peak:.3g} with "
                    f"the resonance off by {off:.3g} and contact {contact!r}"
                )
        if not all(self.plants.stable(factor * controller).all() for factor in wanted.gain):
            return f"gain = {wanted.gain}: the {method} controller is not stable over these factors on the loop gain"
        return ""


def check(wanted: HinfWanted, weights: Weights) -> None:
    """Refuse what is out of range."""
    for name, value, low, high in (
        ("sensitivity_peaks", min(wanted.sensitivity_peaks), 1.01, 10.0),
        ("resonance", wanted.resonance, 0.0, 0.45),
        ("order", wanted.order, 1, 2 * FILTERS),
        ("resonance_bias", weights.resonance_bias, -0.5, 0.5),
    ):
        if not (low <= value <= high):
            raise FrictionloopError(f"{name} = {value:g}: must be from {low:g} to {high:g}")
