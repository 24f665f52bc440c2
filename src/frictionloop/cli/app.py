"""The verbs, and what surrounds every one of them: errors in one line, Ctrl-C, closed pipes."""

from __future__ import annotations

import os
import shlex
import shutil
import sys
from collections.abc import Sequence
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from cyclopts import CycloptsError, Group, UnknownOptionError, UnusedCliTokensError

from frictionloop.cli import (
    compare,
    design_controller,
    design_plate,
    design_sensor,
    device,
    device_flash,
    device_recover,
    device_run,
    device_set,
    firmware,
    reproduce,
    simulate,
    sweep,
)
from frictionloop.cli.flags import gather
from frictionloop.cli.helptext import HERE, Verb, add, group_app, new_app
from frictionloop.cli.screen import Interrupted, forget_notes, say
from frictionloop.cli.use import used
from frictionloop.quantities.units import FrictionloopError

NOT_WRITTEN, BAD_INPUT, INTERRUPTED = 1, 2, 130
"""Exit codes; the last is 128 plus the number of the signal, as shells give it."""

PAPER, LOOP, BENCH, DEVICE = (
    Group(name, sort_key=1 + place) for place, name in enumerate(("The paper", "The loop", "The bench", "The device"))
)


def _version() -> str:
    try:
        return f"frictionloop {version('frictionloop')}"
    except PackageNotFoundError:
        return "frictionloop, not installed as a package"


def _verb(module: Any) -> Verb:
    """Return the verb of a module with one; what it computes with is imported inside."""
    return Verb(module.command, module.ARGUMENTS, module.EXAMPLES)


app = new_app(
    "frictionloop",
    "Closed-loop control of fingertip friction on ultrasonic surfaces: simulate it, sweep it, report on it.",
    help_epilogue="Each command has its own help with examples: frictionloop simulate --help\n\n"
    "A law, friction law, signal or metric of your own: --use FILE.py runs the file, which registers it, first.",
    version=_version,
    suppress_keyboard_interrupt=False,
)
app["--version"].group = HERE
add(app, "frictionloop", {"reproduce": _verb(reproduce)}, group=PAPER)
add(
    app,
    "frictionloop",
    {"simulate": _verb(simulate), "sweep": _verb(sweep), "compare": _verb(compare)},
    group=LOOP,
)
app.command(
    group_app(
        "design",
        "Size a part of the bench: from its geometry to what it does, or the other way round.",
        "sensor",
        BENCH,
        {"sensor": _verb(design_sensor), "plate": _verb(design_plate), "controller": _verb(design_controller)},
    )
)
app.command(
    group_app(
        "firmware",
        "The controller on the microcontroller: its parameter table and its image.",
        "export",
        DEVICE,
        {
            "export": Verb(firmware.export, firmware.ARGUMENTS, firmware.EXPORT_EXAMPLES),
            "build": Verb(firmware.build, firmware.ARGUMENTS, firmware.BUILD_EXAMPLES),
        },
    )
)
app.command(
    group_app(
        "device",
        "A board on this machine's ports, or one that is simulated: look at it, set it up, run it, flash it.",
        "run",
        DEVICE,
        {
            "list": Verb(device.list_ports, "[--json]", device.LIST_EXAMPLES),
            "info": Verb(device.info, "ADDRESS [--json]", device.INFO_EXAMPLES),
            "set": _verb(device_set),
            "run": _verb(device_run),
            "recover": _verb(device_recover),
            "clear": Verb(device.clear, "ADDRESS [--json]", device.CLEAR_EXAMPLES),
            "monitor": Verb(device.monitor, "ADDRESS [OPTIONS]", device.MONITOR_EXAMPLES),
            "flash": _verb(device_flash),
        },
    )
)


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
    forget_notes()
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
