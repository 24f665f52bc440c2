"""A System as TOML text: each key with its unit and meaning as a comment."""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, NamedTuple, get_args, get_origin

from pydantic import BaseModel

from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.system import check_system
from frictionloop.parameters.toml_reader import DESIGNED, SCHEMA
from frictionloop.quantities import replacing, unit_of

if TYPE_CHECKING:
    from tomlkit.items import Table

_RARE = """
    touch board pulse_ticks jitter_s lost_ticks open_until_s table_size table_um2
    slow_mm_s static_ratio static_s static_um drying_s roughness_longest_mm
    start load_drift_s tremor_width_hz landing_s contact_s lifted_s person unscored_n
"""
_SOURCE = re.compile(r"\s*\([^()]*\b(?:paper|assumed|ref|(?:19|20)\d\d)\b[^()]*\)")
"""Where a default comes from, a year with an author or the paper; it says nothing about another value."""
RARE = frozenset(_RARE.split())
"""Blocks and keys that a simple bench never needs to change."""


def write_toml(
    system: Description,
    path: str | os.PathLike[str],
    every: bool = True,
    said: Sequence[str] = (),
    given: Collection[str] = (),
    designed: Mapping[str, Any] | None = None,
) -> None:
    """Write a System, or a design, as a TOML file; the old file stays whole until the new one is complete.

    The path of a recording is written as seen from the file, which can then be moved with it.

    Parameters
    ----------
    system : System, SensorDesign or PlateDesign
        What to write.
    path : path
        File to write, replaced if it is there.
    every, said, given, designed
        As in `to_toml`.

    Raises
    ------
    FrictionloopError
        For what is none of them, or a file that cannot be written.
    """
    text = to_toml(_from_there(system, Path(path).parent), every, said, given, designed)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")


def _from_there(system: Description, folder: Path) -> Description:
    """Return a System whose recordings' paths start at a folder they lie in, and are absolute elsewhere."""
    changes = {}
    for name in type(system).model_fields:
        path = getattr(getattr(system, name), "path", None)
        if path is not None:
            absolute, folder = Path(path).absolute(), folder.absolute()
            inside = absolute.is_relative_to(folder)
            changes[f"{name}.path"] = str(absolute.relative_to(folder) if inside else absolute)
    return system.evolve(changes) if changes else system


def to_toml(
    system: Description,
    every: bool = True,
    said: Sequence[str] = (),
    given: Collection[str] = (),
    designed: Mapping[str, Any] | None = None,
) -> str:
    """Return a System, or a design, as TOML text, each key with its unit and meaning as a comment.

    Parameters
    ----------
    system : System, SensorDesign or PlateDesign
        What to write.
    every : bool
        Whether to write also those keys that a simple bench never needs, where they have their defaults. Keys without
        a value then stand there as comments.
    said : sequence of str
        Lines to begin with, as comments.
    given : collection of str
        Dotted names of values that a person gave: where a default comes from says nothing of these, though equal.
    designed : mapping
        The table [designed]: what was asked and found of the controller.

    Raises
    ------
    FrictionloopError
        For what is none of them.
    """
    if not isinstance(system, Description):
        check_system(system)
    import tomlkit

    file = tomlkit.document()
    for line in said:
        file.add(tomlkit.comment(line))
    if not every:
        file.add(tomlkit.comment("Without what a simple bench never needs (--whole)."))
    file.add("schema", tomlkit.item(SCHEMA))
    _fill(file, system, _Way(every, given=given))
    if designed is not None:
        file.add(DESIGNED, tomlkit.item(designed))
    return file.as_string()


def block_toml(block: BaseModel, form: bool = False) -> str:
    """Return one block by itself as TOML text.

    Parameters
    ----------
    block : Block
        What to write.
    form : bool
        Whether it is to be filled in: words say what is accepted.
    """
    import tomlkit

    file = tomlkit.document()
    file.add("schema", tomlkit.item(SCHEMA))
    _fill(file, block, _Way(form=form))
    return file.as_string()


class _Way(NamedTuple):
    """How values are written: all, with words for a form, those that a person gave, and the block they are in."""

    every: bool = True
    form: bool = False
    given: Collection[str] = ()
    within: str = ""

    def inside(self, key: str) -> _Way:
        """Return that of a block of this name."""
        return self._replace(within=f"{self.within}{key}.")


def _table(block: BaseModel, way: _Way) -> Table:
    import tomlkit

    table = tomlkit.table(is_super_table=False)
    _fill(table, block, way)
    return table


def _fill(table: Any, block: BaseModel, way: _Way) -> None:
    """Add the values of a block to a table or a file."""
    import tomlkit

    values = {key: (getattr(block, key), type(block).model_fields[key]) for key in block.model_dump()}
    # What follows depends on the kind, which an inherited value may precede; tables end a table.
    for key, (value, field) in sorted(values.items(), key=lambda item: (_is_block(item[1][0]), item[0] != "kind")):
        if value is None and way.every:
            table.add(tomlkit.comment(f"{key} =  # {_said(key, field.description or '')}"))
        if value is None or not (way.every or key not in RARE or value != field.get_default(call_default_factory=True)):
            continue
        if _is_block(value):
            several = isinstance(value, tuple)
            inner = way.inside(key)
            table.add(key, _several(value, inner) if several else _table(value, inner))
        else:
            entry = tomlkit.item(value)
            own = value != field.get_default(call_default_factory=True) or f"{way.within}{key}" in way.given
            said = _said(key, _SOURCE.sub("", field.description or "") if own else field.description or "")
            if way.form and (accepted := get_args(field.annotation))[1:] and get_origin(field.annotation) is Literal:
                said += f"; accepts {', '.join(accepted)}"
            if said:
                entry.comment(said).trivia.comment_ws = "  "
            table.add(key, entry)


def _several(blocks: tuple[BaseModel, ...], way: _Way) -> Any:
    """Return blocks of one name as an array of tables."""
    import tomlkit

    array = tomlkit.aot()
    for block in blocks:
        array.append(_table(block, way))
    return array


def _said(key: str, description: str) -> str:
    """Return a key's unit and the first paragraph of its meaning."""
    meaning = " ".join(description.partition("\n\n")[0].replace("``", "").split()).rstrip(".")
    return ": ".join(part for part in (unit_of(key), meaning) if part)


def _is_block(value: Any) -> bool:
    """Tell whether a value is a block, or several."""
    return isinstance(value[0] if isinstance(value, tuple) and value else value, BaseModel)
