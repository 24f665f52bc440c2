"""A System as a TOML file: written with each key's unit and meaning, read with every complaint in one line."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args, get_origin

from pydantic import BaseModel

from frictionloop.parameters import presets
from frictionloop.parameters.description import Description
from frictionloop.parameters.file_lines import with_line
from frictionloop.parameters.system import System, check_system
from frictionloop.quantities import FrictionloopError, replacing, unit_of

if TYPE_CHECKING:
    from tomlkit.items import Table

Design = TypeVar("Design", bound=Description)
SCHEMA = 1
"""Version of the parameter file and of the run file; a newer one is refused."""
LARGEST_BYTES, DEEPEST = 10**6, 32
"""Of a parameter file; all keys of all blocks, and arrays of thousands of samples, fit (assumed)."""
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DEEP = re.compile(rf"(?<![\w-]){_PART}(?:\.[ \t]*+{_PART}){{{DEEPEST},}}")
"""A dotted key that the parser takes the square, or more, of its length for."""
_RARE = """
    touch board pulse_ticks jitter_s lost_ticks open_until_s form table_size table_um2
    slow_mm_s static_ratio static_mm_s drying_s roughness_longest_mm bristle_damping_n_s_m
    start load_drift_s tremor_width_hz landing_s contact_s lifted_s person unscored_n
"""
_SOURCE = re.compile(r"\s*\([^()]*\b(?:paper|assumed|ref|(?:19|20)\d\d)\b[^()]*\)")
"""Where a default comes from, a year with an author or the paper; it says nothing about another value."""
RARE = frozenset(_RARE.split())
"""Blocks and keys that a simple bench never needs to change."""
PRESETS = {"paper": presets.paper, "feasible": presets.feasible, "bench": presets.bench}


def preset(name: str) -> System:
    """Return the preset of that name.

    Parameters
    ----------
    name : str
        ``"paper"``, ``"feasible"`` or ``"bench"``.

    Raises
    ------
    FrictionloopError
        For another name.
    """
    if name not in list(PRESETS):
        raise FrictionloopError(f"preset = {name!r} is unknown; accepted: {', '.join(map(repr, PRESETS))}")
    return PRESETS[name]()


def read_toml(path: str | os.PathLike[str]) -> System:
    """Return the System a TOML file describes.

    Parameters
    ----------
    path : path
        File with ``schema = 1`` and one table per block. With ``preset = "paper"`` it needs only what differs; without
        it every block must be there. A relative path in it, of a recording, starts at the folder of the file.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or what is wrong in it, naming file, field and value.
    """
    tree = _from_here(read_tree(path), Path(path).parent)
    base = tree.pop("preset", None)
    if base is None:
        return _complete(path, tree)
    return _evolved(path, lambda: preset(base), tree)


def start_of(path: str | os.PathLike[str]) -> tuple[System | None, dict[str, Any]]:
    """Return the preset that a readable TOML file starts from, None without one, and the values it changes by name."""
    tree = read_tree(path)
    base = tree.pop("preset", None)
    tables = {name: block for name, block in tree.items() if isinstance(block, dict)}
    changes = {f"{name}.{key}": value for name, block in tables.items() for key, value in block.items()}
    return (None if base is None else preset(base)), changes


def read_design(path: str | os.PathLike[str], default: Design) -> Design:
    """Return the design a TOML file describes; what it leaves out is as in ``default``.

    Parameters
    ----------
    path : path
        File with ``schema = 1`` and one table per block.
    default : SensorDesign or PlateDesign
        What to start from, which also says what is described.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or what is wrong in it, naming file, field and value.
    """
    tree = read_tree(path)
    if bench := next((each for each in ("preset", *System.model_fields) if each in tree), None):
        part = "sensor" if hasattr(default, "electrodes") else "plate"
        raise FrictionloopError(f"{path}: has {bench}, so it describes a bench; accepted: a design of a {part}")
    return _evolved(path, lambda: default, tree)


def _complete(path: str | os.PathLike[str], tree: dict[str, Any]) -> System:
    if not tree:
        raise FrictionloopError(f'{path}: is empty; accepted: preset = "paper" and what differs, or all blocks')
    try:
        return System.from_tree(tree)
    except FrictionloopError as error:
        raise FrictionloopError(f"{path}: {with_line(path, str(error))}") from None


def _evolved(path: str | os.PathLike[str], base: Callable[[], Design], tree: dict[str, Any]) -> Design:
    try:
        return base().evolve(tree)
    except FrictionloopError as error:
        raise FrictionloopError(f"{path}: {with_line(path, str(error))}") from None


def read_tree(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the values of a readable TOML file of this schema, without its version."""
    where = f"{path}: "
    try:
        if Path(path).stat().st_size > LARGEST_BYTES:
            raise FrictionloopError(f"{where}has more than {LARGEST_BYTES:,} bytes; accepted: a file of parameters")
        text = Path(path).read_text(encoding="utf-8-sig")
        if _DEEP.search(text):
            raise FrictionloopError(f"{where}has a key of more than {DEEPEST} parts; accepted: block.key")
        tree = tomllib.loads(text)
    except OSError as error:
        raise FrictionloopError(f"{where}cannot be read ({error.strerror or error})") from None
    except UnicodeDecodeError as error:
        said = f"is no text in UTF-8 (byte {error.start}); accepted: a text file, saved as UTF-8"
        raise FrictionloopError(f"{where}{said}") from None
    except tomllib.TOMLDecodeError as error:
        raise FrictionloopError(f"{where}is not TOML: {with_line(path, str(error))}") from None
    except RecursionError:
        raise FrictionloopError(f"{where}is nested too deeply; accepted: blocks with keys") from None
    check_schema(tree.pop("schema", SCHEMA), where)
    return tree


def check_schema(schema: Any, where: str) -> None:
    """Refuse a file that a newer version of the package has written."""
    if not isinstance(schema, int):
        raise FrictionloopError(f"{where}schema = {schema!r:.60}: must be a whole number, at most {SCHEMA}")
    if schema > SCHEMA:
        raise FrictionloopError(
            f"{where}schema = {schema!r} is newer than this version reads (up to {SCHEMA}); update frictionloop"
        )


def _from_here(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tree with the paths of recordings as seen from where the program runs."""
    return {
        name: block | {"path": str(folder / block["path"])}
        if isinstance(block, dict) and isinstance(block.get("path"), str)
        else block
        for name, block in tree.items()
    }


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


def to_toml(system: Description, every: bool = True, said: Sequence[str] = ()) -> str:
    """Return a System, or a design, as TOML text, each key with its unit and meaning as a comment.

    Parameters
    ----------
    system : System, SensorDesign or PlateDesign
        What to write.
    every : bool
        Whether to write also those keys that a simple bench never needs, where they have their defaults.
    said : sequence of str
        Lines to begin with, as comments.

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
        file.add(tomlkit.comment("What a simple bench never needs is left out; --all writes it too."))
    file.add("schema", tomlkit.item(SCHEMA))
    _fill(file, system, every)
    return file.as_string()


def block_toml(block: BaseModel, form: bool = False) -> str:
    """Return one block by itself as TOML text.

    Parameters
    ----------
    block : Block
        What to write.
    form : bool
        Whether it is to be filled in: keys without a value stand there as comments, and words say what is accepted.
    """
    import tomlkit

    file = tomlkit.document()
    file.add("schema", tomlkit.item(SCHEMA))
    _fill(file, block, True, form)
    return file.as_string()


def _table(block: BaseModel, every: bool, form: bool) -> Table:
    import tomlkit

    table = tomlkit.table(is_super_table=False)
    _fill(table, block, every, form)
    return table


def _fill(table: Any, block: BaseModel, every: bool, form: bool = False) -> None:
    """Add the values of a block to a table or a file."""
    import tomlkit

    values = {key: (getattr(block, key), type(block).model_fields[key]) for key in block.model_dump()}
    # What follows depends on the kind, which an inherited value may precede; tables end a table.
    for key, (value, field) in sorted(values.items(), key=lambda item: (_is_block(item[1][0]), item[0] != "kind")):
        if value is None and form:
            table.add(tomlkit.comment(f"{key} =  # {_said(key, field.description or '')}"))
        if value is None or not (every or key not in RARE or value != field.get_default(call_default_factory=True)):
            continue
        if _is_block(value):
            several = isinstance(value, tuple)
            table.add(key, _several(value, every, form) if several else _table(value, every, form))
        else:
            entry = tomlkit.item(value)
            own = value != field.get_default(call_default_factory=True)
            said = _said(key, _SOURCE.sub("", field.description or "") if own else field.description or "")
            if form and (accepted := get_args(field.annotation))[1:] and get_origin(field.annotation) is Literal:
                said += f"; accepts {', '.join(accepted)}"
            if said:
                entry.comment(said).trivia.comment_ws = "  "
            table.add(key, entry)


def _several(blocks: tuple[BaseModel, ...], every: bool, form: bool) -> Any:
    """Return blocks of one name as an array of tables."""
    import tomlkit

    array = tomlkit.aot()
    for block in blocks:
        array.append(_table(block, every, form))
    return array


def _said(key: str, description: str) -> str:
    """Return a key's unit and the first paragraph of its meaning."""
    meaning = " ".join(description.partition("\n\n")[0].replace("``", "").split()).rstrip(".")
    return ": ".join(part for part in (unit_of(key), meaning) if part)


def _is_block(value: Any) -> bool:
    """Tell whether a value is a block, or several."""
    return isinstance(value[0] if isinstance(value, tuple) and value else value, BaseModel)


def write_toml(system: Description, path: str | os.PathLike[str], every: bool = True, said: Sequence[str] = ()) -> None:
    """Write a System, or a design, as a TOML file; the old file stays whole until the new one is complete.

    The path of a recording is written as seen from the file, which can then be moved with it.

    Parameters
    ----------
    system : System, SensorDesign or PlateDesign
        What to write.
    path : path
        File to write, replaced if it is there.
    every, said
        As in `to_toml`.

    Raises
    ------
    FrictionloopError
        For what is none of them, or a file that cannot be written.
    """
    text = to_toml(_from_there(system, Path(path).parent), every, said)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
