"""The verbs, and what surrounds every one of them: errors in one line, Ctrl-C, closed pipes."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version

from cyclopts import App, CycloptsError, Group, Parameter, UnknownOptionError, UnusedCliTokensError

from frictionloop.cli import compare, design, device, firmware, reproduce, simulate, sweep
from frictionloop.cli.flags import gather
from frictionloop.cli.helptext import HELP_STYLE
from frictionloop.cli.screen import Interrupted, say
from frictionloop.cli.use import used
from frictionloop.quantities.units import FrictionloopError

NOT_WRITTEN, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Exit codes; the last is 128 plus the number of the signal, as shells give it."""

PAPER = Group("The paper", sort_key=1)
LOOP = Group("The loop", sort_key=2)
HERE = Group("About", sort_key=9)


def _version() -> str:
    try:
        return f"frictionloop {version('frictionloop')}"
    except PackageNotFoundError:
        return "frictionloop, not installed as a package"


app = App(
    name="frictionloop",
    help="Closed-loop control of fingertip friction on ultrasonic surfaces: simulate it, sweep it, report on it.",
    help_epilogue="Each command has its own help with examples: frictionloop simulate --help\n\n"
    "A law, friction law, signal or metric of your own: --use FILE.py runs the file, which registers it, first.",
    help_format="plaintext",
    help_formatter=HELP_STYLE,
    version=_version,
    default_parameter=Parameter(negative=()),
    suppress_keyboard_interrupt=False,
)
app["--help"].group = app["--version"].group = HERE
# A verb is a module with a command, its ARGUMENTS and its EXAMPLES; what it computes with is imported inside.
for verb, group in ((reproduce, PAPER), (simulate, LOOP), (sweep, LOOP), (compare, LOOP)):
    name = verb.__name__.rsplit(".", 1)[-1]
    usage = f"frictionloop {name} {verb.ARGUMENTS}"
    app.command(verb.command, name=name, usage=usage, help_epilogue=verb.EXAMPLES, group=group)
app.command(design.app)
app.command(firmware.app)
app.command(device.app)


def main(tokens: Sequence[str] | None = None) -> None:
    """Run one command and leave with its exit code: 0, 2 for bad input, 130 after Ctrl-C."""
    try:
        code = _run(list(sys.argv[1:] if tokens is None else tokens))
        print(end="", flush=True)
    except OSError as error:
        # A reader that has left (head, less) is no error. What Python still wants to flush at its exit goes nowhere.
        if not isinstance(error, BrokenPipeError):
            say(f"error: output: {error.strerror or error}")
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        code = NOT_WRITTEN
    raise SystemExit(code)


def _run(tokens: list[str]) -> int:
    try:
        app(gather(used(tokens)), print_error=False, exit_on_error=False, result_action="return_value")
        return 0
    except CycloptsError as error:
        say(f"error: {_one_line(error)}")
    except FrictionloopError as error:
        say(f"error: {error}")
    except Interrupted as stop:
        say(f"interrupted: {stop}")
        if stop.resumable:
            say(f"continue with: {_program()} {shlex.join([*tokens, *([] if '--resume' in tokens else ['--resume'])])}")
        return INTERRUPTED
    except KeyboardInterrupt as stop:
        say(f"interrupted: {stop}" if str(stop) else "interrupted")
        return INTERRUPTED
    return BAD_INPUT


def _one_line(error: CycloptsError) -> str:
    if isinstance(error, UnusedCliTokensError):
        return f"{shlex.join(error.unused_tokens or [])}: not expected here; see --help"
    if isinstance(error, UnknownOptionError):
        flag = (error.token.keyword or error.token.value).partition("=")[0]
        if meant := _parameters_named(flag):
            return f"Unknown option: {flag}. Did you mean {' or '.join(meant)}?"
    return " ".join(str(error).split())


def _parameters_named(flag: str) -> list[str]:
    """Return the dotted flags of the parameters that a flag without dots is the name, or the start of the name, of."""
    from frictionloop.parameters import System
    from frictionloop.parameters.wording import known_names

    asked = flag.removeprefix("--").replace("-", "_")
    names = {f"--{name}": name.rsplit(".", 1)[-1] for name in known_names(System, {}) if not name.endswith(".kind")}
    same = [name for name, leaf in names.items() if leaf == asked]
    blocks = [f"--{asked}.kind"] if asked in System.model_fields else []
    begun = [name for name, leaf in names.items() if asked and leaf.startswith(f"{asked}_")]
    return (same or blocks or begun)[:3]


def _program() -> str:
    """Return how this program was called, so that a command it prints can be pasted."""
    called = sys.argv[0]
    if os.path.basename(called) == "__main__.py":
        return "python -m frictionloop"
    found = shutil.which("frictionloop")
    return "frictionloop" if found and os.path.realpath(found) == os.path.realpath(called) else shlex.quote(called)
