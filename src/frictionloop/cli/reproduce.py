"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

import json as json_text
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.extra import needed

ARGUMENTS = "[OPTIONS]"
EXAMPLES = """Examples

  frictionloop reproduce
  frictionloop reproduce --out my-report --json
  frictionloop reproduce --only fig-5a,closed-loop-r2
"""


def command(
    *,
    out: flags.Result[Path] = Path("report"),
    only: Annotated[flags.Result[str | None], Parameter(metavar="NAME,...")] = None,
    json: flags.Json = False,
) -> None:
    """Rebuild the paper's figures and check its numbers: index.html and claims.json in a folder.

    Parameters
    ----------
    out
        Folder for the page and the claims.
    only
        Make these figures and claims alone, and no page: fig-5a,closed-loop-r2. The page names each.
    """
    needed("matplotlib", "matplotlib", "report")
    needed("jinja2", "jinja2", "report")
    with screen.waiting("loading what simulates and draws"):
        from frictionloop.report.build import reproduce
        from frictionloop.report.claims.told import claims_tables, summary

    if only is not None:
        _some([name.strip() for name in only.split(",")], out, json)
        return
    claims = reproduce(out)
    page = out / "index.html"
    if json:
        screen.show_json(json_text.loads((out / "claims.json").read_text(encoding="utf-8")) | {"page": page})
    else:
        screen.show(*claims_tables(claims), *summary(claims), f"The page: {page}")


def _some(names: list[str], out: Path, json: bool) -> None:
    """Make some figures and claims, and show the claims with all of their numbers."""
    from frictionloop.report.build import reproduce
    from frictionloop.report.claims.told import claim_lines

    claims = reproduce(out, only=names)
    figures = [out / "figures" / f"{name}.svg" for name in names if name not in {claim.id for claim in claims}]
    if json:
        screen.show_json({"claims": [claim.as_dict() for claim in claims], "figures": figures})
        return
    for claim in claims:
        screen.show(*claim_lines(claim))
    screen.show(*(f"The figure: {path}" for path in figures))
