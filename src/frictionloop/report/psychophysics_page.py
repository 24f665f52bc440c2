"""The page of a study: who took part, what counted, psychometric functions, thresholds and sequences."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pandas  # type: ignore[import-untyped]
from jinja2 import Environment, PackageLoader

from frictionloop.experiments.study_figures import answers, converging, functions, sequences, thresholds
from frictionloop.experiments.study_run import TABLES, Study
from frictionloop.experiments.study_summary import funnel, measure, named_found
from frictionloop.figures.style import inline, svg
from frictionloop.quantities import replacing


def page(found: Study) -> str:
    """Return a study as one self-contained HTML page."""
    protocol, trials, fitted = found.protocol, found.trials, found.fits
    name, _ = measure(protocol)
    figures = {
        "thresholds": (thresholds(protocol, fitted), f"{name} by condition and participant"),
        "sequences": (sequences(protocol, trials), "Levels asked for over trials"),
    }
    if name in ("threshold", "JND"):
        figures["functions"] = (functions(protocol, trials, fitted), "Psychometric functions by condition")
        figures["convergence"] = (converging(protocol, trials), f"{name} from trial to trial")
    else:
        figures["answers"] = (answers(protocol, trials), "Answers over levels")
    drawn = {name: inline(svg(figure, name), label) for name, (figure, label) in figures.items()}
    shown = Environment(loader=PackageLoader("frictionloop.report"), autoescape=True, trim_blocks=True)
    shown.filters["number"] = number
    return shown.get_template("experiment.html.jinja").render(
        protocol=protocol,
        about=found.about,
        people=trials["participant"].nunique(),
        figures=drawn,
        groups=[*found.groups.to_dict("records"), *found.contrasts.to_dict("records")],
        named=named_found(protocol),
        fits=fitted.to_dict("records"),
        pooled=found.pooled.to_dict("records"),
        overdispersed=_overdispersed(fitted),
        reaches=found.reaches.to_dict("records"),
        funnel=_funnel_rows(trials),
        measure=measure(protocol),
        weber="weber" in fitted,
        at_edge=int(fitted["at_edge"].eq(True).sum()) if "at_edge" in fitted else 0,
        conditions=list(dict.fromkeys(trials["condition"])),
    )


def write_page(found: Study, path: Path) -> None:
    """Write the page of a study, and beside it its tables as TSV.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    text = page(found)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    for name in TABLES:
        table = getattr(found, name)
        if len(table.columns):
            with replacing(path.with_name(f"{path.stem}-{name}.tsv")) as beside:
                table.to_csv(beside, sep="\t", index=False, na_rep="n/a")


def _overdispersed(fitted: pandas.DataFrame) -> tuple[int, int] | None:
    """Return how many functions have more dispersion than chance gives, and how many have any."""
    if "dispersion" not in fitted:
        return None
    known = fitted.dropna(subset=["dispersion"])
    return int((known["dispersion"] > known["dispersion_limit"]).sum()), len(known)


def number(value: Any) -> str:
    """Return a number for a person, three digits."""
    return "–" if value is None or not np.isfinite(value) else f"{value:.3g}"


def _funnel_rows(trials: pandas.DataFrame) -> list[tuple[str, list[int]]]:
    """Return what became of trials, a row for each fate and a number for each condition."""
    table = funnel(trials).pivot_table("trials", "what", "condition", fill_value=0, sort=False, aggfunc="sum")
    names = list(dict.fromkeys(trials["condition"]))
    order = sorted(
        table.index, key=lambda what: (what == "counted", what.startswith(("rep", "kept")), what != "presented")
    )
    return [(what, [int(table.loc[what, name]) for name in names]) for what in order]
