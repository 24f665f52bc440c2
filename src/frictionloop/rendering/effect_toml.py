"""Effects by name and as TOML: one file carries an effect with its tables."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path as File
from typing import Any

from pydantic import ValidationError

from frictionloop.parameters.refusals import explain
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.parameters.toml_writer import block_toml
from frictionloop.quantities import FrictionloopError, check_known, must_be, replacing
from frictionloop.rendering.effect import EFFECTS, Effect
from frictionloop.rendering.library import LIBRARY

__all__ = ["changed", "find", "read_effect", "to_toml", "write_effect"]


def find(name: str | os.PathLike[str], values: Mapping[str, Any] | None = None) -> Effect:
    """Return the effect that a name of the library or a TOML file is for, with values of its own by dotted name.

    Raises
    ------
    FrictionloopError
        For a name that is not there, or what is wrong in a file.
    """
    if isinstance(name, str) and not name.endswith(".toml") and os.sep not in name:
        check_known("effect", [name], LIBRARY)
        found = LIBRARY[name]
    else:
        found = read_effect(name)
    return changed(found, values) if values else found


def read_effect(path: str | os.PathLike[str]) -> Effect:
    """Return the effect that a TOML file holds.

    Parameters
    ----------
    path : path
        File with ``schema = 1``, ``kind`` and the values of that kind.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or what is wrong in it, naming file, field and value.
    """
    return effect_of(read_tree(path), f"{path}: ")


def effect_of(tree: dict[str, Any], where: str = "") -> Effect:
    """Return the effect of a tree of values; ``where`` is named in errors."""
    try:
        effect = EFFECTS.read(tree)
    except ValidationError as error:
        model: Any = EFFECTS[tree["kind"]]
        raise FrictionloopError(where + explain(model, error, tree)) from None
    except FrictionloopError:
        raise
    except ValueError as error:
        raise FrictionloopError(f"{where}{error}") from None
    assert isinstance(effect, Effect)
    return effect


def changed(effect: Effect, values: Mapping[str, Any]) -> Effect:
    """Return an effect with values of its own or of its parts, by dotted name: ``spacing_mm``, ``of.1.height_mm``."""
    tree = effect.model_dump(mode="json")
    for path, value in values.items():
        *way, last = path.split(".")
        node: Any = tree
        for name in (*way, None):
            parts = {str(k): each for k, each in enumerate(node)} if isinstance(node, list) else node
            if not isinstance(parts, dict) or (name or last) not in parts:
                there = ", ".join(parts) if isinstance(parts, dict) else "nothing"
                raise FrictionloopError(f"effect.{path}: is unknown; accepted instead of {name or last!r}: {there}")
            if name is not None:
                node = parts[name]
        node[int(last) if isinstance(node, list) else last] = value
    return effect_of(tree, "effect: ")


def to_toml(effect: Effect) -> str:
    """Return an effect as TOML text, each key with its unit and meaning as a comment."""
    if not isinstance(effect, Effect):
        raise must_be("effect", effect, "an effect")
    return block_toml(effect)


def write_effect(effect: Effect, path: str | os.PathLike[str]) -> None:
    """Write an effect as a TOML file; the old file stays whole until the new one is complete.

    Raises
    ------
    FrictionloopError
        For what is no effect, or a file that cannot be written.
    """
    text = to_toml(effect)
    with replacing(path) as beside:
        File(beside).write_text(text, encoding="utf-8")
