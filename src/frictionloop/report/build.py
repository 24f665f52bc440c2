"""``reproduce``: compute, draw, judge the claims, and write the report; or some figures and claims alone."""

from __future__ import annotations

import difflib
import json
import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future
from contextlib import contextmanager
from pathlib import Path

from matplotlib.figure import Figure

from frictionloop.loop.progress import Bar, progress_bar
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.report.claims import Claim, all_claims, claim_ids, one_claim
from frictionloop.report.figures import DRAWINGS
from frictionloop.report.page import Drawn, provenance, render
from frictionloop.report.results import Results, parts
from frictionloop.report.style import write_svg

SCHEMA = 1
"""Version of claims.json."""


def reproduce(
    folder: str | os.PathLike[str] = "report", *, only: Sequence[str] = (), progress: bool | None = None
) -> list[Claim]:
    """Rebuild the paper's figures and claims: write index.html, claims.json and figures/*.svg into a folder.

    Parameters
    ----------
    folder : path
        Where to write; made if it does not exist. Files of the same names are replaced, each once it is complete.
    only : sequence of str, optional
        Names of figures and claims, such as "fig-5a" and "kp-optimum": compute no more than these need, and write no
        page.
    progress : bool, optional
        Show a progress bar; by default on a terminal.

    Returns
    -------
    list of Claim
        Every claim with its verdict, or those of ``only``.

    Raises
    ------
    FrictionloopError
        The folder cannot be written, or a name is unknown; nothing has been computed then.
    """
    target = Path(folder)
    _check_names(only)
    wanted = [name for name in DRAWINGS if name in only or not only]
    if wanted:
        _prepare(target)
    if only:
        # Only what is asked for counts on the bar, not the parts that it needs.
        with progress_bar("report", len(only), progress) as bar:
            results = Results(bar.inner())
            _draw(wanted, results, target / "figures", bar, _at_once)
            return [one_claim(id, results) for id in only if id not in DRAWINGS]
    with progress_bar("report", len(list(parts())) + len(wanted) + 1, progress) as bar:
        results = Results(bar)
        with _beside() as beside:
            drawn = _draw(wanted, results, target / "figures", bar, beside)
            claims = all_claims(results)
            bar.doing("drawing")
            figures = {name: Drawn(text.result(), seeds) for name, (text, seeds) in drawn.items()}
        bar()
    _write(target / "claims.json", claims_json(claims, results))
    _write(target / "index.html", render(results, claims, figures, target))
    return claims


def claims_json(claims: Sequence[Claim], results: Results) -> str:
    """Return the claims and their provenance as JSON text."""
    tree = {"schema": SCHEMA, **provenance(results), "claims": [claim.as_dict() for claim in claims]}
    return json.dumps(tree, indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def _check_names(names: Iterable[str]) -> None:
    known = [*DRAWINGS, *claim_ids()]
    for name in names:
        if name not in known:
            near = " or ".join(difflib.get_close_matches(name, known)) or "fig-5a or closed-loop-r2"
            raise FrictionloopError(f"only = {name!r}: is neither a figure nor a claim; a name is accepted, as {near}")


def _prepare(folder: Path) -> None:
    """Make the folder and see that it can be written to."""
    try:
        (folder / "figures").mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{folder}: cannot be made ({error.strerror or error})") from None
    for place in (folder, folder / "figures"):
        if not os.access(place, os.W_OK):
            raise FrictionloopError(f"{place}: is not writable; choose another folder")


Started = Callable[[Callable[..., str], Figure, str, Path], "Future[str]"]
"""Has a figure written: `_at_once` does it here, `_beside` in a second process."""


def _at_once(write: Callable[..., str], figure: Figure, name: str, path: Path) -> Future[str]:
    """Return what is written already."""
    future: Future[str] = Future()
    future.set_result(write(figure, name, path))
    return future


@contextmanager
def _beside() -> Iterator[Started]:
    """Let a second process write figures while this one computes what the next ones show."""
    from joblib.externals.loky import ProcessPoolExecutor

    with ProcessPoolExecutor(1) as pool:
        yield pool.submit


def _draw(
    names: Iterable[str], results: Results, folder: Path, bar: Bar, started: Started
) -> dict[str, tuple[Future[str], str]]:
    """Have each figure written as soon as what it shows is computed; return its text to come, and its seeds."""
    drawn = {}
    for name in names:
        watched = results.watched()
        text = started(write_svg, DRAWINGS[name](watched), name, folder / f"{name}.svg")
        text.add_done_callback(lambda _: bar())
        drawn[name] = text, watched.seeds()
        for earlier, _ in drawn.values():
            if earlier.done():
                earlier.result()  # what could not be written is told now
    return drawn


def _write(path: Path, text: str) -> None:
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
