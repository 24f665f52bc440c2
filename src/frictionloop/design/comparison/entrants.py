"""Who competes: each control law with the parameters that it is given on a bench.

Of the three devices that fingers meet, one has the bench's resonance and two are 5 % off; every law believes the
bench's, and has to bear what is there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any

from frictionloop.analysis.levels import at_levels
from frictionloop.design.operating_grid import with_longest_contact
from frictionloop.design.pi_synthesis import retune
from frictionloop.parameters import RETUNED, PiController, SuspendedSensor, System, bench
from frictionloop.parameters.controller import CONTROLLERS, Timing
from frictionloop.quantities import check_each_once, check_known

if TYPE_CHECKING:
    from frictionloop.design.requirements import Requirements

Overrides = Mapping[str, Any]
Entrant = Callable[[System], Overrides]
"""From a bench to overrides of its controller. It may tune on fingers of `protocol.TUNING_SEED`, never on others."""


def printed_pi(system: System) -> Overrides:
    """Return the gains of the paper, Sec. 2.3."""
    printed = PiController()
    return {"controller.kind": "pi", "controller.kp": printed.kp, "controller.ki": printed.ki}


def retuned_pi(system: System) -> Overrides:
    """Return the gains of `RETUNED` on the bench they were made for, on another those that `retune` finds."""
    own = {path: value for path, value in RETUNED.items() if path.startswith("controller.")}
    plain = system.evolve(printed_pi(system))
    if plain == bench():
        return {"controller.kind": "pi", **own}
    return {"controller.kind": "pi", **retune(plain).overrides}


def designed(law: str, asked: Requirements | None = None) -> Entrant:
    """Return the entrant of a law in `SYNTHESES`, designed as `fl.design.controller` does unless asked otherwise."""

    def entrant(system: System) -> Overrides:
        from frictionloop.design.requirements import Requirements
        from frictionloop.design.synthesis import synthesised

        return synthesised(with_longest_contact(at_levels(system), ()), law, asked or Requirements())[0].overrides

    return entrant


DESIGN_S = {"notch_pi": 3.0, "limit_observer": 40.0, "hinf": 8.0}
"""Time of a synthesis in s (measured once)."""
DESIGNED = {law: designed(law) for law in DESIGN_S}
"""Those whose synthesis takes a while."""
ENTRANTS: dict[str, Entrant] = {
    "lookup": lambda system: {"controller.kind": "lookup"},
    "printed_pi": printed_pi,
    "retuned_pi": retuned_pi,
    **DESIGNED,
}
"""Every entrant by name; one more is one more line."""


def entrants(names: Iterable[str] | Mapping[str, Entrant] | None = None) -> dict[str, Entrant]:
    """Return entrants by name in the order asked for, all of them if None, a mapping as it is.

    Raises
    ------
    FrictionloopError
        For a name that no entrant has, with near ones, one given twice, or no name at all.
    """
    if isinstance(names, Mapping) and names:
        return dict(names)
    known = ENTRANTS | {kind: _from_outside(kind) for kind in sorted(CONTROLLERS.outside)}
    asked = list(known if names is None else names)
    check_known("laws", asked, known)
    check_each_once("laws", "law", asked)
    return {name: known[name] for name in asked}


def _from_outside(kind: str) -> Entrant:
    """Return a law from outside the package (`fl.register`) with the defaults of its own parameters."""
    fields = CONTROLLERS[kind].model_fields
    own = {name: field.get_default(call_default_factory=True) for name, field in fields.items()}
    gains = {f"controller.{name}": value for name, value in own.items() if name not in Timing.model_fields}
    return lambda system: {"controller.kind": kind} | gains


def on_device(system: System, factor: float) -> System:
    """Return a system whose sensor has its resonance times a factor; one without a resonance is as it was."""
    if not isinstance(system.sensor, SuspendedSensor):
        return system
    return system.evolve({"sensor.resonance_hz": factor * system.sensor.resonance_hz})
