"""``frictionloop device info``: who answers, what runs there, and whether its values are those of a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.cli.device import Address, connected

if TYPE_CHECKING:
    import numpy as np

    from frictionloop.device.device import Device

ARGUMENTS = "ADDRESS [FILE] [--json]"
EXAMPLES = """Examples

  frictionloop device info sim:
  frictionloop device info serial:///dev/ttyACM0 my-controller.toml
  frictionloop device info emulated:my-image my-controller.toml
  frictionloop device info serial:///dev/ttyACM0 --json
"""
NAMED = 3
"""Parameters that differ are named up to so many; --json has them all."""
Compared = Annotated[
    Path | None,
    Parameter(name="FILE", help="Say whether the values are those of this system (.toml).", group=flags.SYSTEM),
]


def command(address: Address, file: Compared = None, /, *, json: flags.Json = False) -> None:
    """Say who answers at an address, what runs there, with which values, and what it has counted since reset."""
    wanted = _words_of(file) if file is not None else None
    with connected(address) as device:
        found, counted, parameters = device.info, device.statistics(), device.parameters
        laws, words = _laws(device), parameters.words()
        clamp = float(parameters["law.low_n"]), float(parameters["law.high_n"])
        ceiling = float(parameters["drive.ceiling_um"])

    from frictionloop.firmware.values import differing, fingerprint

    others = differing(words, wanted) if wanted is not None else []
    if json:
        told = found._asdict()
        about: dict[str, Any] = {"layout": f"{told.pop('table_hash'):08x}", "values": fingerprint(words)}
        if wanted is not None:
            differ = [{"name": name, "device": there, "file": here} for name, there, here in others]
            about |= {"file": str(file), "file_values": fingerprint(wanted), "differing": differ}
        screen.show_json(told | about | {"law": laws[0], "clamp_n": clamp, "ceiling_um": ceiling} | counted)
        return
    # A board without a counter of cycles, such as a simulated one, tells 0.
    longest = f"longest {counted['longest_us']:.3g} us" if counted["longest_us"] else "longest tick not measured"
    rows = [
        ("board", f"{found.board}, serial number {found.serial}" if found.serial else found.board),
        ("firmware", f"{found.revision}, protocol {found.version}, {found.tick_hz} ticks a second"),
        ("layout", f"{found.table_hash:08x}, as here"),  # of another one no value can be read
        ("values", fingerprint(words) + _against(file, wanted, others)),
        ("law", f"{' or '.join(laws)}, {clamp[0]:.3g} to {clamp[1]:.3g} N, at most {ceiling:.3g} um"),
        ("built in", ", ".join(map(_also_runs, found.laws))),
        ("last reset", found.reset.replace("_", " ")),
        ("ticks", f"{counted['ticks']:,.0f}, {counted['overruns']:,.0f} late, {longest}"),
        ("frames", f"{counted['frames']:,.0f} whole, {counted['broken']:,.0f} broken, {counted['missed']:,.0f} missed"),
        ("telemetry", f"{counted['dropped']:,.0f} samples dropped"),
    ]
    screen.show(screen.columns(rows))
    if others:
        screen.show("", f"Not as in {file}:", *_differences(others))


def _words_of(file: Path) -> np.ndarray:
    from frictionloop.firmware.parameter_words import firmware_words

    return firmware_words(flags.noted(file, None, None)[0])


def _against(file: Path | None, wanted: np.ndarray | None, others: list[tuple[str, str, str]]) -> str:
    """Return what to say of a device's values beside those of a file."""
    from frictionloop.firmware.values import fingerprint

    if wanted is None:
        return ""
    return f", NOT those of {file}: {fingerprint(wanted)}" if others else f", those of {file}"


def _differences(others: list[tuple[str, str, str]]) -> list[str]:
    """Return the first numbers that differ as lines, and how many more there are."""
    rows = [(f"  {name}", f"{there} on the device, {here} in the file") for name, there, here in others[:NAMED]]
    more = len(others) - NAMED
    return [screen.columns(rows), *([f"  and {more} more: --json has them all"] if more > 0 else [])]


def _laws(device: Device) -> list[str]:
    """Return the kind of controller that was set where that is known, else the kinds that its law's number is of."""
    from frictionloop.control.laws import LAWS, NUMBERED

    if device.system is not None:
        return [device.system.controller.kind]
    number = device.info.law
    runs = NUMBERED[number - 1].kind if 0 < number <= len(NUMBERED) else "none"
    return [runs, *(kind for kind, law in LAWS.items() if law.kind == runs and kind != runs)]


def _also_runs(kind: str) -> str:
    """Return a law that is built in, with the kinds of controllers that run as it under another name."""
    from frictionloop.control.laws import LAWS

    others = [other for other, law in LAWS.items() if law.kind == kind != other]
    return f"{kind} (also runs {', '.join(others)})" if others else kind
