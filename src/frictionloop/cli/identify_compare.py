"""``frictionloop identify compare``: two certificates of a bench, and what has changed between them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen

if TYPE_CHECKING:
    from frictionloop.identification.compare import Change

ARGUMENTS = "BEFORE AFTER [OPTIONS]"
EXAMPLES = """Examples

  frictionloop identify compare certificate-1.html certificate.html
"""
Before = Annotated[Path, Parameter(name="BEFORE", help="The older certificate (.html, or --json).", group=flags.SYSTEM)]
After = Annotated[Path, Parameter(name="AFTER", help="The newer one.", group=flags.SYSTEM)]


def command(before: Before, after: After, /, *, json: flags.Json = False) -> None:
    """Compare two certificates of a bench: which values have changed beyond their uncertainty."""
    from frictionloop.identification.compare import compare

    found = compare(before, after)
    if json:
        rows = [
            {
                "path": each.path,
                "before": None if each.before is None else each.before.value,
                "after": None if each.after is None else each.after.value,
                "dates": each.dates,
                "change": each.share,
                "chance": each.chance,
                "changed": each.changed,
            }
            for each in found
        ]
        screen.show_json({"before": str(before), "after": str(after), "values": rows})
        return
    screen.show(screen.columns([("value", "before", "after", "change", "what to think"), *map(_row, found)]))
    changed = [each.path for each in found if each.changed]
    screen.show("", f"changed: {', '.join(changed)}" if changed else "nothing has changed beyond its uncertainty")


def _row(each: Change) -> tuple[str, ...]:
    old, new = (("not measured" if one is None else str(one)) for one in (each.before, each.after))
    if math.isnan(each.chance):
        return (each.path, old, new, "", "measured once")
    verdict = "CHANGED" if each.changed else "the same"
    return (each.path, old, new, f"{each.share:+.2%}", f"{verdict}: chance {each.chance:.2g}")
