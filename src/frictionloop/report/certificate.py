"""The certificate of a bench: one HTML page with what was measured, from which files, and what is still assumed."""

from __future__ import annotations

import json
import math
import os
import platform
import re
import shutil
from itertools import count
from pathlib import Path
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from frictionloop.figures.style import inline, svg
from frictionloop.findings.render import findings_html
from frictionloop.identification import Bench
from frictionloop.identification.entry_result import EntryResult, number_said
from frictionloop.quantities import replacing, unit_of
from frictionloop.quantities.version import package_version
from frictionloop.report import bench_figures
from frictionloop.report.certificate_figures import DRAWINGS
from frictionloop.report.importance import importance

TITLES = {
    "weights": "Weights",
    "hits": "Hits",
    "response": "Frequency response",
    "quiet": "Quiet",
    "slides": "Slides",
    **bench_figures.TITLES,
}


def write_certificate(found: Bench, path: str | os.PathLike[str]) -> Path | None:
    """Write the certificate; an older one is kept beside it under a number. Return where the older one is.

    Parameters
    ----------
    found : Bench
        From ``fl.identify.bench``.
    path : path
        Page (.html) to write.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written.
    """
    target = Path(path)
    page = certificate(found)
    kept = _free(target) if target.exists() else None
    if kept is not None:
        shutil.copy2(target, kept)
    with replacing(target) as beside:
        beside.write_text(page, encoding="utf-8")
    return kept


def _free(target: Path) -> Path:
    """Return the first numbered name beside a file that nothing has."""
    return next(path for k in count(1) if not (path := target.with_name(f"{target.stem}-{k}{target.suffix}")).exists())


def certificate(found: Bench) -> str:
    """Return the page: figures and tables of each measurement, the values, the files, and what is still assumed."""
    environment = Environment(
        loader=PackageLoader("frictionloop.report"),
        autoescape=select_autoescape(default_for_string=True, default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    parts = [(_title(part), part, _figures(part, k)) for k, part in enumerate(found.parts)]
    return environment.get_template("certificate.html.jinja").render(
        name=re.sub(r"\.toml$", "", found.project.name),
        version=package_version(),
        python=platform.python_version(),
        values=list(found.measured.values()),
        parts=parts,
        stated=[(name, _value(found, name), said) for name, said in found.stated.items()],
        assumed=[(name, _value(found, name), unit_of(name)) for name in found.assumed],
        important=importance(found),
        peak=lambda ms: "out of reach" if math.isnan(ms) else f"{ms:.2f}" if math.isfinite(ms) else "unstable",
        left=lambda n: f"{1e3 * n:.3g} mN" if math.isfinite(n) else "–",
        corner=found.resonance_error,
        design_flags=found.design_flags,
        corners=found.corners,
        findings=[each for each in found.findings if not any(each in part.findings for part in found.parts)],
        told=lambda some: Markup(findings_html(some)),
        number=number_said,
        range_db=found.range_db,
        crowd=_crowd(found),
        held=Markup(_held(found)),
        files=[each for part in found.parts for each in part.files],
    )


def _title(part: EntryResult) -> str:
    whose = part.curves.get("person")
    return TITLES[part.kind] + (f": {whose['finger']}" if whose else "")


def _crowd(found: Bench) -> Markup | None:
    if found.people is None:
        return None
    return Markup(inline(svg(bench_figures.crowd(found.people), "crowd"), "fingers"))


def _held(found: Bench) -> str:
    """Return values and corners as JSON that no tag can end, for ``identify compare`` and ``design controller``."""
    values: dict[str, Any] = {"measured": [each.to_dict() for each in found.measured.values()]}
    values["corners"] = [each._asdict() for each in found.corners]
    return json.dumps(values).replace("<", "\\u003c")


def _value(found: Bench, name: str) -> Any:
    value: Any = found.system
    for word in name.split("."):
        value = getattr(value, word)
    return f"{value:.5g}" if isinstance(value, float) else value


def _figures(part: EntryResult, number: int) -> list[Markup]:
    drawn = {name: draw(part.curves) for name, draw in DRAWINGS[part.kind].items() if name in part.curves}
    return [
        Markup(inline(svg(figure, f"c{number}-{k}"), f"{part.kind}: {name}"))
        for k, (name, figure) in enumerate(drawn.items())
    ]
