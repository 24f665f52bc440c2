"""What a System accepts, and what is said of what it does not: in one line, with what is near and what was meant."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from itertools import islice
from typing import Any

from pydantic import BaseModel, ValidationError

from frictionloop.parameters.aliases import Meant, meant
from frictionloop.quantities import unit_of

USUAL = {
    "nominal_n": (0.01, 20.0),
    "susceptibility_per_um2": (1e-3, 50.0),
    "max_amplitude_um": (0.05, 50.0),
    "cutoff_hz": (1.0, 1e5),
    "frequency_hz": (0.01, 2e5),
    "resonance_hz": (5.0, 1e4),
    "moving_mass_kg": (1e-3, 10.0),
    "noise_rms_n": (1e-8, 0.5),
    "noise_density_n_rthz": (1e-9, 3e-4),
    "range_n": (0.05, 100.0),
    "rate_hz": (100.0, 2e5),
    "delay_s": (1e-7, 0.05),
    "offset_n": (1e-3, 20.0),
    "amplitude_n": (1e-4, 20.0),
    "load_n": (0.01, 20.0),
    "speed_mm_s": (0.5, 1000.0),
    "stroke_mm": (2.0, 1000.0),
    "tremor_um": (0.5, 500.0),
    "tremor_n": (1e-4, 1.0),
    "stiffness_n_m": (20.0, 1e5),
    "mass_kg": (1e-6, 0.01),
}
"""Ranges by a parameter's name, the ends a decade or so beyond what is published of fingers and displays (chosen)."""

USUAL_OF = {
    "plate.frequency_hz": (5e3, 2e5),
    "plate.q": (2.0, 1e5),
    "moving.mass_kg": (1e-3, 10.0),
    "springs.width_mm": (0.5, 500.0),
    "springs.thickness_mm": (0.02, 20.0),
    "electrodes.area_mm2": (1.0, 1e5),
    "electrodes.gap_um": (5.0, 5000.0),
    "excitation.frequency_hz": (1e3, 1e7),
    "geometry.length_mm": (5.0, 2000.0),
    "geometry.width_mm": (5.0, 2000.0),
    "geometry.thickness_mm": (0.1, 20.0),
    "drive.resonance_hz": (5e3, 2e5),
    "disturbance.offset_n": (1e-12, 20.0),  # the mean of what its mean was taken from
    "disturbance.rate_hz": (1.0, 2e6),
    "setpoint.rate_hz": (1.0, 2e6),
}
"""Ranges of those whose name alone does not say: ultrasound, a plate that resonates, and what one builds (chosen)."""
PREFIXES = (1e-6, 1e-3, 1e3, 1e6)


def likely(value: float, low: float, high: float) -> float | None:
    """Return the value in the range that a wrong prefix, as milli or kilo, is nearest to; None if there is none."""
    found = [value * factor for factor in PREFIXES if low <= value * factor <= high]
    middle = math.log(low * high) / 2.0
    return min(found, key=lambda each: abs(math.log(each) - middle), default=None)


def meant_instead(path: str, value: Any) -> str:
    """Return what was probably meant by a number that is refused, behind a semicolon; "" where nothing is near."""
    usual = USUAL.get(path.rpartition(".")[2])
    if usual is None or isinstance(value, bool) or not isinstance(value, (int, float)) or not value:
        return ""
    meant = likely(abs(float(value)), *usual)
    return "" if meant is None else f"; did you mean {meant:g} {unit_of(path)}?"


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
        return refusal(strangers, system, tree)
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


MOST_NAMED = 20
"""Unknown names that are told."""


def refusal(strangers: Mapping[str, Any], system: type[BaseModel], tree: Mapping[str, Any]) -> str:
    """Return one line for a name that is unknown, a line each below a heading for several, of many the first."""
    first = dict(islice(strangers.items(), MOST_NAMED))
    believed = _believed(first, system, tree)
    hints = {path: _hint(path, given, system, believed) for path, given in first.items()}
    if len(strangers) == 1:
        return "".join(f"unknown parameter {path!r}; {hint}" for path, hint in hints.items())
    more = [f"  and {len(strangers) - MOST_NAMED} more"] * (len(strangers) > MOST_NAMED)
    lines = [f"  {path!r}: {hint}" for path, hint in hints.items()]
    return "\n".join([f"{len(strangers)} unknown parameters:", *lines, *more])


def _believed(strangers: Mapping[str, Any], system: type[BaseModel], tree: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values with those that strangers alone stand for: one may be needed to convert another."""
    believed, names = _plain(tree), known_names(system, tree)
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
    names, beside = known_names(system, tree), _block_of(path, tree)
    found = meant(path, given, names, beside)
    if found is not None:
        return f"did you mean {found}?"
    name, dot, _ = path.partition(".")
    other = meant(path, given, known_names(system, {}), beside) if dot else None
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
    registry = registry_of(system, block) if dot and block in system.model_fields else None
    return [kind for kind in registry.names if name in fields_of(registry[kind])] if registry else []
