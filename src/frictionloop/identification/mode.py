"""Modes as they are found, whether from decays or from a response, and which of them are asked for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

from frictionloop.findings import Finding
from frictionloop.identification.estimate import Estimate
from frictionloop.identification.poles import Pole
from frictionloop.quantities import must_be

Which = Literal["first", "strongest"]


class Mode(NamedTuple):
    """One damped oscillation that hits have in common."""

    frequency: Estimate
    """Hz, undamped; the standard error is that of the scatter from hit to hit."""
    q: Estimate
    share: float
    """Of the energy of the decays."""
    agreement: float
    """1 - variance over hits of the frequency, in units of the mode's squared bandwidth: 1 is perfect, below 0 none."""


@dataclass(frozen=True)
class Modes:
    """The modes of a structure, from the lowest up."""

    modes: tuple[Mode, ...]
    """All that were found."""
    chosen: tuple[int, ...]
    """Which of them were asked for."""
    misfit: float
    """rms of what the modes leave over that of the decays."""
    method_hz: tuple[float, ...]
    """Standard error in Hz of each mode from window and order, and in Q below."""
    method_q: tuple[float, ...]
    hits: int
    diagram: tuple[Pole, ...]
    """Poles over order."""
    findings: tuple[Finding, ...] = ()
    """Which hits were left out."""
    bow: float = 0.0
    """Largest slow bow beneath the reading, which was taken off."""
    fitted: tuple[tuple[float, float], ...] = ()
    """Of a response: frequency in Hz, and the magnitude that the modes make there."""

    @property
    def asked(self) -> tuple[Mode, ...]:
        """The modes that were asked for."""
        return tuple(self.modes[k] for k in self.chosen)


def chosen_of(found: Sequence[Mode], which: Which | int, band_hz: tuple[float, float]) -> tuple[int, ...]:
    """Return which modes are asked for, listing what there is where they are not."""
    listed = ", ".join(f"{mode.frequency.value:.5g} Hz ({mode.share:.0%})" for mode in found)
    inside = [k for k, mode in enumerate(found) if band_hz[0] <= mode.frequency.value <= band_hz[1]]
    if not inside:
        raise must_be("band_hz", band_hz, f"around a mode: {listed}", "Hz")
    if which == "first":
        return (inside[0],)
    if which == "strongest":
        return (max(inside, key=lambda k: found[k].share),)
    if isinstance(which, int) and not isinstance(which, bool) and 1 <= which <= len(inside):
        return tuple(inside[:which])
    raise must_be("which", which, f"'first', 'strongest' or 1 to {len(inside)}: {listed}")
