"""``frictionloop reproduce``: the paper's figures and claims on one page."""

from __future__ import annotations

import json as json_text
from pathlib import Path

from frictionloop.cli import flags, screen
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "[OPTIONS]"
EXAMPLES = """Examples

  frictionloop reproduce
  frictionloop reproduce --out my-report --json
"""


def command(
    *,
    out: flags.Result[Path] = Path("report"),
    json: flags.Json = False,
) -> None:
    """Rebuild the paper's figures and check its numbers: index.html and claims.json in a folder.

    Parameters
    ----------
    out
        Folder for the page and the claims.
    """
    if out.is_file():
        raise FrictionloopError(f"out = {str(out)!r}: is a file; must be a folder, or a new one")

    from frictionloop.report import claims_tables, reproduce, summary

    claims = reproduce(out)
    page = out / "index.html"
    if json:
        screen.show_json(json_text.loads((out / "claims.json").read_text(encoding="utf-8")) | {"page": page})
    else:
        screen.show(*claims_tables(claims), *summary(claims), f"The page: {page}")
