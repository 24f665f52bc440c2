"""Tables of the parameters, made from the models: name, unit, what is accepted, default, meaning and source."""

from __future__ import annotations

import types
from collections.abc import Iterable
from typing import Any, Literal, Union, get_args, get_origin

from pydantic.fields import FieldInfo

import frictionloop as fl
from frictionloop.parameters.block import Block
from frictionloop.parameters.refusals import known_names
from frictionloop.quantities import unit_of

BLOCKS: dict[str, type[Block]] = {
    "constant": fl.Constant,
    "sine": fl.Sine,
    "log_sweep": fl.LogSweep,
    "steps": fl.Steps,
    "noise": fl.ColouredNoise,
    "recording": fl.Recording,
    "samples": fl.Samples,
    "effect": fl.rendering.EffectSource,
    "effect_track": fl.rendering.Track,
    "friction": fl.Friction,
    "friction_finger": fl.FingerFriction,
    "plate": fl.LowpassPlate,
    "plate_resonant": fl.ResonantPlate,
    "sensor": fl.LowpassSensor,
    "sensor_suspended": fl.SuspendedSensor,
    "finger_skin": fl.Skin,
    "motion_strokes": fl.Strokes,
    "touch_position": fl.PositionSensor,
    "touch_load": fl.LoadCells,
    "board": fl.Board,
    "controller": fl.PiController,
    "controller_lookup": fl.LookupController,
    "controller_notch": fl.NotchPiController,
    "controller_filtered": fl.FilteredPiController,
    "controller_limit_observer": fl.LimitObserverController,
    "model": fl.Model,
}
"""The tables of the parameters page by the name they have there."""
VALUELESS = fl.rendering.Effect, fl.RigidFinger, fl.Sliding, fl.RoughContactFriction
"""Kinds that are chosen and have nothing of their own to set."""
SIGNS = {"gt": "> {:g}", "ge": "≥ {:g}", "lt": "< {:g}", "le": "≤ {:g}"}
UNITS = {
    "": "–",
    "1": "–",
    "um": "µm",
    "um^-2": "µm⁻²",
    "N/rtHz": "N/√Hz",
    "m/s^2/rtHz": "m/s²/√Hz",
    "nV/rtHz": "nV/√Hz",
    "fA/rtHz": "fA/√Hz",
    "1/rtHz": "1/√Hz",
    "deg": "°",
    "mm^2": "mm²",
    "uH": "µH",
    "Mohm": "MΩ",
    "urad": "µrad",
    "kg/m^3": "kg/m³",
}
WORDS = {float: "a number", int: "a whole number", str: "text", bool: "`true`, `false`"}


def table(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """Return a Markdown table."""
    header = list(header)
    lines = [header, ["---"] * len(header), *([str(cell) for cell in row] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _unit(unit: str) -> str:
    return UNITS.get(unit, unit)


def parameters(block: type[Block]) -> str:
    """Return the table of one block."""
    return table(HEADER, _rows(block))


HEADER = "Name", "Unit", "Accepted", "Default", "Meaning (source)"


def _rows(block: type[Block], prefix: str = "") -> Iterable[tuple[str, ...]]:
    for name, field in block.model_fields.items():
        if name not in ("kind", "model"):
            meaning = _sentence(field.description or "")
            yield f"`{prefix}{name}`", _unit(unit_of(name)), accepted(field), default(field), meaning


def design(whole: type[Block]) -> str:
    """Return the table of a design file: dotted names, block by block; of a second kind what differs."""
    rows: list[tuple[str, ...]] = []
    for name, field in whole.model_fields.items():
        kinds: tuple[Any, ...] = get_args(field.annotation) or (field.annotation,)
        for kind in kinds:
            if (given := kind.model_fields.get("kind")) is not None:
                meaning = _sentence(kind.__doc__ or "") + (
                    " What differs from the first kind:" if kind != kinds[0] else ""
                )
                rows.append(
                    (f"`{name}.kind`", "–", f'`"{given.default}"`', default(kinds[0].model_fields["kind"]), meaning)
                )
            rows += [row for row in _rows(kind, f"{name}.") if row not in rows]
    plain = (tuple(cell.replace("≥ 1e-09, ", "").replace(", ≤ 1e+09", "") for cell in row) for row in rows)
    return table(HEADER, plain)


def accepted(field: FieldInfo) -> str:
    """Return in words which values a field takes, besides being finite."""
    limits = [
        form.format(limit)
        for bound in field.metadata
        for sign, form in SIGNS.items()
        if (limit := getattr(bound, sign, None)) is not None
    ]
    return ", ".join(limits) or _words(field.annotation)


def _words(annotation: Any) -> str:
    arguments = get_args(annotation)
    if get_origin(annotation) is Literal:
        return ", ".join(f"`{value}`" for value in arguments)
    if get_origin(annotation) is tuple:
        return "a list of numbers"
    if get_origin(annotation) in (Union, types.UnionType):
        return " or ".join(_optional(part) for part in arguments if part is not type(None)) + " or left out"
    if isinstance(annotation, type) and issubclass(annotation, Block):
        return "a table of values"
    return WORDS[annotation]


def _optional(part: Any) -> str:
    bounds = FieldInfo.from_annotation(part)
    return accepted(bounds)


def default(field: FieldInfo) -> str:
    """Return a field's default as TOML would have it."""
    if field.is_required():
        return "must be given"
    if field.default is None:
        return "left out"
    if isinstance(field.default, Block):
        return f'`kind = "{field.default.kind}"`' if hasattr(field.default, "kind") else "its defaults"
    value = list(field.default) if isinstance(field.default, tuple) else field.default
    text = f"{value:g}" if isinstance(value, float) else str(value).lower() if isinstance(value, bool) else str(value)
    return f'`"{text}"`' if isinstance(value, str) else f"`{text}`"


def _sentence(description: str) -> str:
    return " ".join(description.split()).replace("|", "\\|")


def presets() -> str:
    """Return what each preset holds, path by path."""
    systems = {"`fl.paper()`": fl.paper(), "`fl.feasible()`": fl.feasible(), "`fl.bench()`": fl.bench()}
    blocks = list(fl.System.model_fields)
    every = dict.fromkeys(path for system in systems.values() for path in _paths(system))
    paths = sorted(every, key=lambda path: blocks.index(path.split(".")[0]))
    rows = [(f"`{path}`", *(_value(s, path) for s in systems.values()), _unit(unit_of(path))) for path in paths]
    return table(("Parameter", *systems, "Unit"), rows)


def _value(system: fl.System, path: str) -> str:
    if path not in _paths(system):
        return ""
    value: Any = system
    for name in path.split("."):
        value = getattr(value, name)
    if value is None:
        return "left out"
    return f"{value:g}" if isinstance(value, (int, float)) else f"`{value}`"


def metrics() -> str:
    """Return every metric by name."""
    rows = [(f"`{name}`", m.long_name, _unit(m.units)) for name, m in fl.METRICS.items()]
    return table(("Name", "Meaning", "Unit"), rows)


def _paths(system: fl.System) -> list[str]:
    """Return the dotted names of a system."""
    return known_names(type(system), system.model_dump())


def arrivals() -> str:
    """Return the table of the stored study of effects: a row for each effect, a column for each law."""
    from frictionloop.report.effect_arrivals import rows, stored

    heads, *cells = rows(stored())
    return "\n".join(f"| {' | '.join(row)} |" for row in (heads, ["---"] * len(heads), *cells))


def arrivals_sentence() -> str:
    """Return the first number of that study in one sentence."""
    from frictionloop.report.effect_arrivals import stored

    return stored().sentence
