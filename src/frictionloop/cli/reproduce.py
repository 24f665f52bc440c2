"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

import json as json_text
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.extra import needed

ARGUMENTS = "[OPTIONS]"
EXAMPLES = """Examples

  frictionloop reproduce
  frictionloop reproduce --out my-report --json
  frictionloop reproduce --only fig-5a,closed-loop-r2
  frictionloop reproduce --only fig-5a --sensor.resonance_hz 200
"""

Changed = Annotated[
    list[str] | None,
    Parameter(
        name=flags.DOTTED,
        metavar="VALUE",
        help="Change the bench, such as --sensor.resonance_hz 200, or give PI gains, --controller.kp 0.0064 "
        "--controller.ki 13.8. For --only fig-5a, and of the bench fig-5a-printed, which are not the paper's then: "
        "title and file say what was changed, and no statement is judged.",
        group=flags.RESULT,
    ),
]


def command(
    *,
    out: flags.Result[Path] = Path("report"),
    only: Annotated[flags.Result[str | None], Parameter(metavar="NAME,...")] = None,
    overrides: Changed = None,
    json: flags.Json = False,
) -> None:
    """Rebuild the paper's figures and check its numbers: index.html and claims.json in a folder.

    Parameters
    ----------
    out
        Folder for the page and the claims.
    only
        Make these figures and claims alone, with their numbers, and no page: fig-5a,closed-loop-r2. The page names
        each.
    """
    needed("matplotlib", "matplotlib", "report")
    needed("jinja2", "jinja2", "report")
    with screen.waiting("loading what simulates and draws"):
        from frictionloop.report.build import reproduce
        from frictionloop.report.claims.told import claims_tables, summary

    names = [] if only is None else [name.strip() for name in only.split(",")]
    if names or overrides:
        _some(names, flags.overrides_of(overrides), out, json)
        return
    claims = reproduce(out)
    page = out / "index.html"
    if json:
        screen.show_json(json_text.loads((out / "claims.json").read_text(encoding="utf-8")) | {"page": page})
    else:
        screen.show(*claims_tables(claims), *summary(claims), f"The page: {page}")


def _some(names: list[str], changes: dict[str, Any], out: Path, json: bool) -> None:
    """Make some figures and claims, and show them with all of their numbers."""
    from frictionloop.cli.figure_text import figure_text
    from frictionloop.parameters import bench
    from frictionloop.parameters.unit_sanity import differing, unusual
    from frictionloop.report.alone import alone
    from frictionloop.report.changed import check
    from frictionloop.report.claims.told import claim_lines

    if changes:
        check(names, changes)
        changed = bench().evolve(changes)
        screen.note_findings([*unusual(changed), *differing(changed, changes)])
        screen.tell_notes()
    claims, figures = alone(out, names, changes)
    if json:
        screen.show_json(
            {"claims": [claim.as_dict() for claim in claims], "figures": [figure.as_dict() for figure in figures]}
        )
        return
    for claim in claims:
        screen.show(*claim_lines(claim))
    for figure in figures:
        screen.show(*figure_text(figure))
