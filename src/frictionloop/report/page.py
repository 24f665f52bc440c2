"""The whole report: compute, draw, judge the claims, and write one HTML file that needs nothing beside it."""

from __future__ import annotations

import hashlib
import json
import os
import re
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from markupsafe import Markup, escape

from frictionloop.figures.style import inline, write_both
from frictionloop.loop.progress import Bar, progress_bar
from frictionloop.parameters import RETUNED
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.code_version import cited_version
from frictionloop.report import paper_protocol
from frictionloop.report.claims import COUNTED, Claim, Group, all_claims, others, statements
from frictionloop.report.claims.device_claims import LOAD_MOVES
from frictionloop.report.control_law_study import beyond_rows
from frictionloop.report.effect_arrivals import rows as arrival_rows
from frictionloop.report.number_text import milli, shown, with_unit
from frictionloop.report.other_fingers import bench_systems, the_finger
from frictionloop.report.page_templates import templates
from frictionloop.report.paper_figures import FIGURES
from frictionloop.report.results import FIELDS, Results, cited, command_of, parts
from frictionloop.report.tolerances import RULES

SCHEMA = 2
"""Version of claims.json."""


def build_report(target: Path, progress: bool | None = None) -> list[Claim]:
    """Write index.html, claims.json and figures/*.svg, *.png into a folder that is there; return every claim."""
    from joblib.externals.loky import ProcessPoolExecutor

    with progress_bar("report", len(list(parts())) + len(FIGURES) + 1, progress) as bar:
        results = Results(bar)
        with ProcessPoolExecutor(1) as beside:  # writes figures while this process computes what the next ones show
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
    tree = {"schema": SCHEMA, **provenance(results), "statements": [each.to_dict() for each in statements(claims)]}
    tree["claims"] = [each.to_dict() for each in claims]
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


def _draw(results: Results, folder: Path, bar: Bar, beside: Executor) -> dict[str, tuple[Future[str], str]]:
    """Have each figure written as soon as what it shows is computed; return its text to come, and its seeds."""
    drawn = {}
    for name, each in FIGURES.items():
        watched = results.watched()
        figure = each.draw(watched)
        source = " · ".join(cited(command_of(name), watched.seeds()))
        text = beside.submit(write_both, figure, name, folder / f"{name}.svg", source)
        text.add_done_callback(lambda _: bar())
        drawn[name] = text, watched.seeds()
        for earlier, _ in drawn.values():
            if earlier.done():
                earlier.result()  # what could not be written is told now
    return drawn


def _write(path: Path, text: str) -> None:
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")


_SYMBOLS = ((r"\bK([pi])\b", r"<i>K</i><sub>\1</sub>"), (r"\b([fkmσ])_([a-z])(?![a-z_])", r"<i>\1</i><sub>\2</sub>"))


def maths(text: str) -> Markup:
    """Return text with Kp, Ki, f_a and the like set as symbols."""
    marked = str(escape(text))
    for pattern, replacement in _SYMBOLS:
        marked = re.sub(pattern, replacement, marked)
    return Markup(marked)


class Drawn(NamedTuple):
    """A figure as SVG text, and the seeds of the runs that it shows."""

    svg: str
    seeds: str


def provenance(results: Results) -> dict[str, Any]:
    """Return what a reader needs to make the same page again: version, digests of the systems, seeds by field."""
    systems = results.systems | bench_systems()
    digests = {name: hashlib.sha256(system.model_dump_json().encode()).hexdigest() for name, system in systems.items()}
    seeds = {name: field.seeds for name, field in FIELDS.items()}
    return {"version": cited_version(), "systems": digests, "seeds": seeds}


def docs_link(page: str, folder: Path) -> str:
    """Return where a page of the docs is as seen from a folder: the built page if there is one, else its source."""
    docs = Path(__file__).resolve().parents[3] / "docs"
    if not docs.is_dir():
        return f"../docs/{page}.md"
    built = docs / "_build" / "html" / f"{page}.html"
    return Path(os.path.relpath(built if built.exists() else docs / f"{page}.md", folder.resolve())).as_posix()


def render(
    results: Results, claims: Sequence[Claim], figures: Mapping[str, Drawn], folder: Path = Path("report")
) -> str:
    """Return the page's HTML from computed results, claims, and figures by name, for the folder it will lie in."""
    environment = templates()

    def figure(name: str, alt: str) -> Markup:
        drawn = figures[name]
        return Markup(inline(drawn.svg, alt)) + _citation(command_of(name), drawn.seeds)

    by_id = {claim.id: claim for claim in claims}
    environment.filters |= {
        "maths": maths,
        "number": shown,
        "milli": milli,
        "percent": "{:.0%}".format,
        "whole": "{:.0f}".format,
    }
    environment.globals |= {
        "figure": figure,
        "citation": _citation,
        "by_id": by_id,
        "value": lambda id, name: by_id[id].all_values[name],
        "told": lambda id, name: by_id[id].told[name],
        "with_unit": with_unit,
        "shown": shown,
        "rules": RULES,
        "docs_link": partial(docs_link, folder=folder),
    }
    return environment.get_template("index.html.jinja").render(
        statements=statements(claims),
        others=others(claims),
        counted=COUNTED,
        left_out={group: [claim for claim in claims if claim.group is group] for group in Group},
        retuned=RETUNED,
        built=docs_link("glossary", folder).endswith(".html"),
        finger=the_finger(),
        finger_number=paper_protocol.chosen(paper_protocol.population()),
        study=results.beyond,
        laws=beyond_rows(results.beyond),
        arrivals=results.arrivals,
        arrived=list(arrival_rows(results.arrivals)),
        provenance=provenance(results),
        moving=LOAD_MOVES,
        checked=results.checked,
    )


def _citation(command: str, seeds: str) -> Markup:
    """Return the line that a figure or a number is cited by: version, command, seeds."""
    version, command, words = cited(command, seeds)
    return Markup('<p class="cite"><span>{} · </span><code>{}</code> · {}</p>').format(version, command, words)
