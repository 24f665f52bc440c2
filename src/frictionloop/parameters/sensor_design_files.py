"""A SensorDesign from and to TOML, and with some values replaced; every complaint in one line."""

from __future__ import annotations

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from frictionloop.parameters import wording
from frictionloop.parameters.files import SCHEMA, _flatten, _table, check_schema
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.quantities import FrictionloopError, replacing


def evolve_design(design: SensorDesign, overrides: Mapping[str, Any]) -> SensorDesign:
    """Return a copy of a sensor design with some values replaced.

    Parameters
    ----------
    design : SensorDesign
        What to start from.
    overrides : mapping
        Dotted paths to values in the unit their name ends with: ``{"electrodes.gap_um": 150.0}``. A new
        ``springs.kind`` starts from the defaults of that kind.

    Raises
    ------
    FrictionloopError
        For an unknown path, naming near ones, or a value outside its range.
    """
    tree = design.model_dump()
    for path, value in sorted(overrides.items(), key=lambda item: not item[0].endswith(".kind")):
        block, _, leaf = path.partition(".")
        if leaf == "kind" and block == "springs" and value != tree[block]["kind"]:
            tree[block] = {"kind": _kind(value)}
            continue
        names = wording.known_names(SensorDesign, tree)
        if path not in names:
            raise FrictionloopError(wording.unknown(path, names))
        tree[block][leaf] = value
    return _validated(tree)


def _kind(value: Any) -> str:
    kinds = [model.model_fields["kind"].default for model in wording.kinds_of(SensorDesign, "springs")]
    if value not in kinds:
        raise FrictionloopError(f"springs.kind = {value!r} is unknown; accepted: {', '.join(map(repr, kinds))}")
    return str(value)


def _validated(tree: Mapping[str, Any]) -> SensorDesign:
    try:
        return SensorDesign.model_validate(tree)
    except ValidationError as error:
        raise FrictionloopError(wording.explain(SensorDesign, error, tree)) from None


def read_design(path: str | os.PathLike[str]) -> SensorDesign:
    """Return the sensor design a TOML file describes; what it leaves out keeps its default.

    Parameters
    ----------
    path : path
        File with ``schema = 1`` and one table per block.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or what is wrong in it, naming file, field and value.
    """
    where = f"{path}: "
    try:
        tree = tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise FrictionloopError(f"{where}cannot be read ({getattr(error, 'strerror', None) or error})") from None
    except tomllib.TOMLDecodeError as error:
        raise FrictionloopError(f"{where}is not TOML: {error}") from None
    check_schema(tree.pop("schema", SCHEMA), where)
    try:
        return evolve_design(SensorDesign(), _flatten(tree))
    except FrictionloopError as error:
        raise FrictionloopError(f"{where}{error}") from None


def design_toml(design: SensorDesign) -> str:
    """Return a sensor design as TOML text, read back by ``read_design``."""
    lines = [f"schema = {SCHEMA}"]
    for name, block in design.model_dump().items():
        lines += ["", *_table(name, block)]
    return "\n".join(lines) + "\n"


def write_design(design: SensorDesign, path: str | os.PathLike[str]) -> None:
    """Write a sensor design as a TOML file; the old file stays whole until the new one is complete.

    Parameters
    ----------
    design : SensorDesign
        What to write.
    path : path
        File to write, replaced if it is there.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    with replacing(path) as beside:
        beside.write_text(design_toml(design), encoding="utf-8")
