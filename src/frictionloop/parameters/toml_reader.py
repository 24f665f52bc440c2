"""A System from a TOML file, with every complaint in one line that names the line of the file."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from frictionloop.parameters import presets
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.system import System
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.whole_files import text_of

SHOWN = 80
"""Characters of a line that are shown."""
_PLACE = re.compile(r"\(at line (\d+), column \d+\)")
_NAMED = re.compile(r"(?:unknown parameter ')?(?: +')?([A-Za-z_]\w*(?:\.\w+)*)\b")
_TABLE = re.compile(r"\s*\[\s*([\w.]+)\s*\]")
_KEY = re.compile(r"\s*([\w.]+)\s*=")


def with_line(path: str | os.PathLike[str], complaint: str) -> str:
    """Return a complaint with the line of the file that it is about behind it, where one is.

    It names the line by its number, as the parser does, or begins with the dotted name of a value; of several lines
    each does.
    """
    if "\n" in complaint:
        return "\n".join(with_line(path, each) for each in complaint.split("\n"))
    try:
        lines = Path(path).read_text(encoding="utf-8-sig").splitlines()
    except (OSError, UnicodeDecodeError):
        return complaint
    if parsed := _PLACE.search(complaint):
        number = int(parsed[1])
        return complaint + (f": {lines[number - 1].strip()[:SHOWN]!r}" if 0 < number <= len(lines) else "")
    named = _NAMED.match(complaint)
    number = 0 if named is None else _line_of(lines, named[1])
    return f"{complaint} (line {number}: {lines[number - 1].strip()[:SHOWN]!r})" if number else complaint


def _line_of(lines: list[str], name: str) -> int:
    """Return the number of the line, from 1, at which a dotted name is given a value or its table begins; 0 if none."""
    table = ""
    for number, line in enumerate(lines, 1):
        if begun := _TABLE.match(line):
            table = f"{begun[1]}."
            if begun[1] == name:
                return number
        elif (key := _KEY.match(line)) and table + key[1] == name:
            return number
    return 0


Design = TypeVar("Design", bound=Description)
SCHEMA = 1
"""Version of the parameter file and of the run file; a newer one is refused."""
DESIGNED = "designed"
"""Table of what was asked and found of a controller: no part of a System."""
MODEL = "controller.model.nominal_n"
"""What a controller believes of the friction, which a whole file says beside a coefficient."""
DEEPEST = 32
"""Parts of a key (assumed)."""
_PART = r"""(?:[\w-]++|"[^"\n]*+"|'[^'\n]*+')[ \t]*+"""
_DEEP = re.compile(rf"(?<![\w-]){_PART}(?:\.[ \t]*+{_PART}){{{DEEPEST},}}")
"""A dotted key that the parser takes the square, or more, of its length for."""
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
    tree.pop(DESIGNED, None)
    base = tree.pop("preset", None)
    if base is None:
        return _complete(path, tree)
    return _evolved(path, lambda: preset(base), tree)


def start_of(path: str | os.PathLike[str]) -> tuple[System | None, dict[str, Any]]:
    """Return the preset that a readable TOML file starts from, None without one, and the values it changes by name."""
    tree = read_tree(path)
    tree.pop(DESIGNED, None)
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
        raise FrictionloopError(f"{path}: describes a bench (has {bench}); must be a design of a {part}")
    return _evolved(path, lambda: default, tree)


def _complete(path: str | os.PathLike[str], tree: dict[str, Any]) -> System:
    if not tree:
        raise FrictionloopError(f'{path}: is empty; accepted: preset = "paper"')
    friction = tree.get("friction")
    own = friction if isinstance(friction, dict) and "coefficient" in friction else {}
    named = {f"friction.{name}": own[name] for name in ("coefficient", "nominal_n") if name in own}
    own.pop("coefficient", None)
    try:
        whole = System.from_tree(tree)
        return whole.evolve(named | {MODEL: whole.controller.model.nominal_n}) if named else whole
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
    text = text_of(path)
    if _DEEP.search(text):
        raise FrictionloopError(f"{where}has a key of over {DEEPEST} parts")
    try:
        tree = tomllib.loads(text)
    except ValueError as error:  # a number of thousands of digits too
        twice = "; each [block] stands once" * ("twice" in str(error))
        raise FrictionloopError(f"{where}is not TOML: {with_line(path, str(error))}{twice}") from None
    except RecursionError:
        raise FrictionloopError(f"{where}is nested too deeply") from None
    check_schema(tree.pop("schema", SCHEMA), where)
    return tree


def check_schema(schema: Any, where: str) -> None:
    """Refuse a file that a newer version of the package has written."""
    if not isinstance(schema, int):
        raise must_be(f"{where}schema", schema, f"a whole number, at most {SCHEMA}")
    if schema > SCHEMA:
        raise must_be(f"{where}schema", schema, f"at most {SCHEMA} for this version")


def _from_here(tree: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Return the tree with the paths of recordings as seen from where the program runs."""
    return {
        name: block | {"path": str(folder / block["path"])}
        if isinstance(block, dict) and isinstance(block.get("path"), str)
        else block
        for name, block in tree.items()
    }
