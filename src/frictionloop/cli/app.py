"""The verbs, how their help looks, and what surrounds every one of them: --use, errors in one line, Ctrl-C, pipes."""

from __future__ import annotations

import importlib
import importlib.util
import inspect
import os
import re
import shlex
import shutil
import sys
import traceback
from collections.abc import Callable, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any, NamedTuple

from cyclopts import App, CycloptsError, Group, Parameter, UnknownOptionError, UnusedCliTokensError
from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

from frictionloop.cli import (
    compare,
    design_controller,
    design_plate,
    design_sensor,
    device,
    device_flash,
    device_play,
    device_recover,
    device_run,
    device_set,
    effect,
    effect_import,
    experiment,
    findings,
    firmware,
    identify,
    identify_bench,
    identify_compare,
    identify_run,
    reproduce,
    sessions,
    simulate,
    studio,
    sweep,
)
from frictionloop.cli.flags import DOTTED, gather
from frictionloop.cli.screen import Interrupted, forget_notes, say
from frictionloop.loop.progress import plain_lines
from frictionloop.quantities.units import FrictionloopError

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
            raise FrictionloopError(f"{OPTION}: needs a Python file or a module that registers blocks (fl.register)")
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
        raise FrictionloopError(f"{OPTION} {what}: there is no such module; a file must end in .py") from None
    except SyntaxError as error:
        where = f"SyntaxError in {error.filename}, line {error.lineno}"
        raise FrictionloopError(f"{OPTION} {what}: {where}: {error.msg}") from None
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        told = " ".join(str(error).split())
        raise FrictionloopError(
            f"{OPTION} {what}: {type(error).__name__} in {last.filename}, line {last.lineno}: {told}"
        ) from None


_MEANING = re.compile(r"^ {4}\S.*(?:\n {4}\S.*)*", re.MULTILINE)
_NO_LINES = Box("    \n" * 8)

HERE = Group("About", sort_key=9)
HELP_STYLE = DefaultFormatter(panel_spec=PanelSpec(box=_NO_LINES, padding=(0, 3), border_style="bold"))
"""Formatter of every help page."""


class Verb(NamedTuple):
    """A command, what its usage says after its name, and its examples."""

    command: Callable[..., Any]
    arguments: str
    examples: str


def new_app(name: str, text: str, **more: Any) -> App:
    """Return an app that looks like all others."""
    app = App(
        name=name,
        help=text,
        help_format="plaintext",
        help_formatter=HELP_STYLE,
        default_parameter=Parameter(negative=()),
        **more,
    )
    app["--help"].group = HERE
    return app


def add(app: App, path: str, verbs: dict[str, Verb], **more: Any) -> None:
    """Add verbs to an app; ``path`` is what is typed before their names."""
    for name, verb in verbs.items():
        # What a parameter means is one line, for the terminal to break.
        told = inspect.cleandoc(verb.command.__doc__ or "")
        verb.command.__doc__ = _MEANING.sub(lambda found: "    " + " ".join(found[0].split()), told)
        usage = f"{path} {name} {verb.arguments}"
        app.command(verb.command, name=name, usage=usage, help_epilogue=verb.examples, **more)


def group_app(name: str, text: str, example: str, group: Group, verbs: dict[str, Verb]) -> App:
    """Return the app of a verb whose commands are parts of one job; ``example`` is one of them."""
    path = f"frictionloop {name}"
    told = f"Each command has its own help with examples: {path} {example} --help"
    app = new_app(name, text, usage=f"{path} COMMAND [OPTIONS]", help_epilogue=told, group=group)
    add(app, path, verbs)
    return app


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
    {"simulate": _verb(simulate), "sweep": _verb(sweep), "compare": _verb(compare), "studio": _verb(studio)},
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
        "effect",
        "Effects, friction by place, time and touch: list them, preview what a finger gets, play them.",
        "show",
        LOOP,
        {
            "list": Verb(effect.list_effects, "[--json]", effect.LIST_EXAMPLES),
            "show": Verb(effect.show, effect.ARGUMENTS, effect.SHOW_EXAMPLES),
            "check": Verb(effect.check, effect.ARGUMENTS, effect.CHECK_EXAMPLES),
            "play": Verb(effect.play, effect.ARGUMENTS, effect.PLAY_EXAMPLES),
            "import": _verb(effect_import),
        },
    )
)
app.command(
    group_app(
        "identify",
        "From a lab's recordings to its bench: what is in a file, and what weights, hits and silence tell.",
        "channels",
        BENCH,
        {
            "channels": Verb(identify.channels, "FILE [OPTIONS]", identify.CHANNELS_EXAMPLES),
            "bench": _verb(identify_bench),
            "compare": _verb(identify_compare),
            "run": _verb(identify_run),
        },
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
        "experiment",
        "Experiments on the friction that is felt: protocols, sessions, simulated participants, reports.",
        "simulate",
        DEVICE,
        {
            "new": Verb(experiment.new, "FILE [OPTIONS]", experiment.NEW_EXAMPLES),
            "check": Verb(experiment.check, "PROTOCOL [OPTIONS]", experiment.CHECK_EXAMPLES),
            "run": Verb(sessions.run, "PROTOCOL --participant CODE [OPTIONS]", sessions.RUN_EXAMPLES),
            "resume": Verb(sessions.resume, "FOLDER", sessions.RESUME_EXAMPLES),
            "simulate": Verb(findings.simulate, "PROTOCOL [OPTIONS]", findings.SIMULATE_EXAMPLES),
            "report": Verb(findings.report, "FOLDER [OPTIONS]", findings.REPORT_EXAMPLES),
            "export": Verb(experiment.export, "FOLDER OUT [OPTIONS]", experiment.EXPORT_EXAMPLES),
            "power": Verb(experiment.power, "PROTOCOL [OPTIONS]", experiment.POWER_EXAMPLES),
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
            "play": _verb(device_play),
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
        with plain_lines(say):
            app(gather(used(tokens)), print_error=False, exit_on_error=False, result_action="return_value")
        return 0
    except CycloptsError as error:
        say(f"error: {_one_line(error, tokens)}")
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


def _one_line(error: CycloptsError, tokens: Sequence[str]) -> str:
    if isinstance(error, UnusedCliTokensError):
        return f"{shlex.join(error.unused_tokens or [])}: not expected here; see --help"
    if isinstance(error, UnknownOptionError):
        flag = (error.token.keyword or error.token.value).partition("=")[0]
        if flag == DOTTED:
            return _not_here(error, tokens)
        if meant := _parameters_named(flag):
            return f"Unknown option: {flag}. Did you mean {' or '.join(meant)}?"
    said = " ".join(str(error).split())
    if said.endswith(", ..."):  # of the verbs only the first eight are told
        said = f"{said.partition(' Available commands:')[0]} Available commands: {', '.join(_verbs())}."
    return said


def _verbs() -> list[str]:
    return [name for name in app if not name.startswith("-")]


def _not_here(error: UnknownOptionError, tokens: Sequence[str]) -> str:
    """Return what is said of a parameter of the system, given to a command that takes none as a flag."""
    dotted = next(token for token in gather(tokens) if token.startswith(f"{DOTTED}="))
    name, _, value = dotted.removeprefix(f"{DOTTED}=").partition("=")
    here = " ".join(error.command_chain or ())
    if here == "device set":
        return f"--{name}: is no option here; without dashes: {name}={value}"
    return f"Unknown option: --{name}. {here} takes no parameters of a system; see --help"


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
