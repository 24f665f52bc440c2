"""What a System accepts, and the one line that says what is wrong with what was given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from frictionloop.parameters import unknown
from frictionloop.parameters.usual import meant_instead
from frictionloop.quantities import unit_of

Model = type[BaseModel]
LONGEST = 200
"""Characters of a value that an error shows."""


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
            names += fields_of(model, f"{block}.")
    return list(dict.fromkeys(names))


def fields_of(model: Model, prefix: str = "") -> list[str]:
    """Return the names of a class's values, also of those in a block within it, each behind a prefix."""
    found: list[str] = []
    for name, field in model.model_fields.items():
        inner = field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel):
            found += fields_of(inner, f"{prefix}{name}.")
        else:
            found.append(prefix + name)
    return found


def explain(system: Model, error: ValidationError, tree: Mapping[str, Any]) -> str:
    """Return the complaint of pydantic that helps most as one line: path, value, and what would be accepted."""
    errors = error.errors(include_url=False)
    # A misspelt name is often why another is missing.
    strangers = {".".join(map(str, each["loc"])): each["input"] for each in errors if each["type"] == "extra_forbidden"}
    if strangers:
        return unknown.refusal(strangers, system, tree)
    first = errors[0]
    path = ".".join(map(str, first["loc"]))
    if first["type"] == "missing":
        whole = path in system.model_fields and bool(kinds_of(system, path))
        hint = '; preset = "paper" completes a file' if whole else ""
        return f"{path or 'system'} is missing{hint}"
    if first["type"] in ("model_type", "dict_type"):
        return f"{path} = {_shown(first['input'])}: must be a table of values"
    message = first["msg"].removeprefix("Value error, ").replace("Input should be", "must be")
    message = message.removesuffix(", unable to parse string as a number")
    message = message.replace("a valid tuple", "a list, such as [0.4, 0.8]")
    if isinstance(first["input"], (dict, BaseModel)):
        return f"{path}: {message}" if path else message
    unit = f" {unit_of(path)}" if unit_of(path) else ""
    if isinstance(first["input"], (list, tuple)) and first["type"] == "float_type":
        message += "; several values: sweep --over"
        message += ", design controller --speeds 30,100" if path.endswith("speed_mm_s") else ""
    return f"{path} = {_shown(first['input'])}{unit}: {message}{meant_instead(path, first['input'])}"


def _shown(value: Any) -> str:
    if hasattr(value, "shape"):
        return f"an array of shape {value.shape}"
    given = " ".join(repr(value).split())
    return given if len(given) <= LONGEST else given[:LONGEST] + " ..."
