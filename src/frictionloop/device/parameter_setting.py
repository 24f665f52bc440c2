"""Parameters of a device by name, gains among them, as long as they hold."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from frictionloop.device.board_discovery import opened
from frictionloop.findings import Finding, Result
from frictionloop.findings.result import Row
from frictionloop.findings.shown import shown
from frictionloop.quantities import FrictionloopError, unit_of

if TYPE_CHECKING:
    from frictionloop.device.device import Device
    from frictionloop.parameters import System

OFF = 0.1
"""Share by which the resonance of the sensor may be off where gains are said to hold."""
LAW = "controller."


class Configured(Result, schema="device.set/1"):
    """Parameters in force before and after."""

    system: System | None
    """The whole table was set from it."""
    before: Mapping[str, Any]
    after: Mapping[str, Any]
    units: Mapping[str, str]

    def rows(self) -> list[Row]:
        """Return each parameter with both values."""
        whole = [("table", "set")] if self.system is not None else []
        pairs = [(name, f"{_shown(self.before[name])} -> {_shown(value)}") for name, value in self.after.items()]
        return [*whole, *((name, f"{said} {self.units[name]}".rstrip()) for name, said in pairs)]


def configure(
    where: str | Device,
    values: Mapping[str, Any] | None = None,
    system: System | None = None,
    *,
    unchecked: bool = False,
) -> Configured:
    """Set parameters of a device, all at once; if one is wrong, none is. A reset forgets them.

    Parameters
    ----------
    where
        Address as of `connect`, or a Device.
    values
        By name: of the table, such as ``drive.ceiling_um``, or of the controller, such as ``controller.kp``.
    system
        The whole table is set from it, and the values on top. Without it a board tells the gains of law pi alone.
    unchecked
        Set gains too that by linear analysis are unstable.

    Raises
    ------
    FrictionloopError
        For a name or value that is not accepted, gains that ring, or while another host's loop is on.
    """
    own = dict(values or {})
    tuned = {name: value for name, value in own.items() if name.startswith(LAW)}
    own = {name: value for name, value in own.items() if name not in tuned}
    if short := own.keys() & {"kp", "ki"}:
        names, meant = ", ".join(sorted(short)), " and ".join(f"{LAW}{name}" for name in sorted(short))
        raise FrictionloopError(f"parameter: {names!r} is unknown; did you mean {meant}?", "UNKNOWN-NAME")
    from frictionloop.device.parameter_table import table_for

    found: list[Finding] = []
    with opened(where) as device:
        before = {name: device.parameters[name] for name in own}
        base, described = system or device.system, system
        if tuned:
            before = _read(base.controller if base else device.controller, tuned) | before
        if tuned and base:
            described = base.evolve(tuned)
            found = [] if unchecked else [*_held(described, tuned)]
        elif tuned:
            for name, value in tuned.items():
                device.set(name, value)
            found = [Finding("NOT-CHECKED", value=device.address, remedy="--system FILE")]
        if described is not None:
            device.parameters.write(table_for(described, device.info))
        for name, value in own.items():
            device.set(name, value)
        device.commit()
        after = _read(described.controller if described and tuned else device.controller, tuned) if tuned else {}
        after |= {name: device.parameters[name] for name in own}
        units = {name: unit_of(name).replace("N/N", "") for name in tuned} | {
            name: device.parameters.about(name).unit for name in own
        }
    return Configured(system=system, before=before, after=after, units=units, findings=tuple(found))


def _shown(value: Any) -> str:
    if isinstance(value, (bool, int, float, str)):
        return shown(value, 6)
    return ", ".join(f"{each:.6g}" for each in value) if len(value) <= 3 else f"{len(value)} numbers"


def _read(controller: Any, names: Mapping[str, Any]) -> dict[str, Any]:
    return {name: attrgetter(name.removeprefix(LAW))(controller) for name in names}


def _held(system: System, tuned: Mapping[str, Any]) -> Iterator[Finding]:
    """Yield that a loop is close to unstable; refuse an unstable one, with the resonance up to `OFF` off too."""
    from frictionloop.analysis.stability import rings_if_linear

    for off in (0.0, -OFF, OFF):
        each = rings_if_linear(system, off)
        if each is None:
            continue
        if not each.stable:
            gains = " ".join(f"{name}={shown(value)}" for name, value in tuned.items())
            raise FrictionloopError(f"{gains}: {each.finding}; accepted with --unchecked", "LOOP-UNSTABLE")
        if each.finding is not None and not off:
            yield each.finding
