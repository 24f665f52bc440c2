"""``frictionloop device monitor``: what a device reads and does, as it happens."""

from __future__ import annotations

import sys
from typing import Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.cli.address import connected
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "ADDRESS [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop device monitor sim: --duration-s 2
  frictionloop device monitor serial:///dev/ttyACM0 --rate-hz 20
"""
COLUMNS = (("f_r", 1.0, "N", 6, 4), ("f_m", 1.0, "N", 7, 4), ("u", 1.0, "N", 6, 4), ("a", 1.0, "um", 6, 3),
           ("position", 1e3, "mm", 11, 2), ("speed", 1e3, "mm/s", 10, 1), ("load", 1.0, "N", 6, 3))  # fmt: skip
"""Channels with their factor to the unit shown, the width, and the places after the point; 80 columns with a state."""


def command(
    address: Annotated[str, Parameter(name="ADDRESS", help="As in device info.", group=flags.SYSTEM)],
    /,
    *,
    duration_s: Annotated[float, Parameter(help="How long to look, in s.", group=flags.RUN)] = 10.0,
    rate_hz: Annotated[float, Parameter(help="Lines a second, at most 100.", group=flags.RUN)] = 10.0,
) -> None:
    """Print one line per sample, without asking the plate for anything: `device run` closes the loop."""
    if not 0 < rate_hz <= 100:
        raise FrictionloopError(f"rate_hz = {rate_hz:g}: must be above 0 and at most 100 lines a second")
    if not 0 < duration_s < float("inf"):
        raise FrictionloopError(f"duration_s = {duration_s:g}: must be above 0 and finite")

    from frictionloop.device.recorder import fault_of, state_of
    from frictionloop.quantities.schema import schema

    states, faults = (_by_number(schema()[group]) for group in ("states", "faults"))
    with connected(address) as device:
        tick_hz = device.info.tick_hz
        names = [f"{f'{name} {unit}':>{width}}" for name, _, unit, width, _ in COLUMNS]
        screen.show("  ".join(["     s", *names, "state"]))
        for block in device.stream(duration_s, max(round(tick_hz / rate_hz), 1)):
            for k, tick in enumerate(block["tick"]):
                values = [f"{factor * block[name][k]:{width}.{places}f}" for name, factor, _, width, places in COLUMNS]
                state = states[int(state_of(block["flags"])[k])]
                fault = faults[int(fault_of(block["flags"])[k])]
                print("  ".join([f"{tick / tick_hz:6.2f}", *values, state if fault == "none" else fault]))
            sys.stdout.flush()


def _by_number(names: dict[str, Any]) -> dict[int, str]:
    return {number: name.replace("_", " ") for name, number in names.items()}
