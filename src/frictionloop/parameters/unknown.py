"""What is said of names that no parameter has: all of them at once, each with those that may be meant."""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from frictionloop.parameters import wording
from frictionloop.parameters.guessed import Meant, meant


def refusal(strangers: Mapping[str, Any], system: type[BaseModel], tree: Mapping[str, Any]) -> str:
    """Return one line for a name that is unknown, a line each below a heading for several.

    Parameters
    ----------
    strangers
        The names with the values given to them.
    system
        What has no such parameters.
    tree
        Its values, with which a value is converted to that of another parameter.
    """
    believed = _believed(strangers, system, tree)
    hints = {path: _hint(path, given, system, believed) for path, given in strangers.items()}
    if len(hints) == 1:
        return "".join(f"unknown parameter {path!r}; {hint}" for path, hint in hints.items())
    return "\n".join([f"{len(hints)} unknown parameters:", *(f"  {path!r}: {hint}" for path, hint in hints.items())])


def _believed(strangers: Mapping[str, Any], system: type[BaseModel], tree: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with those that strangers alone stand for: one may be needed to convert another."""
    believed, names = _plain(tree), wording.known_names(system, tree)
    for path, given in strangers.items():
        found = meant(path, given, names, {})
        if found is not None and not (found.how and found.value is None):
            leaf = found.name.rpartition(".")[2]
            _block_of(found.name, believed)[leaf] = given if found.value is None else found.value
    return believed


def _plain(tree: Mapping[str, Any]) -> dict[str, Any]:
    blocks = {name: dict(value) if isinstance(value, BaseModel) else value for name, value in tree.items()}
    return {name: _plain(value) if isinstance(value, Mapping) else value for name, value in blocks.items()}


def _block_of(path: str, tree: dict[str, Any]) -> dict[str, Any]:
    """Return the values beside a path, none where it leads nowhere."""
    for name in path.split(".")[:-1]:
        inner = tree.get(name)
        tree = inner if isinstance(inner, dict) else {}
    return tree


def _hint(path: str, given: Any, system: type[BaseModel], tree: dict[str, Any]) -> str:
    names, beside = wording.known_names(system, tree), _block_of(path, tree)
    found = meant(path, given, names, beside)
    if found is not None:
        return f"did you mean {found}?"
    name, dot, _ = path.partition(".")
    other = meant(path, given, wording.known_names(system, {}), beside) if dot else None
    kinds = _kinds_with(system, path if other is None else other.name)
    there = f" {name}.kind = {' or '.join(kinds)} has it: give that too, as --{name}.kind {kinds[0]}" if kinds else ""
    elsewhere = other is not None and other.name != path and kinds
    hints = [str(other)] if elsewhere else [str(Meant(each)) for each in _near(path, names)]
    return f"did you mean {', '.join(hints[:3])}?{there}"


def _near(path: str, names: list[str]) -> list[str]:
    """Return the names and the blocks that are spelt like a path, or those of its block."""
    leaves = {name: name.rsplit(".", 1)[-1] for name in names}
    # A path as short as this one may have been meant as a block.
    depth = path.count(".") + 1
    blocks = {".".join(name.split(".")[:depth]) for name in names if name.count(".") >= depth}
    near = difflib.get_close_matches(path, [*names, *sorted(blocks)], n=3, cutoff=0.6)
    leaf = path.rsplit(".", 1)[-1]
    near += [name for name in names if leaves[name] in difflib.get_close_matches(leaf, [leaves[name]], cutoff=0.6)]
    if not near:
        near = [name for name in names if name.startswith(path.split(".", 1)[0] + ".")] or names
    return list(dict.fromkeys(near))


def _kinds_with(system: type[BaseModel], path: str) -> list[str]:
    """Return the kinds of a block that have a field which is missing."""
    block, dot, name = path.partition(".")
    registry = wording.registry_of(system, block) if dot and block in system.model_fields else None
    return [kind for kind in registry.names if name in wording.fields_of(registry[kind])] if registry else []
