"""System: the whole loop as one frozen value, changed only by ``evolve``."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ValidationError, model_validator

from frictionloop.parameters import wording
from frictionloop.parameters.block import Block
from frictionloop.parameters.controller import Controller
from frictionloop.parameters.finger import AnyFriction, Finger, RigidFinger
from frictionloop.parameters.motion import Motion, Sliding
from frictionloop.parameters.plant import Plate, Sensor
from frictionloop.parameters.sources import Source
from frictionloop.parameters.touch import Touch
from frictionloop.quantities import FrictionloopError

_STEEPEST = 700.0
"""Largest tau a_max^2: g(a_max) = f0 e^-700 is still a normal number."""


class System(Block):
    """A closed friction loop: signals, plant and controller (paper, Fig. 1b)."""

    setpoint: Source
    """Set-point force f_r over time."""
    disturbance: Source
    """Disturbance d added to the friction force."""
    friction: AnyFriction
    """How friction falls with vibration, and what else it depends on."""
    plate: Plate
    """How the amplitude follows its command."""
    sensor: Sensor
    """How the force is measured."""
    controller: Controller
    """How the amplitude command is computed."""
    finger: Finger = RigidFinger()
    """The skin between friction and bone."""
    motion: Motion = Sliding()
    """How the finger moves and presses."""
    touch: Touch = Touch()
    """What is measured of the motion."""

    @model_validator(mode="after")
    def _some_friction_is_left(self) -> Self:
        fall = self.friction.susceptibility_per_um2 * (self.plate.max_amplitude_um * self.plate.max_amplitude_um)
        if not fall <= _STEEPEST:
            raise ValueError(
                f"friction.susceptibility_per_um2 * plate.max_amplitude_um^2 = {fall:g}: must be at most {_STEEPEST:g}"
            )
        return self

    @model_validator(mode="after")
    def _moves(self) -> Self:
        for block, kind in (("friction", self.friction.kind), ("finger", self.finger.kind)):
            if kind in ("finger", "skin") and self.motion.kind == "sliding":
                raise ValueError(f'{block}.kind = "{kind}" needs a speed and a load: motion.kind must be "strokes"')
        return self

    def evolve(self, overrides: Mapping[str, Any]) -> Self:
        """Return a copy with some values replaced.

        Parameters
        ----------
        overrides : mapping
            Dotted paths to values in the unit their name ends with: ``{"controller.kp": 20.0}``. A whole block may be
            given as a mapping or a block, ``{"setpoint": fl.Sine(offset_n=0.6)}``; a new ``kind`` keeps the values
            that the new kind also has.

        Raises
        ------
        FrictionloopError
            For an unknown path, naming near ones, or a value outside its range.
        """
        # Blocks that no path enters stay as they are: sweeps evolve thousands of systems.
        tree = {name: getattr(self, name) for name in type(self).model_fields}
        for block in {path.split(".", 1)[0] for path in overrides} & tree.keys():
            tree[block] = tree[block].model_dump()
        for path, value in overrides.items():
            _place(tree, path, value.model_dump() if isinstance(value, BaseModel) else value)
        return self.from_tree(tree)

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any], where: str = "") -> Self:
        """Return the System a nested mapping describes; ``where`` (a file) is named in errors."""
        try:
            return cls.model_validate(tree)
        except ValidationError as error:
            raise FrictionloopError(where + wording.explain(cls, error, tree)) from None

    def paths(self) -> list[str]:
        """Return every settable dotted path."""
        return _paths(self.model_dump())


def _paths(tree: Mapping[str, Any], prefix: str = "") -> list[str]:
    found: list[str] = []
    for name, block in tree.items():
        value = block.model_dump() if isinstance(block, BaseModel) else block
        found += _paths(value, f"{prefix}{name}.") if isinstance(value, dict) else [prefix + name]
    return found


def _place(tree: dict[str, Any], path: str, value: Any) -> None:
    *parents, leaf = path.split(".")
    node: Any = tree
    for name in parents:
        node = node.get(name) if isinstance(node, dict) else None
    # A new kind may need a value that nothing has given yet: the path of a recording.
    if not isinstance(node, dict) or (leaf not in node and path not in wording.known_names(System, tree)):
        raise FrictionloopError(wording.unknown(path, wording.known_names(System, tree)))
    if leaf == "kind" and value != node["kind"]:
        _change_kind(tree, parents[0], value)
    elif isinstance(value, Mapping) and isinstance(node.get(leaf), dict) and value.get("kind", None) is None:
        for name, inner in value.items():
            _place(tree, f"{path}.{name}", inner)
    else:
        node[leaf] = dict(value) if isinstance(value, Mapping) else value


def _change_kind(tree: dict[str, Any], block: str, kind: str) -> None:
    """Swap a block for one of another kind, keeping the values both kinds have."""
    for model in kinds_of(block):
        if model.model_fields["kind"].default == kind:
            kept = {name: value for name, value in tree[block].items() if name in model.model_fields}
            tree[block] = kept | {"kind": kind}
            for name, field in model.model_fields.items():
                if name not in kept and not field.is_required():
                    tree[block][name] = field.get_default(call_default_factory=True)
            return
    accepted = ", ".join(repr(model.model_fields["kind"].default) for model in kinds_of(block))
    raise FrictionloopError(f"{block}.kind = {kind!r} is unknown; accepted: {accepted}")


def kinds_of(block: str) -> list[type[BaseModel]]:
    """Return the parameter classes a block of the System may be."""
    return wording.kinds_of(System, block)


def check_system(system: Any) -> None:
    """Refuse what is not a System where one is needed."""
    if not isinstance(system, System):
        given = " ".join(reprlib.repr(system).split())
        raise FrictionloopError(f"system = {given}: must be a System, e.g. fl.paper()")
