"""Recorded signals whose numbers are hardly newtons are asked about, before their mean is removed."""

from __future__ import annotations

import re
import textwrap
from typing import TYPE_CHECKING

from frictionloop.cli.advice_text import FINGERS_N, WIDTH
from frictionloop.parameters import Recording

if TYPE_CHECKING:
    from frictionloop.parameters import System
    from frictionloop.recordings.told import Found

LOAD = re.compile(r"(?<![a-z])(normal|load|preload|weight|fz|fn|grip)(?![a-z])", re.IGNORECASE)
"""Names of what presses on the finger, which in a recording stands beside the friction."""
REMOVED = 0.02
"""Share of a recording (rms) from which on it is said that resampling removed it (chosen)."""
LEAST_N = 1e-3
"""Variation (rms) of a disturbance below which its unit is asked about: that of fingers is some 10 mN (assumed)."""


def too_large(system: System) -> list[str]:
    """Return a question for each recorded signal that is larger than a finger's force."""
    said = []
    for name, each in recordings(system).items():
        if each.largest_n > FINGERS_N:
            removed = " before its mean is removed" if getattr(system, name).remove_mean else ""
            meant = f"--{name}.unit mN" if each.unit == "N" else f"another --{name}.scale"
            said.append(f"The recorded {name} is up to {each.largest_n:.4g} N{removed}; did you mean {meant}?")
    return [line for each in said for line in textwrap.wrap(each, WIDTH)]


def too_small(system: System) -> list[str]:
    """Return a question for a recorded disturbance that hardly varies, though it does."""
    each = recordings(system).get("disturbance")
    if each is None or not 0 < each.rms_n < LEAST_N:
        return []
    said = f"The recorded disturbance varies by {1e3 * each.rms_n:.3g} mN rms only; did you mean {_larger(each)}?"
    return textwrap.wrap(said, WIDTH)


def misnamed(system: System) -> list[str]:
    """Return a question for each recorded signal whose column is named as a normal force is, and no friction."""
    said = [
        f"The recorded {name} is column {each.column!r}: is that the load on the finger? {name} is a friction force; "
        f"--{name}.column NAME takes another column."
        for name, each in recordings(system).items()
        if LOAD.search(each.column)
    ]
    return [line for each in said for line in textwrap.wrap(each, WIDTH)]


def negative(system: System) -> list[str]:
    """Return which flag lifts a recorded set-point that asks for forces below zero, as one of zero mean does."""
    each = recordings(system).get("setpoint")
    if each is None or each.lowest_n >= 0:
        return []
    said = f"The recorded setpoint asks for {each.lowest_n:.3g} N at its lowest; friction in one direction is above 0: "
    return textwrap.wrap(said + "--setpoint.offset_n LEVEL lifts the set-point (N).", WIDTH)


def resampled(system: System) -> list[str]:
    """Return how much of each recorded signal is faster than the control rate can hold, where that counts."""
    rate_hz, said = system.controller.rate_hz, []
    from frictionloop.recordings.read import scaled
    from frictionloop.recordings.resampling import removed_share

    for name in recordings(system):
        signal = getattr(system, name)
        force, file_hz, _ = scaled(signal, "N")
        share = removed_share(force, file_hz, rate_hz, signal.path)
        if share > REMOVED:
            said.append(
                f"{share:.0%} (rms) of what varies in the recorded {name} is faster than half the control rate, "
                f"{rate_hz / 2:g} Hz, and did not enter the run: resampling takes it out."
            )
    return [line for each in said for line in textwrap.wrap(each, WIDTH)]


def _larger(each: Found) -> str:
    """Return the flag that makes a signal larger."""
    if each.unit in ("mN", "uN"):
        return "--disturbance.unit N" if each.unit_by == "given" else "--disturbance.scale 1"
    return "another --disturbance.unit" if each.unit_by == "taken for N" else "another --disturbance.scale"


def recordings(system: System) -> dict[str, Found]:
    """Return what was read of each recorded signal, by its name."""
    from frictionloop.recordings.told import found

    signals = {name: getattr(system, name) for name in ("setpoint", "disturbance")}
    return {name: found(each) for name, each in signals.items() if isinstance(each, Recording)}
