"""``reproduce``: compute everything, draw it, judge the claims, and write the report."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from frictionloop.loop.progress import Bar, progress_bar
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.report.claims import Claim, all_claims
from frictionloop.report.figures import drawings
from frictionloop.report.page import provenance, render
from frictionloop.report.results import Results, parts
from frictionloop.report.style import inline, svg

SCHEMA = 1
"""Version of claims.json."""
FIGURES = 23
"""Figures of the report, for the progress bar."""


def reproduce(folder: str | os.PathLike[str] = "report", *, progress: bool | None = None) -> list[Claim]:
    """Rebuild the paper's figures and claims: write index.html, claims.json and figures/*.svg into a folder.

    Parameters
    ----------
    folder : path
        Where to write; made if it does not exist. Files of the same names are replaced, each once it is complete.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Returns
    -------
    list of Claim
        Every claim with its verdict.

    Raises
    ------
    FrictionloopError
        The folder cannot be written; nothing has been computed then.
    """
    target = Path(folder)
    _prepare(target)
    with progress_bar("report", len(list(parts())) + FIGURES + 1, progress) as bar:
        results = Results(bar)
        # A figure stands in the folder as soon as what it shows is computed.
        with results.ahead():
            figures = _draw(results, target / "figures", bar)
        claims = all_claims(results)
        bar()
    _write(target / "claims.json", claims_json(claims, results))
    _write(target / "index.html", render(results, claims, figures))
    return claims


def claims_json(claims: Sequence[Claim], results: Results) -> str:
    """Return the claims and their provenance as JSON text."""
    tree = {"schema": SCHEMA, **provenance(results), "claims": [claim.as_dict() for claim in claims]}
    return json.dumps(tree, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _prepare(folder: Path) -> None:
    """Make the folder and see that it can be written to."""
    try:
        (folder / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{folder}: cannot be made ({error.strerror or error})") from None
    for place in (folder, folder / "figures"):
        if not os.access(place, os.W_OK):
            raise FrictionloopError(f"{place}: is not writable; choose another folder")


def _draw(results: Results, folder: Path, bar: Bar) -> Mapping[str, str]:
    """Draw and write every figure; return them as elements for the page."""
    elements = {}
    for drawing in drawings(results):
        text = svg(drawing.draw(), drawing.name)
        _write(folder / f"{drawing.name}.svg", text)
        elements[drawing.name] = inline(text, drawing.alt)
        bar()
    return elements


def _write(path: Path, text: str) -> None:
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
