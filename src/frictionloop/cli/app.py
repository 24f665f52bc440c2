"""One command from its tokens to its exit code: errors in one line, Ctrl-C, pipes that close."""

from __future__ import annotations

import atexit
import gc
import importlib
import importlib.util
import os
import shlex
import shutil
import signal
import sys
import threading
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from cyclopts import CycloptsError, MissingArgumentError, UnknownOptionError, UnusedCliTokensError

import frictionloop as fl
from frictionloop.cli.flags import DOTTED, gather
from frictionloop.cli.screen import Interrupted, say
from frictionloop.cli.verb import flags_of_commands
from frictionloop.cli.verbs import app

NOT_WRITTEN, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Exit codes; the last is 128 plus the number of the signal, as shells give it."""
GARBAGE_AFTER = 100_000
"""Objects more between two looks for garbage, which would take a tenth of a command's time."""


def main(tokens: Sequence[str] | None = None) -> None:
    """Run one command and leave with its exit code: 0, 2 for bad input, 130 after Ctrl-C or SIGTERM."""
    gc.set_threshold(GARBAGE_AFTER)
    atexit.register(gc.freeze)  # half a second of looking through what is about to end
    try:
        with _terminated_like_ctrl_c():
            code = _run(list(sys.argv[1:] if tokens is None else tokens))
        print(end="", flush=True)
    except OSError as error:
        # A reader that has left (head, less) is no error. What Python still wants to flush at its exit goes nowhere.
        if not isinstance(error, BrokenPipeError):
            say(f"error: output: {error.strerror or error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = NOT_WRITTEN
    raise SystemExit(code)


@contextmanager
def _terminated_like_ctrl_c() -> Iterator[None]:
    """Take SIGTERM, by which a limit on time ends a command, as Ctrl-C: what is done is kept and told."""

    def taken(*_: Any) -> None:
        raise KeyboardInterrupt

    def compiles(begins: bool) -> None:
        """Leave SIGTERM to the system meanwhile: a compiler looks at no signal until it is done."""
        if signal.getsignal(signal.SIGTERM) == (taken if begins else signal.SIG_DFL):
            with suppress(ValueError):  # another thread compiles
                signal.signal(signal.SIGTERM, signal.SIG_DFL if begins else taken)

    ignored = signal.getsignal(signal.SIGTERM) == signal.SIG_IGN
    if ignored or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, taken)
    fl.progress.on_compiling.append(compiles)
    try:
        yield
    finally:
        fl.progress.on_compiling.remove(compiles)
        signal.signal(signal.SIGTERM, before if before is not None else signal.SIG_DFL)


def _run(tokens: list[str]) -> int:
    try:
        with fl.progress.plain_lines(say), warnings.catch_warnings():
            warnings.simplefilter("ignore", fl.SignalWarning)  # a verb asks in the words of flags
            code = app(gather(_used(tokens)), print_error=False, exit_on_error=False, result_action="return_value")
        return code if isinstance(code, int) else 0
    except CycloptsError as error:
        say(f"error: {_refusal(error, tokens)}")
    except fl.FrictionloopError as error:
        own = error.code not in ("BAD-VALUE", "UNKNOWN-NAME")  # an explanation of its own
        say(f"error: {error}" + f"  [{error.code}]" * own)
    except Interrupted as stop:
        say(f"interrupted: {stop}")
        if stop.resumable:
            say(f"continue with: {_program()} {shlex.join([*tokens, *([] if '--resume' in tokens else ['--resume'])])}")
        return INTERRUPTED
    except KeyboardInterrupt as stop:
        say(f"interrupted: {stop}" if str(stop) else "interrupted")
        return INTERRUPTED
    return BAD_INPUT


MOST_TOLD = 20
"""Options that are refused at once."""


def _refusal(error: CycloptsError, tokens: Sequence[str]) -> str:
    """Return what is wrong with the tokens in a line, or of several options that are unknown a line each."""
    said, rest, found = [_one_line(error, tokens)], gather(tokens), error
    while isinstance(found, UnknownOptionError) and len(said) < MOST_TOLD:
        rest = _without(rest, (found.token.keyword or found.token.value).partition("=")[0])
        try:
            app.parse_args(rest, print_error=False, exit_on_error=False)
            break
        except CycloptsError as another:
            found = another
            said += [_one_line(another, tokens)] if isinstance(another, UnknownOptionError) else []
    return said[0] if len(said) == 1 else "\n".join([f"{len(said)} unknown options:", *(f"  {each}" for each in said)])


def _without(tokens: Sequence[str], flag: str) -> list[str]:
    """Return the tokens without an option and what stands behind it."""
    at = next((k for k, token in enumerate(tokens) if token.partition("=")[0] == flag), len(tokens))
    follows = at + 1 < len(tokens) and tokens[at] == flag and not tokens[at + 1].startswith("--")
    return [*tokens[:at], *tokens[at + 1 + follows :]]


def _one_line(error: CycloptsError, tokens: Sequence[str]) -> str:
    if isinstance(error, UnusedCliTokensError):
        return f"{shlex.join(error.unused_tokens or [])}: not expected here; see --help"
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        name = error.argument.name
        if name.startswith("--") and not any(token.partition("=")[0] == name for token in tokens):
            return f"{' '.join(error.command_chain or ())}: {name} is missing; see --help"
    if isinstance(error, UnknownOptionError):
        flag = (error.token.keyword or error.token.value).partition("=")[0]
        if flag == DOTTED:
            return _not_here(error, tokens)
        if meant := [f"--{each}" for each in fl.parameters_named(flag.removeprefix("--"))]:
            return f"Unknown option: {flag}. Did you mean {' or '.join(meant)}?"
        if others := [f"`{name}`" for name, flags in flags_of_commands(app) if flag in flags]:
            here = " ".join(error.command_chain or ())
            return f"Unknown option: {flag}. {here} has none; it belongs to {', '.join(others)}"
    said = " ".join(str(error).split())
    if said.endswith(", ..."):  # of the verbs only the first eight are told
        verbs = [name for name in app if not name.startswith("-")]
        said = f"{said.partition(' Available commands:')[0]} Available commands: {', '.join(verbs)}."
    return said


def _not_here(error: UnknownOptionError, tokens: Sequence[str]) -> str:
    """Return what is said of a parameter of the system, given to a command that takes none as a flag."""
    dotted = next(token for token in gather(tokens) if token.startswith(f"{DOTTED}="))
    name, _, value = dotted.removeprefix(f"{DOTTED}=").partition("=")
    here = " ".join(error.command_chain or ())
    if here == "device set":
        return f"--{name}: is no option here; without dashes: {name}={value}"
    return f"Unknown option: --{name}. {here} takes no parameters of a system; see --help"


def _program() -> str:
    """Return how this program was called, so that a command it prints can be pasted."""
    called = sys.argv[0]
    if os.path.basename(called) == "__main__.py":
        return "python -m frictionloop"
    found = shutil.which("frictionloop")
    return "frictionloop" if found and os.path.realpath(found) == os.path.realpath(called) else shlex.quote(called)


USE = "--use"


def _used(tokens: Sequence[str]) -> list[str]:
    """Import what ``--use`` names, Python files or modules, and return the other tokens."""
    left: list[str] = []
    given = iter(tokens)
    for token in given:
        name, equals, value = token.partition("=")
        if name != USE:
            left.append(token)
            continue
        what = value if equals else next(given, None)
        if not what:
            raise fl.FrictionloopError(f"{USE}: needs a Python file or module")
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
        return
    except fl.FrictionloopError:
        raise
    except FileNotFoundError as error:
        why = f"{error.strerror}: {error.filename}"
    except ModuleNotFoundError as error:
        why = str(error) if error.name != what.partition(".")[0] else "no such module; files end in .py"
    except SyntaxError as error:
        why = f"SyntaxError in {error.filename}, line {error.lineno}: {error.msg}"
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        told = " ".join(str(error).split())
        why = f"{type(error).__name__} in {last.filename}, line {last.lineno}: {told}"
    raise fl.FrictionloopError(f"{USE} {what}: {why}")
