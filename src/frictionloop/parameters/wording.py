"""What a System accepts, and the one line that says what is wrong with what was given."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from frictionloop.quantities import unit_of

Model = type[BaseModel]
LONGEST = 200
"""Characters of a value that an error shows."""
RMS = "noise_rms_n"
"""A noise that one sensor has as an rms value, and another as a density."""


def kinds_of(system: Model, block: str, kind: str | None = None) -> list[Model]:
    """Return the parameter classes a block of the System may be, of the kind given if there is one."""
    registry = registry_of(system, block)
    if registry:
        return [registry[each] for each in registry.names if kind in (None, each)]
    only = system.model_fields[block].annotation
    return [only] if isinstance(only, type) and issubclass(only, BaseModel) else []


def registry_of(system: Model, block: str) -> Any:
    """Return the registry of the kinds that a block may be (`kinds.Kinds`), None for a block of one kind."""
    return next((each for each in system.model_fields[block].metadata if hasattr(each, "accepted")), None)


def known_names(system: Model, tree: Mapping[str, Any]) -> list[str]:
    """Return the paths that the kinds named in a tree accept."""
    names: list[str] = []
    for block in system.model_fields:
        given = tree.get(block)
        kind = given.get("kind") if isinstance(given, Mapping) else None
        models = kinds_of(system, block, kind)
        names += [] if models or registry_of(system, block) else [block]
        for model in models:
            names += _fields(model, f"{block}.")
    return list(dict.fromkeys(names))


def _fields(model: Model, prefix: str) -> list[str]:
    found: list[str] = []
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            found += _fields(inner, f"{prefix}{name}.")
        else:
            found.append(prefix + name)
    return found


def unknown(path: str, names: list[str], system: Model) -> str:
    """Return the line that says a path does not exist, and which near ones do or which kind of the block has it."""
    leaves = {name: name.rsplit(".", 1)[-1] for name in names}
    # A path as short as this one may have been meant as a block.
    depth = path.count(".") + 1
    blocks = {".".join(name.split(".")[:depth]) for name in names if name.count(".") >= depth}
    near = difflib.get_close_matches(path, [*names, *sorted(blocks)], n=3, cutoff=0.6)
    leaf = path.rsplit(".", 1)[-1]
    near += [name for name in names if leaves[name] in difflib.get_close_matches(leaf, [leaves[name]], cutoff=0.6)]
    if not near:
        near = [name for name in names if name.startswith(path.split(".", 1)[0] + ".")] or names
    hints = [f"{name} ({unit_of(name)})" if unit_of(name) else name for name in dict.fromkeys(near)]
    kinds = _kinds_with(system, path)
    kind = f"{path.partition('.')[0]}.kind"
    there = f" {kind} = {' or '.join(kinds)} has it: give that too, as --{kind} {kinds[0]}" if kinds else ""
    return f"unknown parameter {path!r}; did you mean {', '.join(hints[:3])}?{there}"


def density_of(path: str, value: Any, tree: Mapping[str, Any]) -> str:
    """Return the noise density that an rms value given to a suspended sensor stands for, in a line; often nothing.

    The noise is white in front of one pole, so density = rms / sqrt(pi/2 cutoff_hz), as in ``SuspendedSensor``.
    """
    block, _, name = path.rpartition(".")
    sensor = tree.get(block)
    if name != RMS or not isinstance(sensor, Mapping) or sensor.get("kind") != "suspended":
        return ""
    try:
        rms, cutoff_hz = float(value), float(sensor["cutoff_hz"])
        density = rms / math.sqrt(math.pi / 2.0 * cutoff_hz)
    except (KeyError, TypeError, ValueError, ZeroDivisionError):
        return ""
    return (
        f"unknown parameter {path!r}: a suspended sensor has a density, rms / sqrt(pi/2 cutoff_hz); "
        f"{rms:g} N rms behind {cutoff_hz:g} Hz is {block}.noise_density_n_rthz = {density:.4g}"
    )


def _kinds_with(system: Model, path: str) -> list[str]:
    """Return the kinds of a block that have a field which is missing."""
    block, dot, name = path.partition(".")
    registry = registry_of(system, block) if dot and block in system.model_fields else None
    return [kind for kind in registry.names if name in _fields(registry[kind], "")] if registry else []


def explain(system: Model, error: ValidationError, tree: Mapping[str, Any]) -> str:
    """Return the complaint of pydantic that helps most as one line: path, value, and what would be accepted."""
    errors = error.errors(include_url=False)
    # A misspelt name is often why another is missing.
    first = next((each for each in errors if each["type"] == "extra_forbidden"), errors[0])
    path = ".".join(map(str, first["loc"]))
    if first["type"] == "extra_forbidden":
        block = path.rsplit(".", 1)[0] if "." in path else ""
        if density := density_of(path, first["input"], tree):
            return density
        return unknown(path, [name for name in known_names(system, tree) if name.startswith(block)], system)
    if first["type"] == "missing":
        whole = path in system.model_fields and bool(kinds_of(system, path))
        hint = '; with preset = "paper" a file needs only what differs' if whole else ""
        return f"{path or 'system'} is missing{hint}"
    if first["type"] in ("model_type", "dict_type"):
        return f"{path} = {_shown(first['input'])}: must be a table of values"
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    message = message.removesuffix(", unable to parse string as a number")
    message = message.replace("a valid tuple", "a list, such as [0.4, 0.8]")
    if isinstance(first["input"], (dict, BaseModel)):
        return f"{path}: {message}" if path else message
    unit = f" {unit_of(path)}" if unit_of(path) else ""
    return f"{path} = {_shown(first['input'])}{unit}: {message}"


def _shown(value: Any) -> str:
    if hasattr(value, "shape"):
        return f"an array of shape {value.shape}"
    given = " ".join(repr(value).split())
    return given if len(given) <= LONGEST else given[:LONGEST] + " ..."
