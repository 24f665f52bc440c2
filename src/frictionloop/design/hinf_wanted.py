"""What a synthesised controller has to hold, on which plants, and what is asked for until every corner holds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.analysis.state_space import Complex
from frictionloop.design.corners import broken, corners
from frictionloop.design.noise_model import identify_noise
from frictionloop.design.plants import Plants, detuned
from frictionloop.design.quadruple import slicot
from frictionloop.design.wanted import Designed, Wanted, feedforward, unheld
from frictionloop.design.weighted_plant import check_order
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
    def of(cls, system: System, wanted: HinfWanted) -> Cases:
        """Return every contact with every error of the resonance, at the operating point of `linearise`."""
        r = wanted.resonance
        offs = (0.0, -r, r, -2.0 * r, 2.0 * r) if isinstance(system.sensor, SuspendedSensor) and r else (0.0,)
        skin = isinstance(system.finger, Skin)
        contacts = wanted.contact if skin else ("none",)
        benches = [system.evolve({"finger.contact": each}) if skin else system for each in contacts]
        points = [linearise(bench) for bench in benches]
        loops = [detuned(point, 1.0 + off) if off else point for off in offs for point in points]
        where = [(off, contact) for off in offs for contact in contacts]
        return cls(Plants.of(loops, overdrive=True), *zip(*where, strict=True))

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


def check(wanted: HinfWanted) -> None:
    """Refuse what is out of range."""
    for name, value, low, high in (
        ("sensitivity_peaks", min(wanted.sensitivity_peaks), 1.01, 10.0),
        ("resonance", wanted.resonance, 0.0, 0.45),
        ("order", wanted.order, 1, 2 * FILTERS),
    ):
        if not (low <= value <= high):
            raise FrictionloopError(f"{name} = {value:g}: must be from {low:g} to {high:g}")


TIGHTER = (1.0, 0.8, 0.6, 0.45, 0.3)
"""Shares of Ms - 1 that are tried where a synthesis does not see every corner."""


def synthesised(design: Callable[..., Any], system: System, wanted: Wanted) -> Designed:
    """Return the controller of the least tightened limits that holds at every corner, not only on the method's grid."""
    forward, notes = feedforward(system)
    # Identifying the noise already takes seconds.
    slicot()
    check_order(linearise(system).plant, system.controller.delay_s)
    noise = identify_noise(system)
    first = ""
    for share in TIGHTER:
        peaks = tuple(peak for _, peak in sorted(wanted.scaled(share).items()))
        peaks = peaks if len(peaks) == 3 else (peaks[0],) * 3
        asked = HinfWanted(peaks, wanted.resonance_error, contact=_contacts(system))
        try:
            found = design(system, noise, wanted=asked)
        except FrictionloopError as error:
            first = first or str(error)
            continue
        overrides = {**found.overrides, "controller.feedforward": forward}
        at = corners(system.evolve(overrides), wanted.limits)
        worst = broken(at)
        if worst is None:
            said = (
                f"{found.order} states, reduced from {found.full_order}; holds on contacts {', '.join(asked.contact)}"
            )
            return Designed(overrides, (*notes, said), tuple(at))
        first = first or unheld(found.method, wanted, worst)
    raise FrictionloopError(first)


def _contacts(system: System) -> tuple[str, ...]:
    own = system.finger.contact if isinstance(system.finger, Skin) else "dahl"
    return tuple(dict.fromkeys((own, "dahl", "slider")))
