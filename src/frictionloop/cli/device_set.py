"""``frictionloop device set``: parameters of a device by name, gains among them, as long as they hold."""

from __future__ import annotations

import math
from collections.abc import Iterable
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.cli.device import SameAddress, connected
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import System

UNCHECKED = "a board does not tell its bench, so whether these gains hold is not known; --system FILE tells it"
ARGUMENTS = "ADDRESS NAME=VALUE... [--system FILE]"
EXAMPLES = """Examples

  frictionloop device set sim: controller.kp=0.05 controller.ki=100
  frictionloop device set sim: drive.ceiling_um=2 setpoint.hold_n=0.5
  frictionloop device set serial:///dev/ttyACM0 controller.kp=0.05
  frictionloop device set serial:///dev/ttyACM0 --system my-controller.toml
"""


def command(
    address: SameAddress,
    /,
    *assignments: Annotated[flags.Described[str], Parameter(name="NAME=VALUE")],
    system: flags.Described[Path | None] = None,
    unchecked: flags.Described[flags.Flag] = False,
    json: flags.Json = False,
) -> None:
    """Set parameters of a device, all at once; if one is wrong, none is. A reset forgets them.

    Refused while another host's loop is on.

    Parameters
    ----------
    assignments
        A parameter and its value: of the table, such as drive.ceiling_um=2, or of the controller, such as
        controller.kp=0.05.
    system
        Set the whole table from this system (.toml), and the values given on top. Without it a board tells the gains
        of law pi alone, and no analysis says whether new ones hold.
    unchecked
        Set gains that by analysis do not hold too.
    """
    pairs: dict[str, Any] = {}
    for name, value in map(_pair, assignments):
        if name in pairs:
            raise FrictionloopError(f"{name} = {value}: is given twice; give it once")
        pairs[name] = value
    if not pairs and system is None:
        raise FrictionloopError("set: needs NAME=VALUE or --system FILE")
    described = flags.noted(system, None, None)[0] if system is not None else None
    tuned = {name: value for name, value in pairs.items() if name.startswith("controller.")}
    own = {name: value for name, value in pairs.items() if name not in tuned}
    for name in own.keys() & {"kp", "ki"}:
        raise FrictionloopError(f"parameter {name!r}: unknown; did you mean controller.{name}?")

    from frictionloop.firmware.parameter_words import firmware_words
    from frictionloop.firmware.words import shown

    with connected(address) as device:
        before = {name: device.parameters[name] for name in own}
        after: dict[str, Any] = {}
        base = described or device.system
        if tuned:
            before = _read(base.controller if base else device.controller, tuned) | before
        if tuned and base:
            described = _holding(base.evolve(tuned), tuned, unchecked)
            after = _read(described.controller, tuned)
        elif tuned:
            for name, value in tuned.items():
                device.set(name, value)
            screen.note(f"{', '.join(tuned)}: not checked: {UNCHECKED}")
        if described is not None:
            device.parameters.write(firmware_words(described))
        for name, value in own.items():
            device.set(name, value)
        device.commit()
        if tuned and not after:
            after = _read(device.controller, tuned)
        after |= {name: device.parameters[name] for name in own}
        words = {name: device.parameters.about(name) for name in own}
    if json:
        screen.show_json({"system": str(system) if system else None, "before": before, "after": after})
        return
    rows = [("table", f"set from {system}")] if system else []
    rows += [(name, f"{before[name]} -> {after[name]}") for name in tuned]
    rows += [(name, f"{shown(word, before[name])} -> {shown(word, after[name])}") for name, word in words.items()]
    screen.show(screen.columns(rows))


def _read(controller: Any, names: Iterable[str]) -> dict[str, Any]:
    return {name: attrgetter(name.removeprefix("controller."))(controller) for name in names}


def _holding(system: System, tuned: dict[str, Any], unchecked: bool) -> System:
    """Return a system whose loop is stable by linear analysis; refuse another one with gains that hold."""
    from frictionloop.cli import describe, ringing

    if unchecked:
        return system
    found = ringing.of_system(system)
    given = " ".join(f"{name}={describe.short(value)}" for name, value in tuned.items())
    if found is None or found.stable:
        _holding_off(system, given)
    if found is None:
        return system
    near = "" if found.frequency_hz is None else f" near {found.frequency_hz:.3g} Hz"
    held = " ".join(f"{name}={gain:g}" for name, gain in found.held.items())
    instead = f"; gains that hold at {found.band.where.removeprefix(', ')}: {held}" if held else ""
    if not found.stable:
        raise FrictionloopError(f"{given}: this loop rings{near}{instead}; --unchecked sets it all the same")
    screen.note(f"{given}: this loop is close to ringing{near}{instead}")
    return system


def _holding_off(system: System, given: str) -> None:
    """Refuse a loop that rings with the resonance up to 10 % off; say at which other contact or speed it does."""
    from frictionloop.analysis.stability import NEAR
    from frictionloop.cli.ringing import OFF, points_of
    from frictionloop.design.corners import Corner
    from frictionloop.design.elsewhere import elsewhere
    from frictionloop.design.plants import shifted

    limits = {0.0: NEAR, OFF: NEAR}
    try:
        found = [
            Corner(off, most, loop, loop.sensitivity_peak()) for loop, off, most in shifted(points_of(system), limits)
        ]
    except FrictionloopError:  # what cannot be linearised is not judged
        return
    if rings := [each for each in found if math.isinf(each.sensitivity_peak)]:
        raise FrictionloopError(f"{given}: this loop rings at {rings[0].condition}; --unchecked sets it all the same")
    if places := [str(each.condition) for each in elsewhere(system, limits).places if each.how == "unstable"]:
        screen.note(f"{given}: this loop rings on {'; on '.join(places)}")


def _pair(text: str) -> tuple[str, Any]:
    name, equals, value = text.partition("=")
    if not equals or not name or not value:
        raise FrictionloopError(f"{text!r}: must be NAME=VALUE, such as drive.ceiling_um=2 or controller.kp=0.05")
    return name, flags.scalar(value)
