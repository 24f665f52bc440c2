"""The panels of the page: every parameter of a System with its unit, range and meaning, as pydantic has them."""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from functools import cache
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from frictionloop.parameters import System
from frictionloop.parameters.block import Block
from frictionloop.parameters.sources import Steps
from frictionloop.parameters.wording import registry_of
from frictionloop.quantities import unit_of
from frictionloop.rendering.effect import Effect

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
        yield {
            "path": f"{name}.kind",
            "name": "kind",
            "value": block.kind,
            "unit": "",
            "means": means,
            "choices": kinds.names,
        }
    yield from _fields(block, name)


def _fields(block: Block, at: str) -> Iterator[dict[str, Any]]:
    yield from _steps(block, at)
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


def _steps(block: Block, at: str) -> Iterator[dict[str, Any]]:
    """Yield times and levels as one field: each changes in length with the other alone."""
    if isinstance(block, Steps):
        yield {
            "path": f"{at}.steps",
            "name": "steps: time, level",
            "value": list(zip(block.times_s, block.levels_n, strict=True)),
            "unit": "s, N",
            "means": "Start of each level, rising, the first at 0, and the force from that time on.",
            "columns": [f"{at}.times_s", f"{at}.levels_n"],
        }


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
    low = high = None
    strict = False
    for each in field.metadata:
        for name in ("gt", "ge"):
            if (found := getattr(each, name, None)) is not None:
                low, strict = float(found), name == "gt"
        for name in ("lt", "le"):
            if (found := getattr(each, name, None)) is not None:
                high = float(found)
    return low, high, strict
