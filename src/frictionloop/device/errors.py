"""What can go wrong with a device that the caller may want to tell apart, and the faults of the firmware.

Each fault has a code of the catalogue, FAULT- and its name.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from frictionloop.findings import CATALOGUE, Finding
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.protocol_schema import named, schema

if TYPE_CHECKING:
    from frictionloop.device.codec import Message


class DeviceError(FrictionloopError):
    """A device that cannot be reached or does not do what it was asked for."""

    def __init__(self, said: str = "", code: str = "DEVICE-LOST") -> None:
        super().__init__(said, code)


class Unplugged(DeviceError):
    """The line is gone."""


class NoReply(DeviceError):
    """The line is there and the device says nothing."""


class Refused(DeviceError):
    """The device answered with a refusal: `reason` by name, `index` the word or point that is wrong, or None."""

    def __init__(self, words: str, reason: str, index: int | None) -> None:
        super().__init__(words, "DEVICE-REFUSED")
        self.reason, self.index = reason, index


FAULTS = named("faults")
"""Names by number."""
READINGS: dict[str, str] = schema()["fault_values"]
"""What a fault tells of its cause: the unit."""
UNKNOWN = "DEVICE-LOST"
"""Of a fault that this version does not know."""


def fault_name(number: int) -> str:
    """Return the name of a fault, of an unknown one its number."""
    return str(FAULTS.get(number, number))


def fault_code(number: int) -> str:
    """Return the code of a fault."""
    code = f"FAULT-{fault_name(number).upper().replace('_', '-')}"
    return code if code in CATALOGUE else UNKNOWN


def fault_line(number: int, reading: str = "", where: str = "") -> str:
    """Return a fault in one line: its name, where, what it is, and what the board read."""
    code, name = fault_code(number), " ".join(filter(None, (fault_name(number), where)))
    what = Finding(code, more={"reading": reading}) if code != UNKNOWN else ""
    return f"{name}: {what}".rstrip(": ")


def fault_error(number: int, where: str, reading: str = "") -> DeviceError:
    """Return the error of a device that stopped with a fault."""
    return DeviceError(f"fault {fault_line(number, reading, where)}", fault_code(number))


def reading_of(fault: Message) -> str:
    """Return what a message `fault` tells of its cause; an empty text where it tells none."""
    name = FAULTS.get(fault["fault"])
    if name not in READINGS:
        return ""
    unit, value = READINGS[name], fault["value"]
    return f"{value:.0f} {unit}" if abs(value) >= 1000.0 else f"{value:.3g} {unit}"
