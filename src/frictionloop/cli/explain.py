"""``frictionloop explain``: what a code of a finding or an error means, and what to do."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.cli.verb import verb
from frictionloop.findings import CATALOGUE, explain
from frictionloop.findings.catalogue import SEVERITIES

SCHEMA = {"schema": "explain/1"}


@verb("explain [CODE] [--all] [--json]", "RING-MOIST", "")
def command(
    code: Annotated[str | None, Parameter(name="CODE")] = None,
    /,
    *,
    all: Annotated[bool, Parameter(help="List all codes, with titles.", show_default=False)] = False,
    json: flags.Json = False,
) -> None:
    """Explain a code, or list all of them.

    Parameters
    ----------
    code
        Code of a finding or an error, such as RING-MOIST.
    """
    if code is None:
        listed = {name: each.title for name, each in CATALOGUE.items()}
        rows = list(listed.items()) if all else _by_severity()
        screen.show_json(SCHEMA | {"codes": listed}) if json else screen.show(screen.columns(rows))
        return
    found = explain(code.upper())
    if json:
        screen.show_json(SCHEMA | {"code": code.upper(), **found._asdict()})
        return
    told = screen.wrapped(" ".join(found.explanation.split()))
    screen.show(code.upper(), screen.wrapped(found.title), "", told)


def _by_severity() -> list[tuple[str, str]]:
    """Return the codes of each severity, those of notes as their number."""
    codes = {each: [name for name, entry in CATALOGUE.items() if entry.severity == each] for each in SEVERITIES}
    last = codes.pop(SEVERITIES[-1])
    return [*((each, "  ".join(some)) for each, some in codes.items()), (SEVERITIES[-1], f"{len(last)}: --all")]
