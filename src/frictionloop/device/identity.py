"""Who answers at the other end."""

from __future__ import annotations

from typing import NamedTuple

from frictionloop.device.errors import DeviceError, NoReply
from frictionloop.device.link import Link
from frictionloop.firmware.built_in import law_names
from frictionloop.quantities.schema import named, schema

BOARDS, RESETS = named("boards"), named("resets")


class Info(NamedTuple):
    """What a device tells about itself."""

    board: str
    revision: str
    """Version of the firmware, and after ``+`` the checksum of its sources (`device.revision`)."""
    serial: int
    """Serial number of the board, 0 where it has none."""
    law: int
    """Number of the control law that is loaded."""
    tick_hz: int
    version: str
    """Of the protocol."""
    table_hash: int
    waveform: int
    """Points of a set-point table at most."""
    laws: tuple[str, ...]
    """Kinds of the control laws that are built in."""
    reset: str
    """What its last reset came from."""


def identified(link: Link, address: str) -> Info:
    """Return who answers.

    Raises
    ------
    DeviceError
        When nothing there speaks the protocol, or another major version of it.
    """
    try:
        told = link.ask("identify").fields
    except NoReply:
        raise NoReply(f"{address}: no answer in frictionloop's protocol", "NO-DEVICE") from None
    major = schema()["protocol"]["major"]
    if told["major"] != major:
        raise DeviceError(f"{address}: protocol {told['major']}.{told['minor']}, must be {major}.x", "NO-DEVICE")
    return Info(
        BOARDS.get(told["board"], f"board {told['board']}"),
        told["revision"].rstrip(b"\0").decode("ascii", "replace"),
        told["serial"],
        told["law"],
        told["tick_hz"],
        f"{told['major']}.{told['minor']}",
        told["table_hash"],
        told["waveform"],
        law_names(told["laws"]),
        RESETS.get(told["reset"], f"reset {told['reset']}"),
    )
