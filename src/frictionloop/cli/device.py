"""``frictionloop device``: what is on a port, its parameters, a run on it, and its image."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import device_clear, device_flash, device_monitor, device_run, flags, screen
from frictionloop.cli.address import connected
from frictionloop.cli.helptext import group_app
from frictionloop.quantities.units import FrictionloopError

ADDRESS = (
    "sim: (the firmware here, with a simulated bench), emulated:IMAGE (an image on an emulated board, with the same), "
    "serial:///dev/ttyACM0 or tcp://host:port."
)
Address = Annotated[str, Parameter(name="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
SIMULATED = ("sim:", "the firmware on this machine, with a simulated bench")
LIST_EXAMPLES = r"""Examples

  frictionloop device list
"""
INFO_EXAMPLES = r"""Examples

  frictionloop device info sim:
  frictionloop device info serial:///dev/ttyACM0 --json
"""
SET_EXAMPLES = r"""Examples

  frictionloop device set sim: drive.ceiling_um=2 setpoint.hold_n=0.5
  frictionloop device set serial:///dev/ttyACM0 --system my-controller.toml
"""

app = group_app(
    "device",
    "A board on this machine's ports, or one that is simulated: look at it, set it up, run it, flash it.",
    "run",
    flags.DEVICE,
)


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


def info(address: Address, /, *, json: flags.Json = False) -> None:
    """Say who answers at an address, what runs there and what it has counted since reset."""
    from frictionloop.control.laws import NUMBERED
    from frictionloop.quantities.schema import table_hash

    with connected(address) as device:
        found, counted, parameters = device.info, device.statistics(), device.parameters
        law = NUMBERED[found.law - 1].kind if 0 < found.law <= len(NUMBERED) else "none"
        clamp = float(parameters["law.low_n"]), float(parameters["law.high_n"])
        ceiling = float(parameters["drive.ceiling_um"])
    same = found.table_hash == table_hash()
    result = {**found._asdict(), "law": law, "clamp_n": clamp, "ceiling_um": ceiling, "same_table": same, **counted}
    if json:
        screen.show_json(result)
        return
    rows = [
        ("board", f"{found.board}, serial number {found.serial}" if found.serial else found.board),
        ("firmware", f"{found.revision}, protocol {found.version}, {found.tick_hz} ticks a second"),
        ("parameters", "the same table as here" if same else f"table {found.table_hash:08x}, not the one here"),
        ("law", f"{law}, {clamp[0]:.3g} to {clamp[1]:.3g} N, at most {ceiling:.3g} um"),
        ("ticks", f"{counted['ticks']:,.0f}, {counted['overruns']:,.0f} late, {_longest(counted['longest_us'])}"),
        ("frames", f"{counted['frames']:,.0f} whole, {counted['broken']:,.0f} broken, {counted['missed']:,.0f} missed"),
        ("telemetry", f"{counted['dropped']:,.0f} samples dropped"),
    ]
    screen.show(screen.columns(rows))


def _longest(longest_us: float) -> str:
    # A board without a counter of cycles, such as a simulated one, tells 0.
    return f"longest {longest_us:.3g} us" if longest_us else "longest tick not measured"


def set_parameters(
    address: Address,
    /,
    *assignments: Annotated[str, Parameter(name="NAME=VALUE", help="A parameter and its value.", group=flags.SYSTEM)],
    system: Annotated[
        Path | None, Parameter(help="Set the whole table from this system (.toml).", group=flags.SYSTEM)
    ] = None,
    json: flags.Json = False,
) -> None:
    """Set parameters of a device, all at once; it refuses them as a whole if one is wrong. A reset forgets them."""
    pairs = [_pair(text) for text in assignments]
    if not pairs and system is None:
        raise FrictionloopError("set: needs NAME=VALUE or --system FILE")
    described = flags.system_from(system, None, None) if system is not None else None

    from frictionloop.firmware.words import shown

    with connected(address) as device:
        if described is not None:
            device.upload(described)
        before = {name: device.parameters[name] for name, _ in pairs}
        for name, value in pairs:
            device.set(name, value)
        if pairs:
            device.commit()
        after = {name: device.parameters[name] for name, _ in pairs}
        about = {name: device.parameters.about(name) for name in after}
    if json:
        screen.show_json({"system": str(system) if system else None, "before": before, "after": after})
        return
    rows = [("table", f"set from {system}")] if system else []
    rows += [(name, f"{shown(word, before[name])} -> {shown(word, after[name])}") for name, word in about.items()]
    screen.show(screen.columns(rows))


def _pair(text: str) -> tuple[str, object]:
    name, equals, value = text.partition("=")
    if not equals or not name or not value:
        raise FrictionloopError(f"{text!r}: must be NAME=VALUE, such as drive.ceiling_um=2")
    return name, flags.scalar(value)


app.command(list_ports, name="list", usage="frictionloop device list [--json]", help_epilogue=LIST_EXAMPLES)
app.command(info, usage="frictionloop device info ADDRESS [--json]", help_epilogue=INFO_EXAMPLES)
app.command(
    set_parameters,
    name="set",
    usage="frictionloop device set ADDRESS NAME=VALUE... [--system FILE]",
    help_epilogue=SET_EXAMPLES,
)
for verb in (device_run, device_clear, device_monitor, device_flash):
    name = verb.__name__.rsplit("_", 1)[-1]
    app.command(
        verb.command, name=name, usage=f"frictionloop device {name} {verb.ARGUMENTS}", help_epilogue=verb.EXAMPLES
    )
