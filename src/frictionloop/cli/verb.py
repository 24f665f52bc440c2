"""What a verb is, how its help looks, and apps of several verbs."""

from __future__ import annotations

import inspect
import re
from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from cyclopts import App, Group, Parameter
from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

_MEANING = re.compile(r"^ {4}\S.*(?:\n {4}\S.*)*", re.MULTILINE)
_NO_LINES = Box("    \n" * 8)

WIDEST = 76
"""Columns of an example."""
HERE = Group("About", sort_key=9)
HELP_STYLE = DefaultFormatter(panel_spec=PanelSpec(box=_NO_LINES, padding=(0, 3), border_style="bold"))
"""Formatter of every help page."""


class Verb(NamedTuple):
    """A command, its name with what its usage says after that, and what its examples have after it."""

    command: Callable[..., Any]
    usage: str
    examples: tuple[str, ...]


def verb(usage: str, *examples: str) -> Callable[[Callable[..., Any]], Verb]:
    """Decorate a function that is a `Verb`."""
    return lambda command: Verb(command, usage, examples)


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


def add(app: App, path: str, verbs: Iterable[Verb], **more: Any) -> None:
    """Add verbs to an app; ``path`` is what is typed before their names."""
    for verb in verbs:
        # What a parameter means is one line, for the terminal to break.
        told = inspect.cleandoc(verb.command.__doc__ or "")
        verb.command.__doc__ = _MEANING.sub(lambda found: "    " + " ".join(found[0].split()), told)
        name = verb.usage.split()[0]
        said = {"usage": f"{path} {verb.usage}", "help_epilogue": _examples(f"{path} {name}", verb)}
        app.command(verb.command, name=name, **said, **more)


def _examples(command: str, verb: Verb) -> str:
    """Return the examples of a verb, each broken before an option where it is longer than a line."""
    found = "Examples\n"
    for example in verb.examples:
        line = f"\n  {command}"
        for part in re.split(r" (?=--)", example):
            if len(line) + len(part) > WIDEST:
                found, line = f"{found}{line} \\", "\n     "
            line += f" {part}" if part else ""
        found += line
    return f"{found}\n"


def add_group(app: App, name: str, text: str, example: str, group: Group, verbs: Iterable[Verb]) -> None:
    """Add a verb whose commands are parts of one job; ``example`` is one of them."""
    path = f"frictionloop {name}"
    told = f"Examples: {path} {example} --help"
    found = new_app(name, text, usage=f"{path} COMMAND [OPTIONS]", help_epilogue=told, group=group)
    add(found, path, verbs)
    app.command(found)


def flags_of_commands(app: App, above: tuple[str, ...] = ()) -> Iterator[tuple[str, set[str]]]:
    """Yield the name of each command, with those of its groups, and its flags."""
    for name in app:
        if name.startswith("-"):
            continue
        command, chain = app[name], (*above, name)
        if command.default_command is not None:
            found = command.assemble_argument_collection()
            yield " ".join(chain), {flag for argument in found for flag in argument.names}
        yield from flags_of_commands(command, chain)
