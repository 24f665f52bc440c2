"""``frictionloop explain``: what a code of a finding or an error means, and what to do."""

from __future__ import annotations

from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.findings import CATALOGUE, entry

ARGUMENTS, SCHEMA = "[CODE] [--json]", {"schema": "explain/1"}
EXAMPLES = (
    "RING-MOIST",
    "",
)


def command(code: Annotated[str | None, Parameter(name="CODE")] = None, /, *, json: flags.Json = False) -> None:
    """Explain a code, or list all of them.

    Parameters
    ----------
    code
        Code of a finding or an error, such as RING-MOIST.
    """
    if code is None:
        listed = {name: each.title for name, each in CATALOGUE.items()}
        screen.show_json(SCHEMA | {"codes": listed}) if json else screen.show(screen.columns(list(listed.items())))
        return
    found = entry(code.upper())
    if json:
        screen.show_json(SCHEMA | {"code": code.upper(), **found._asdict()})
        return
    told = screen.wrapped(" ".join(found.explanation.split()))
    screen.show(f"{code.upper()}, {found.severity}", screen.wrapped(found.title), "", told)
