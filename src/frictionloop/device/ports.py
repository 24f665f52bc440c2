"""Where a board may be: the serial ports of this machine, and the simulated board."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

from frictionloop.findings import Result
from frictionloop.findings.result import Row


class Port(NamedTuple):
    """A place that `connect` takes."""

    address: str
    what: str


SIMULATED = Port("sim:", "the firmware here, with a simulated bench")


@dataclass(frozen=True, kw_only=True)
class Ports(Result):
    """Where a board may be."""

    SCHEMA: ClassVar[str] = "device.list/1"
    ports: tuple[Port, ...]
    """The serial ports first, the simulated board last."""

    def rows(self) -> list[Row]:
        """Return each address."""
        none = [("serial:", "no port; is the board plugged in?")] if len(self.ports) == 1 else []
        return [*none, *self.ports]


def list_ports() -> Ports:
    """Return the serial ports of this machine and the simulated board, by the address that `connect` takes."""
    from frictionloop.device import serial_pipe

    return Ports(ports=(*(Port(*each) for each in serial_pipe.described_ports()), SIMULATED))
