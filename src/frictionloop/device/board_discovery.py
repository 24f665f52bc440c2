"""Boards: where one may be, who answers, what runs there and what it reads, and its fault cleared."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, NamedTuple

from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.quantities import must_be
from frictionloop.quantities.optional_libraries import all_needed

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

    from frictionloop.device.device import Device
    from frictionloop.parameters import System


NEEDED = {"sim": ("cffi",), "emulated": ("elftools", "unicorn", "intelhex")}
"""Modules that an address takes beside those of the line."""


@contextmanager
def opened(where: str | Device, system: System | None = None, seed: int = 0) -> Iterator[Device]:
    """Yield the device at an address, as `connect` does; one that is connected already as it is, to stay so."""
    if not isinstance(where, str):
        yield where
        return
    scheme = where.partition(":")[0]
    all_needed("cobs", "fastcrc", *NEEDED.get(scheme, ()))
    from frictionloop.device.transport import opener

    opening = opener(where, system, seed)
    # A line that is not there is refused before what drives a device is loaded.
    first = [] if scheme in NEEDED else [opening()]
    from frictionloop.device.device import Device

    with Device(lambda: first.pop() if first else opening(), where) as found:
        yield found


class Port(NamedTuple):
    """A place that `connect` takes."""

    address: str
    what: str


SIMULATED = Port("sim:", "the firmware here, with a simulated bench")


class Ports(Result, schema="device.list/1"):
    """Where a board may be."""

    ports: tuple[Port, ...]
    """The serial ports first, the simulated board last."""

    def rows(self) -> list[Row]:
        """Return each address."""
        none = [("serial:", "no port; is the board plugged in?")] if len(self.ports) == 1 else []
        return [*none, *self.ports]


def list_ports() -> Ports:
    """Return the serial ports of this machine and the simulated board, by the address that `connect` takes."""
    from frictionloop.device import transport

    return Ports(ports=(*(Port(*each) for each in transport.described_ports()), SIMULATED))


MOST_HZ = 100.0


class Reading(NamedTuple):
    """A sample of a device."""

    time_s: float
    """By its ticks."""
    f_r_n: float
    f_m_n: float
    u_n: float
    a_um: float
    position_mm: float
    speed_mm_s: float
    load_n: float
    state: str
    """idle, open or closed; at a fault its name."""


def monitor(where: str | Device, duration_s: float = 10.0, rate_hz: float = 10.0) -> Iterator[Reading]:
    """Yield readings of a device as they come, at most 100 a second.

    Raises
    ------
    FrictionloopError
        For a rate or duration out of range, and as `connect`.
    """
    if not 0 < rate_hz <= MOST_HZ:
        raise must_be("rate_hz", rate_hz, f"above 0, at most {MOST_HZ:g}", "Hz")
    if not 0 < duration_s < math.inf:
        raise must_be("duration_s", duration_s, "above 0 and finite", "s")
    with opened(where) as device:
        from frictionloop.device.errors import fault_name
        from frictionloop.device.recording import fault_of, state_of
        from frictionloop.quantities.protocol_schema import named

        states, tick_hz = named("states"), device.info.tick_hz
        for block in device.stream(duration_s, max(round(tick_hz / rate_hz), 1)):
            faults, modes = fault_of(block["flags"]), state_of(block["flags"])
            for k, tick in enumerate(block["tick"]):
                fault, state = fault_name(int(faults[k])), str(states[int(modes[k])])
                yield Reading(
                    tick / tick_hz,
                    float(block["f_r"][k]),
                    float(block["f_m"][k]),
                    float(block["u"][k]),
                    float(block["a"][k]),
                    1e3 * float(block["position"][k]),
                    1e3 * float(block["speed"][k]),
                    float(block["load"][k]),
                    (state if fault == "none" else fault).replace("_", " "),
                )


LISTEN_S, DECIMATION = 0.1, 50
"""Ten samples of telemetry: the last one tells the fault that is in force."""


class Cleared(Result, schema="device.clear/1"):
    """What was cleared."""

    fault: str | None
    """None if there was none."""

    def rows(self) -> list[Row]:
        """Return the fault."""
        return [("cleared", self.fault or "no fault")]


def clear(where: str | Device) -> Cleared:
    """Clear the fault of a device, at an address or connected already.

    Raises
    ------
    FrictionloopError
        While its cause lasts, with the fault's code, and for a device that sends no samples.
    """
    from frictionloop.device.errors import DeviceError, Refused, fault_error, fault_name
    from frictionloop.device.recording import fault_of

    with opened(where) as device:
        numbers = [int(fault_of(block["flags"])[-1]) for block in device.stream(LISTEN_S, DECIMATION)]
        if not numbers:
            raise DeviceError(f"{device.address}: sends no samples")
        try:
            device.clear()
        except Refused as refused:
            if refused.reason != "still_at_fault":
                raise
            raise fault_error(numbers[-1], "lasts") from None
    name = fault_name(numbers[-1])
    return Cleared(fault=None if name == "none" else name)


NAMED = 3
"""Numbers that differ are named up to so many; the table has them all."""


class Differing(NamedTuple):
    """A number that a device and a system have otherwise, with its unit."""

    name: str
    device: str
    system: str


class DeviceInfo(Result, schema="device.info/1"):
    """What a device tells of itself."""

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
    from frictionloop.control.lookup import LOOKUP_LAW
    from frictionloop.firmware.parameter_files import differing, fingerprint

    counts["longest_us"] = counts["longest_us"] or math.nan  # of a board without a counter
    others = tuple(Differing(*each) for each in differing(words, wanted)) if wanted is not None else ()
    has = dict.fromkeys((LOOKUP_LAW.kind, found.law))
    runs = {kind: tuple(each for each, law in LAWS.items() if law.kind == kind != each) for kind in has}
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
    """Return the kind of controller that was set where that is known, else the kinds that its law is of."""
    from frictionloop.control.laws import LAWS
    from frictionloop.device.parameter_table import law_in_force

    if device.system is not None:
        return [device.system.controller.kind]
    runs = law_in_force(device.parameters, device.info)
    return [runs, *(kind for kind, law in LAWS.items() if law.kind == runs and kind != runs)]
