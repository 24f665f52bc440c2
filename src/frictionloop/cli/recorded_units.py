"""What is asked and said of recorded signals by their numbers: those of a file, and what resampling takes out."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.analysis.levels import misread
from frictionloop.cli import screen
from frictionloop.cli.advice_text import WIDTH
from frictionloop.parameters import Recording
from frictionloop.recordings.doubts import SIGNALS, doubts_of

if TYPE_CHECKING:
    from frictionloop.parameters import System
    from frictionloop.recordings.told import Found

REMOVED = 0.02
"""Share of a recording (rms) from which on it is said that resampling removed it (chosen)."""


def asked(system: System, *about: str) -> list[str]:
    """Return the questions about recorded signals: all if no kind of `Doubt.about` is named."""
    found = [each.in_flags() for each in doubts_of(system) if not about or each.about in about]
    return [line for each in found for line in textwrap.wrap(each, WIDTH)]


def ask(system: System, signals: Sequence[str] = SIGNALS) -> None:
    """Note all questions about the recorded ones of these signals, for stderr."""
    for each in misread(system, signals):
        screen.note(each.in_flags())


def negative(system: System) -> list[str]:
    """Return which flag lifts a recorded set-point that asks for forces below zero, as one of zero mean does."""
    each = recordings(system).get("setpoint")
    if each is None or each.lowest_n >= 0 or each.signs:  # of friction with a sign its magnitude is meant
        return []
    said = f"The recorded setpoint asks for {each.lowest_n:.3g} N at its lowest; friction in one direction is above 0: "
    return textwrap.wrap(said + "--setpoint.offset_n LEVEL lifts the set-point (N).", WIDTH)


def resampled(system: System) -> list[str]:
    """Return how much of each recorded signal is faster than the control rate can hold, where that counts."""
    rate_hz, said = system.controller.rate_hz, []
    from frictionloop.recordings.read import scaled
    from frictionloop.recordings.straight_lines import removed_share

    for name in recordings(system):
        signal = getattr(system, name)
        force, file_hz, _, _ = scaled(signal, "N")
        share = removed_share(force, file_hz, rate_hz, signal.path)
        if share > REMOVED:
            said.append(
                f"{share:.0%} (rms) of what varies in the recorded {name} is faster than half the control rate, "
                f"{rate_hz / 2:g} Hz, and did not enter the run: resampling takes it out."
            )
    return [line for each in said for line in textwrap.wrap(each, WIDTH)]


def beside_able(system: System) -> list[str]:
    """Return what of a recorded disturbance counts where it is said which fingers are able; nothing of another."""
    read = recordings(system).get("disturbance")
    if read is None:
        return []
    return [f"(at the mean of the recorded disturbance; it goes from {read.lowest_n:.3g} to {read.highest_n:.3g} N)"]


def recordings(system: System) -> dict[str, Found]:
    """Return what was read of each recorded signal, by its name."""
    from frictionloop.recordings.told import found

    signals = {name: getattr(system, name) for name in ("setpoint", "disturbance")}
    return {name: found(each) for name, each in signals.items() if isinstance(each, Recording)}
