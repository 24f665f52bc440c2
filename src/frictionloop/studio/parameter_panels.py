"""A System as pages show it: every parameter with unit, range and meaning; what differs, as Python and as a command."""

from __future__ import annotations

import inspect
import json
import shlex
from collections.abc import Iterator
from functools import cache
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from frictionloop.parameters import System, bench
from frictionloop.parameters.block import Block
from frictionloop.parameters.input_signals import Steps
from frictionloop.parameters.refusals import registry_of
from frictionloop.quantities import unit_of
from frictionloop.rendering.effect import EFFECTS, Effect
from frictionloop.rendering.library import LIBRARY

PANELS = {
    "wish": ("setpoint",),
    "controller": ("controller",),
    "plate": ("plate",),
    "friction": ("friction", "finger"),
    "sensor": ("sensor", "touch"),
    "disturbance": ("disturbance",),
    "motion": ("motion",),
    "board": ("board",),
}
"""The boxes of the diagram (paper, Fig. 1b), and the blocks of a System that open with each.

The last two are beside the live loop: the page says what of them counts.
"""
SPAN = 5.0
"""A slider without limits of its own goes from a fifth of the value to five times it (assumed).

Any number can be typed beside it.
"""

LONGEST = 256
"""Entries of a list that can be typed; a longer one, as of a painting, has its place in a file."""


def panels_of(system: System) -> dict[str, list[dict[str, Any]]]:
    """Return the fields of every box, in the order of the model.

    Each has ``path`` (dotted), ``name`` (the same in words, without block and unit), ``value``, ``unit`` and ``means``;
    a choice has ``choices``, a number has ``whole`` and the ``low`` and ``high`` of its slider; a number that is left
    out has none. A list has its value as rows of numbers, and ``columns``: the parameter that each column is, or none,
    where the rows themselves are the parameter.
    """
    return {box: [field for name in blocks for field in _block(system, name)] for box, blocks in PANELS.items()}


def _block(system: System, name: str) -> Iterator[dict[str, Any]]:
    kinds, block = registry_of(System, name), getattr(system, name)
    if kinds and len(kinds.names) > 1 and name != "setpoint":
        means = type(system).model_fields[name].description or ""
        told = {"path": f"{name}.kind", "name": "kind", "value": block.kind, "unit": "", "means": means}
        yield told | {"choices": kinds.names}
    yield from _fields(block, name)


def _fields(block: Block, at: str) -> Iterator[dict[str, Any]]:
    if isinstance(block, Steps):  # times and levels as one field: each changes in length with the other alone
        yield {
            "path": f"{at}.steps",
            "name": "steps: time, level",
            "value": list(zip(block.times_s, block.levels_n, strict=True)),
            "unit": "s, N",
            "means": "Start and force of each level.",
            "columns": [f"{at}.times_s", f"{at}.levels_n"],
        }
    for name, field in type(block).model_fields.items():
        value, path = getattr(block, name), f"{at}.{name}"
        if isinstance(value, Block):
            # Of an effect that is mixed of others each part has its place in a file, not in a panel.
            if not (isinstance(value, Effect) and any(value.parts)):
                yield from _fields(value, path)
        elif name != "kind" and (told := _told(value, field, path)):
            means = " ".join(inspect.cleandoc(field.description or "").split())
            yield {"path": path, "name": _name(path), "value": value, "unit": unit_of(path), "means": means} | told


def _listed(value: tuple[Any, ...], field: FieldInfo, path: str) -> dict[str, Any]:
    if _rows_of_numbers(field):
        return {"columns": None} if sum(map(len, value)) <= LONGEST else {}
    return {"value": [(each,) for each in value], "columns": [path]} if len(value) <= LONGEST else {}


def _rows_of_numbers(field: FieldInfo) -> bool:
    """Return whether a list is one of rows, as the sections of a filter are, and not one of numbers."""
    (entry, *_) = get_args(field.annotation)
    return tuple in (get_origin(entry), get_origin(getattr(entry, "__origin__", None)))


@cache
def _name(path: str) -> str:
    """Return what a field is called beside its unit: "delay" of ``controller.delay_s``."""
    *above, leaf = path.split(".")[1:]
    words = leaf.split("_")
    while len(words) > 1 and unit_of(path) and (words[-1] == "per" or unit_of("_".join(words))):
        words.pop()
    return " ".join([*above, *words])


def _told(value: Any, field: FieldInfo, path: str) -> dict[str, Any]:
    if isinstance(value, tuple) and path.rpartition(".")[2] not in Steps.model_fields:
        return _listed(value, field, path)
    if isinstance(value, bool):
        return {"choices": [True, False]}
    if get_origin(field.annotation) is Literal:
        choices = list(get_args(field.annotation))
        return {"choices": choices} if len(choices) > 1 else {}
    if value is None and {int, float} & {getattr(each, "__origin__", each) for each in get_args(field.annotation)}:
        return {"low": None, "high": None, "whole": False}  # left out: it can be typed
    if not isinstance(value, (int, float)):
        return {}
    low, high, strict = _limits(field)
    size = abs(value) or 1.0
    least = -SPAN * size if value < 0 or (low is None and value == 0) else (value / SPAN if strict else 0.0)
    least = least if low is None else max(low, least if strict or low < least else low)
    most = SPAN * size if high is None or (value and high > SPAN * size) else high
    return {"low": least, "high": most, "whole": isinstance(value, int)}


def _limits(field: FieldInfo) -> tuple[float | None, float | None, bool]:
    """Return the least and the largest value, and whether the least is excluded."""
    ends = {
        name: float(found)
        for each in field.metadata
        for name in ("gt", "ge", "lt", "le")
        if (found := getattr(each, name, None)) is not None
    }
    return ends.get("gt", ends.get("ge")), ends.get("lt", ends.get("le")), "gt" in ends


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
            there = bench().evolve({f"{name}.kind": block["kind"]}).model_dump(mode="json")[name]
            found[f"{name}.kind"] = block["kind"]
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


def as_python(system: System, values: dict[str, Any]) -> str:
    """Return the lines of Python that make the System of `differences`; one of a large effect is read from a file."""
    if is_large(system):
        lines = ["import frictionloop as fl", "", 'system = fl.read_toml("system.toml")']
        return "\n".join([*lines, "run = fl.simulate(system, duration_s=5.0)"])
    name, lines = effect_name(system), ["import frictionloop as fl", "", "system = fl.bench().evolve({"]
    shown = {path: value for path, value in values.items() if path != "setpoint.effect" or not name}
    lines += [f'    "{path}": {value!r},' for path, value in shown.items()]
    if name and "setpoint.kind" in values:
        lines.append(f'    "setpoint.effect": fl.rendering.find("{name}"),')
    return "\n".join([*lines, "})", "run = fl.simulate(system, duration_s=5.0)"])


def as_command(system: System, values: dict[str, Any]) -> str:
    """Return the command that opens the studio with the System; one that a flag cannot say is read from a file."""
    values, name = dict(values), effect_name(system)
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
