"""The whole report: compute, draw, judge the claims, and write."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path

from matplotlib.figure import Figure

from frictionloop.figures.style import write_both
from frictionloop.loop.progress import Bar, progress_bar
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.report.cited import cited, command_of
from frictionloop.report.claims import Claim, all_claims
from frictionloop.report.figures import DRAWINGS
from frictionloop.report.page import Drawn, provenance, render
from frictionloop.report.results import Results, parts

SCHEMA = 1
"""Version of claims.json."""


def build_report(target: Path, progress: bool | None = None) -> list[Claim]:
    """Write index.html, claims.json and figures/*.svg, *.png into a folder that is there; return every claim."""
    with progress_bar("report", len(list(parts())) + len(DRAWINGS) + 1, progress) as bar:
        results = Results(bar)
        with _beside() as beside:
            drawn = _draw(results, target / "figures", bar, beside)
            claims = all_claims(results)
            bar.doing("drawing")
            figures = {name: Drawn(text.result(), seeds) for name, (text, seeds) in drawn.items()}
        bar()
    _write(target / "claims.json", claims_json(claims, results))
    _write(target / "index.html", render(results, claims, figures, target))
    return claims


def claims_json(claims: Sequence[Claim], results: Results) -> str:
    """Return the claims and their provenance as JSON text."""
    tree = {"schema": SCHEMA, **provenance(results), "claims": [claim.to_dict() for claim in claims]}
    return json.dumps(tree, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def prepare(folder: Path) -> None:
    """Make the folder and see that it can be written to."""
    try:
        (folder / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{folder}: cannot be made ({error.strerror or error})") from None
    for place in (folder, folder / "figures"):
        if not os.access(place, os.W_OK):
            raise FrictionloopError(f"{place}: is not writable")


Started = Callable[[Callable[..., str], Figure, str, Path, str], "Future[str]"]
"""Has a figure written, in a second process."""


@contextmanager
def _beside() -> Iterator[Started]:
    """Let a second process write figures while this one computes what the next ones show."""
    from joblib.externals.loky import ProcessPoolExecutor

    with ProcessPoolExecutor(1) as pool:
        yield pool.submit


def _draw(results: Results, folder: Path, bar: Bar, started: Started) -> dict[str, tuple[Future[str], str]]:
    """Have each figure written as soon as what it shows is computed; return its text to come, and its seeds."""
    drawn = {}
    for name, draw in DRAWINGS.items():
        watched = results.watched()
        figure = draw(watched)
        source = " · ".join(cited(command_of(name), watched.seeds()))
        text = started(write_both, figure, name, folder / f"{name}.svg", source)
        text.add_done_callback(lambda _: bar())
        drawn[name] = text, watched.seeds()
        for earlier, _ in drawn.values():
            if earlier.done():
                earlier.result()  # what could not be written is told now
    return drawn


def _write(path: Path, text: str) -> None:
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
