"""``frictionloop device``: what is on a port, what it reads and counts, a run on it, and its image."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.extra import all_needed
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.device.device import Device
    from frictionloop.parameters import System

ADDRESS = (
    "sim: (the firmware here, with a simulated bench), emulated:IMAGE (an image, or the folder firmware build made, "
    "on an emulated board, with the same), tcp://host:port, or a port: serial:///dev/ttyACM0 (Linux), "
    "serial:///dev/cu.usbmodem1 (macOS), serial://COM3 (Windows)."
)
Address = Annotated[str, Parameter(name="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
SameAddress = Annotated[str, Parameter(name="ADDRESS", help="As in device info.", group=flags.SYSTEM)]
LIST_EXAMPLES = """Examples

  frictionloop device list
"""
CLEAR_EXAMPLES = """Examples

  frictionloop device clear serial:///dev/ttyACM0
"""
MONITOR_EXAMPLES = """Examples

  frictionloop device monitor sim: --duration-s 2
  frictionloop device monitor serial:///dev/ttyACM0 --rate-hz 20
"""
SIMULATED = ("sim:", "the firmware on this machine, with a simulated bench")
COLUMNS = (("f_r", 1.0, "N", 6, 4), ("f_m", 1.0, "N", 7, 4), ("u", 1.0, "N", 6, 4), ("a", 1.0, "um", 6, 3),
           ("position", 1e3, "mm", 11, 2), ("speed", 1e3, "mm/s", 10, 1), ("load", 1.0, "N", 6, 3))  # fmt: skip
"""Channels with their factor to the unit shown, the width, and the places after the point; 80 columns with a state."""
NEEDED = {"sim": ("cffi",), "emulated": ("elftools", "unicorn", "intelhex")}
"""Modules that an address takes beside those of the line."""
LISTEN_S, DECIMATION = 0.1, 50
"""Ten samples of telemetry: the last one tells the fault that is in force."""


@contextmanager
def connected(address: str, system: System | None = None, seed: int = 0) -> Iterator[Device]:
    """Yield the device, as `connect` does; says what takes long the first time."""
    here = address.startswith(("sim:", "emulated:"))
    all_needed("cobs", "fastcrc", *NEEDED.get(address.partition(":")[0], ()))
    with screen.waiting("loading the compiled loop and firmware" if here else f"looking for {address}"):
        from frictionloop.device.transport import opener

        opening = opener(address, system, seed)
        # A line that is not there is refused before what drives a device is loaded.
        opened = [] if here else [opening()]
        from frictionloop.device.device import Device

        found = Device(lambda: opened.pop() if opened else opening(), address)
    with found:
        yield found


def list_ports(*, json: flags.Json = False) -> None:
    """List the serial ports of this machine and the simulated board, by the address that `info` and `run` take."""
    from frictionloop.device.serial_pipe import described_ports

    found = described_ports()
    rows = [*found, SIMULATED]
    if json:
        screen.show_json({"ports": [{"address": address, "is": what} for address, what in rows]})
        return
    screen.show(screen.columns(rows))
    if not found:
        screen.show("no serial port: is the board plugged in, and has it a USB serial adapter?")


def clear(address: SameAddress, /, *, json: flags.Json = False) -> None:
    """Clear the fault that a device stopped with, and say which it was; refused while its cause lasts."""
    from frictionloop.device.errors import Refused
    from frictionloop.device.recorder import fault_of
    from frictionloop.quantities.schema import schema

    numbers = schema()["faults"]
    with connected(address) as device:
        told = [fault_of(block["flags"])[-1] for block in device.stream(LISTEN_S, DECIMATION)]
        if not told:
            raise FrictionloopError(f"{address}: sends no samples, so its fault is not known")
        fault = next((name for name, number in numbers.items() if number == told[-1]), f"number {told[-1]:g}")
        try:
            device.clear()
        except Refused as refused:
            if refused.reason != "still_at_fault":
                raise
            raise FrictionloopError(f"fault {fault}: its cause lasts; put it right, then clear again") from None
    had = fault if told[-1] != numbers["none"] else None
    if json:
        screen.show_json({"cleared": had})
        return
    screen.show(f"cleared {had}" if had else "no fault")


def monitor(
    address: SameAddress,
    /,
    *,
    duration_s: flags.Run[float] = 10.0,
    rate_hz: flags.Run[float] = 10.0,
) -> None:
    """Print one line per sample, without asking the plate for anything: `device run` closes the loop.

    Parameters
    ----------
    duration_s
        How long to look, in s.
    rate_hz
        Lines a second, at most 100.
    """
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
