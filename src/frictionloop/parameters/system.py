"""System: the whole loop as one frozen value, changed only by ``evolve``."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ValidationError, model_validator

from frictionloop.parameters.block import Block
from frictionloop.parameters.controller import Controller
from frictionloop.parameters.plant import Friction, Plate, Sensor
from frictionloop.parameters.sources import Source
from frictionloop.quantities import FrictionloopError, unit_of

_STEEPEST = 700.0
"""Largest tau a_max^2: g(a_max) = f0 e^-700 is still a normal number."""


class System(Block):
    """A closed friction loop: signals, plant and controller (paper, Fig. 1b)."""

    setpoint: Source
    """Set-point force f_r over time."""
    disturbance: Source
    """Disturbance d added to the friction force."""
    friction: Friction
    """How friction falls with vibration."""
    plate: Plate
    """How the amplitude follows its command."""
    sensor: Sensor
    """How the force is measured."""
    controller: Controller
    """How the amplitude command is computed."""

    @model_validator(mode="after")
    def _some_friction_is_left(self) -> Self:
        fall = self.friction.susceptibility_per_um2 * (self.plate.max_amplitude_um * self.plate.max_amplitude_um)
        if not fall <= _STEEPEST:
            raise ValueError(
                f"friction.susceptibility_per_um2 * plate.max_amplitude_um^2 = {fall:g}: must be at most {_STEEPEST:g}"
            )
        return self

    def evolve(self, overrides: Mapping[str, Any]) -> Self:
        """Return a copy with some values replaced.

        ``overrides`` maps dotted paths to values: ``{"controller.kp": 20.0}``. A whole block may be given as a
        mapping or a block, ``{"setpoint": fl.Sine(offset_n=0.6)}``; a new ``kind`` keeps the values that the
        new kind also has. An unknown path or a value outside its range raises ``FrictionloopError``.
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
            raise FrictionloopError(where + explain(error, tree)) from None

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
    if not isinstance(node, dict) or (leaf not in node and path not in _known_names(tree)):
        raise FrictionloopError(unknown(path, _known_names(tree)))
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


def kinds_of(block: str) -> list[type[Block]]:
    """Return the parameter classes a block of the System may be."""
    annotation = System.model_fields[block].annotation
    return list(getattr(annotation, "__args__", (annotation,)))


def unknown(path: str, names: list[str]) -> str:
    """Return the line that says a path does not exist and which near ones do."""
    leaves = {name: name.rsplit(".", 1)[-1] for name in names}
    near = difflib.get_close_matches(path, names, n=3, cutoff=0.6)
    leaf = path.rsplit(".", 1)[-1]
    near += [name for name in names if leaves[name] in difflib.get_close_matches(leaf, [leaves[name]], cutoff=0.6)]
    if not near:
        near = [name for name in names if name.startswith(path.split(".", 1)[0] + ".")] or names
    hints = [f"{name} ({unit_of(name)})" if unit_of(name) else name for name in dict.fromkeys(near)]
    return f"unknown parameter {path!r}; did you mean {', '.join(hints[:3])}?"


def explain(error: ValidationError, tree: Mapping[str, Any]) -> str:
    """Return pydantic's first complaint as one line: path, value, and what would be accepted."""
    first = error.errors(include_url=False)[0]
    kinds = {
        model.model_fields["kind"].default
        for b in System.model_fields
        for model in kinds_of(b)
        if "kind" in model.model_fields
    }
    path = ".".join(str(part) for part in first["loc"] if part not in kinds)
    if first["type"] == "extra_forbidden":
        block = path.rsplit(".", 1)[0] if "." in path else ""
        names = [name for name in _known_names(tree) if name.startswith(block)]
        return unknown(path, names)
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    if first["type"] == "missing":
        return f"{path or 'system'} is missing"
    if isinstance(first["input"], (dict, BaseModel)):
        return f"{path or 'system'}: {message}"
    unit = f" {unit_of(path)}" if unit_of(path) else ""
    return f"{path} = {first['input']!r}{unit}: {message}"


def _known_names(tree: Mapping[str, Any]) -> list[str]:
    """Return the paths that the kinds named in a tree accept."""
    names: list[str] = []
    for block in System.model_fields:
        given = tree.get(block)
        kind = given.get("kind") if isinstance(given, Mapping) else None
        for model in kinds_of(block):
            if kind is None or model.model_fields["kind"].default == kind:
                names += _fields(model, f"{block}.")
    return list(dict.fromkeys(names))


def _fields(model: type[BaseModel], prefix: str) -> list[str]:
    found: list[str] = []
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            found += _fields(inner, f"{prefix}{name}.")
        else:
            found.append(prefix + name)
    return found
