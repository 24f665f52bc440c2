"""Doubts about recorded signals beside the answer of verbs that are no result yet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.cli import screen

if TYPE_CHECKING:
    from frictionloop.parameters import System


def ask(system: System, signals: Sequence[str] = ("setpoint", "disturbance")) -> None:
    """Note what is in doubt of the recorded ones of these signals, for stderr."""
    from frictionloop.analysis.levels import misread

    screen.note_findings(misread(system, signals))


def beside_able(system: System) -> list[str]:
    """Return what of a recorded disturbance counts where it is said which fingers are able; nothing of another."""
    from frictionloop.loop.recorded_findings import recordings

    read = recordings(system).get("disturbance")
    if read is None:
        return []
    return [f"(at the mean of the recorded disturbance; it goes from {read.lowest_n:.3g} to {read.highest_n:.3g} N)"]
