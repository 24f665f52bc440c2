"""A System in other words: what differs from the bench, as an address, as Python and as a command."""

from __future__ import annotations

import json
import shlex
from typing import Any

from frictionloop.parameters import System, bench
from frictionloop.rendering.effect import EFFECTS
from frictionloop.rendering.library import LIBRARY
from frictionloop.studio.panels import panels_of


def differences(system: System) -> dict[str, Any]:
    """Return the overrides that make a System out of ``fl.bench()``: dotted paths, and plain data.

    >>> import frictionloop as fl
    >>> differences(fl.bench().evolve({"controller.kp": 0.1}))
    {'controller.kp': 0.1}
    """
    found: dict[str, Any] = {}
    base = bench().model_dump(mode="json")
    for name, block in system.model_dump(mode="json").items():
        there = base[name]
        if block.get("kind") != there.get("kind"):
            start = bench().evolve({f"{name}.kind": block["kind"]}).model_dump(mode="json")[name]
            found[f"{name}.kind"] = block["kind"]
            there = start
        found |= _changed(block, there, name)
    return found


def _changed(block: dict[str, Any], there: dict[str, Any], at: str) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in block.items():
        path = f"{at}.{name}"
        if value == there.get(name) or path.endswith(".kind"):
            continue
        if isinstance(value, dict) and isinstance(there.get(name), dict) and name != "effect":
            found |= _changed(value, there[name], path)
        else:
            found[path] = value
    return found


MOST_SHARED = 4000
"""Characters of an effect that still goes into an address or a line of code (assumed: browsers take 64 kB)."""


def is_large(system: System) -> bool:
    """Tell whether the effect of a System, as a painting or a picture, has a place in a file alone."""
    effect = getattr(system.setpoint, "effect", None)
    return effect is not None and len(effect.model_dump_json()) > MOST_SHARED


def effect_name(system: System) -> str:
    """Return the name in the library of a System's effect, an empty text for another."""
    effect = getattr(system.setpoint, "effect", None)
    return next((name for name, each in LIBRARY.items() if each == effect), "")


def as_python(system: System, values: dict[str, Any] | None = None) -> str:
    """Return the lines of Python that make the System; one whose effect is large is read from a file.

    Its `differences` are ``values`` where they are known.
    """
    if is_large(system):
        lines = ["import frictionloop as fl", "", 'system = fl.read_toml("system.toml")']
        return "\n".join([*lines, "run = fl.simulate(system, duration_s=5.0)"])
    values, name = differences(system) if values is None else values, effect_name(system)
    lines = ["import frictionloop as fl", "", "system = fl.bench().evolve({"]
    for path, value in values.items():
        if path == "setpoint.effect" and name:
            continue
        lines.append(f'    "{path}": {value!r},')
    if name and "setpoint.kind" in values:
        lines.append(f'    "setpoint.effect": fl.rendering.find("{name}"),')
    return "\n".join([*lines, "})", "run = fl.simulate(system, duration_s=5.0)"])


def as_command(system: System, values: dict[str, Any] | None = None) -> str:
    """Return the command that opens the studio with the System; one that a flag cannot say is read from a file.

    Its `differences` are ``values`` where they are known.
    """
    values, name = dict(differences(system) if values is None else values), effect_name(system)
    if is_large(system) or any(
        isinstance(value, (dict, list)) for path, value in values.items() if path != "setpoint.effect" or not name
    ):
        return "frictionloop studio system.toml"
    words = ["frictionloop", "studio"]
    if not any(path.startswith("controller.") for path in values):  # the studio has another law where none is named
        values["controller.kind"] = system.controller.kind
    if name and name != "grating":
        words += ["--effect", name]
    for path, value in values.items():
        if path not in ("setpoint.kind", "setpoint.effect"):
            told = value if isinstance(value, str) else json.dumps(value)
            words += [f"--{path}", told]
    return shlex.join(words)


def system_message(system: System) -> dict[str, Any]:
    """Return what pages are told of the System in force."""
    kind, values = getattr(getattr(system.setpoint, "effect", None), "kind", ""), differences(system)
    return {
        "type": "system",
        "effect": effect_name(system) or (kind if kind in EFFECTS.outside else ""),
        "panels": panels_of(system),
        # An address holds no painting: without an address the page offers the file alone.
        "differs": None if is_large(system) else values,
        "python": as_python(system, values),
        "command": as_command(system, values),
    }
