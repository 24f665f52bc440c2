"""``frictionloop device``: what is on a port, its fault, and what it reads."""

from __future__ import annotations

import json as lines
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import flags, screen

if TYPE_CHECKING:
    from frictionloop import Device, System

ADDRESS = (
    "sim: (simulated bench), emulated:IMAGE (image on an emulated board), "
    "tcp://HOST:PORT, or a port: serial:///dev/ttyACM0, serial://COM3."
)
Address = Annotated[str, Parameter(name="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
SameAddress = Annotated[str, Parameter(name="ADDRESS", help="As in device info.", group=flags.SYSTEM)]
LIST_EXAMPLES = ("",)
CLEAR_EXAMPLES = ("serial:///dev/ttyACM0",)
MONITOR_EXAMPLES = (
    "sim: --duration-s 2",
    "serial:///dev/ttyACM0 --rate-hz 20",
)
COLUMNS = (("s", 6, 2), ("f_r N", 6, 4), ("f_m N", 7, 4), ("u N", 6, 4), ("a um", 6, 3), ("position mm", 11, 2),
           ("speed mm/s", 10, 1), ("load N", 6, 3))  # fmt: skip
"""Heads of a reading, their width, and the places after the point; 80 columns with the state."""


@contextmanager
def connected(address: str, system: System | None = None, seed: int = 0) -> Iterator[Device]:
    """Yield the device, as `connect` does; says what takes long the first time."""
    with fl.progress.waiting(f"connecting {address}"):
        opening = fl.device.opened(address, system, seed)
        found = opening.__enter__()
    try:
        yield found
    finally:
        opening.__exit__(*sys.exc_info())


def list_ports(*, shown: screen.Shown = screen.BRIEFLY) -> None:
    """List the serial ports of this machine and the simulated board, by the address that `info` and `run` take."""
    shown.show(fl.device.list_ports())


def clear(address: SameAddress, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Clear the fault that a device stopped with, and say which it was; refused while its cause lasts."""
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.clear(address)
    shown.show(found)


def monitor(
    address: SameAddress,
    /,
    *,
    duration_s: flags.Run[float] = 10.0,
    rate_hz: flags.Run[float] = 10.0,
    json: flags.Result[flags.Flag] = False,
) -> None:
    """Print one line per sample, without asking the plate for anything: `device run` closes the loop.

    Parameters
    ----------
    duration_s
        How long to look, in s.
    rate_hz
        Lines a second, at most 100.
    json
        A JSON object a line.
    """
    head = "  ".join([*(f"{name:>{width}}" for name, width, _ in COLUMNS), "state"])
    for k, reading in enumerate(fl.device.monitor(address, duration_s, rate_hz)):
        if k == 0 and not json:
            print(head)
        values = [f"{value:{width}.{places}f}" for value, (_, width, places) in zip(reading, COLUMNS, strict=False)]
        print(lines.dumps(reading._asdict()) if json else "  ".join([*values, reading.state]), flush=True)
