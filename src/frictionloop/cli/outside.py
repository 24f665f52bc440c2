"""`--use FILE`: import what registers blocks from outside, before a verb runs; mistakes in it are told as its own."""

from __future__ import annotations

import importlib
import importlib.util
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from frictionloop import FrictionloopError

OPTION = "--use"


def used(tokens: Sequence[str]) -> list[str]:
    """Import what ``--use`` names, Python files or modules, and return the other tokens."""
    left: list[str] = []
    given = iter(tokens)
    for token in given:
        name, equals, value = token.partition("=")
        if name != OPTION:
            left.append(token)
            continue
        what = value if equals else next(given, None)
        if not what:
            raise FrictionloopError(f"{OPTION}: needs a Python file or module")
        _import(what)
    return left


def _import(what: str) -> None:
    path = Path(what)
    try:
        if path.suffix != ".py":
            sys.path.insert(0, "")  # modules of the folder that the command runs in, as with python -m
            importlib.import_module(what)
            return
        spec = importlib.util.spec_from_file_location(path.stem, path)
        assert spec is not None and spec.loader is not None
        module = importlib.util.module_from_spec(spec)
        sys.modules[path.stem] = module  # what it defines can then be found again by its name
        spec.loader.exec_module(module)
    except FrictionloopError:
        raise
    except FileNotFoundError as error:
        raise FrictionloopError(f"{OPTION} {what}: {error.strerror}: {error.filename}") from None
    except ModuleNotFoundError as error:
        if error.name != what.partition(".")[0]:
            raise FrictionloopError(f"{OPTION} {what}: {error}") from None
        raise FrictionloopError(f"{OPTION} {what}: no such module; files end in .py") from None
    except SyntaxError as error:
        where = f"SyntaxError in {error.filename}, line {error.lineno}"
        raise FrictionloopError(f"{OPTION} {what}: {where}: {error.msg}") from None
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        told = " ".join(str(error).split())
        raise FrictionloopError(
            f"{OPTION} {what}: {type(error).__name__} in {last.filename}, line {last.lineno}: {told}"
        ) from None
