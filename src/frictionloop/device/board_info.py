"""Who answers at an address, what runs there, and whether its values are those of a system."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, NamedTuple

from frictionloop.device.addressed import opened
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

    from frictionloop.device.device import Device
    from frictionloop.parameters import System

NAMED = 3
"""Numbers that differ are named up to so many; the table has them all."""


class Differing(NamedTuple):
    """A number that a device and a system have otherwise, with its unit."""

    name: str
    device: str
    system: str


@dataclass(frozen=True, kw_only=True)
class DeviceInfo(Result):
    """What a device tells of itself."""

    SCHEMA: ClassVar[str] = "device.info/1"
    board: str
    serial: int
    """0 where it has none."""
    revision: str
    """Version of the firmware, and after ``+`` the check sum of its sources."""
    protocol: str
    tick_hz: int
    law: str
    """Kind of the controller where it is known, else that of the law that runs."""
    also_law: tuple[str, ...]
    """Other kinds that run as the same law."""
    clamp_n: tuple[float, float]
    ceiling_um: float
    laws: Mapping[str, tuple[str, ...]]
    """Laws that are built in, with the other kinds that run as each."""
    waveform: int
    """Points of a set-point table at most."""
    reset: str
    """What its last reset came from."""
    layout: str
    """Of the parameter table."""
    values: str
    """Fingerprint of the values in force."""
    system_values: str | None
    """That of the system it is compared with."""
    differing: tuple[Differing, ...]
    counts: Mapping[str, float]
    """Since reset: ticks, overruns, frames whole, broken and missed, samples dropped; longest tick in us or NaN."""

    def rows(self) -> list[Row]:
        """Return who answers, and what runs there."""
        (low, high), laws = self.clamp_n, " or ".join((self.law, *self.also_law))
        same = {None: "", self.values: ", as the file's"}.get(self.system_values, f", the file's {self.system_values}")
        also = [f"{name} (runs {', '.join(more)})" if more else name for name, more in self.laws.items()]
        slowest_us = self.counts["longest_us"]
        longest = "" if math.isnan(slowest_us) else f", longest {slowest_us:.3g} us"
        return [
            ("board", f"{self.board}, serial number {self.serial}" if self.serial else self.board),
            ("law", f"{laws}, {low:.3g} to {high:.3g} N, up to {self.ceiling_um:.3g} um"),
            ("values", self.values + same),
            ("firmware", f"{self.revision}, protocol {self.protocol}, {self.tick_hz} Hz, layout {self.layout}"),
            ("built in", ", ".join(also)),
            ("last reset", f"{self.reset}, {self.counts['ticks']:,.0f} ticks ago{longest}"),
        ]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the numbers that differ, and what was counted."""
        import pandas as pd

        counts = pd.DataFrame({"since reset": dict(self.counts)}).rename_axis("count")
        differ = pd.DataFrame(self.differing, columns=["name", "device", "file"]).set_index("name")
        return {"counts": counts, **({"differing": differ} if self.differing else {})}


def info(where: str | Device, system: System | None = None) -> DeviceInfo:
    """Return who answers at an address, with which values, and what it has counted since reset.

    Parameters
    ----------
    where
        Address as of `connect`, or a Device.
    system
        What its values are compared with.

    Raises
    ------
    FrictionloopError
        As `connect`; of a system that the firmware cannot run.
    """
    wanted = None
    if system is not None:
        from frictionloop.firmware.parameter_words import firmware_words

        wanted = firmware_words(system)
    with opened(where) as device:
        found, parameters = device.info, device.parameters
        counts = device.statistics()
        (law, *also), words = _laws(device), parameters.words()
        clamp = float(parameters["law.low_n"]), float(parameters["law.high_n"])
        ceiling_um = float(parameters["drive.ceiling_um"])

    from frictionloop.control.laws import LAWS
    from frictionloop.firmware.values import differing, fingerprint

    counts["longest_us"] = counts["longest_us"] or math.nan  # of a board without a counter
    others = tuple(Differing(*each) for each in differing(words, wanted)) if wanted is not None else ()
    runs = {kind: tuple(each for each, law in LAWS.items() if law.kind == kind != each) for kind in found.laws}
    return DeviceInfo(
        board=found.board,
        serial=found.serial,
        revision=found.revision,
        protocol=found.version,
        tick_hz=found.tick_hz,
        law=law,
        also_law=tuple(also),
        clamp_n=clamp,
        ceiling_um=ceiling_um,
        laws=runs,
        waveform=found.waveform,
        reset=found.reset.replace("_", " "),
        layout=f"{found.table_hash:08x}",
        values=fingerprint(words),
        system_values=None if wanted is None else fingerprint(wanted),
        differing=others,
        counts=counts,
        findings=tuple(_findings(others, len(words), counts)),
    )


def _findings(others: tuple[Differing, ...], count: int, counts: Mapping[str, float]) -> Iterator[Finding]:
    if others:
        names = ", ".join(each.name for each in others[:NAMED]) + ", ..." * (len(others) > NAMED)
        yield Finding("TABLE-DIFFERS", value=len(others), limit=count, more={"names": names})
    lost = {name: int(counts[name]) for name in ("overruns", "broken", "missed", "dropped")}
    if any(lost.values()):
        yield Finding("LINE-LOSSES", more=lost)


def _laws(device: Device) -> list[str]:
    """Return the kind of controller that was set where that is known, else the kinds that its law's number is of."""
    from frictionloop.control.laws import LAWS, NUMBERED

    if device.system is not None:
        return [device.system.controller.kind]
    number = device.info.law
    runs = NUMBERED[number - 1].kind if 0 < number <= len(NUMBERED) else "none"
    return [runs, *(kind for kind, law in LAWS.items() if law.kind == runs and kind != runs)]
