"""The page: one HTML file that needs nothing beside it."""

from __future__ import annotations

import hashlib
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup, escape

from frictionloop.quantities.version import package_version
from frictionloop.report import gains, noise, protocol
from frictionloop.report.beyond_table import beyond_rows
from frictionloop.report.claims import Claim
from frictionloop.report.claims.table import SYMBOLS, grouped, shown, with_unit
from frictionloop.report.counts import FIRST, counts, told
from frictionloop.report.facts import facts
from frictionloop.report.people import bench_systems
from frictionloop.report.results import Results
from frictionloop.report.tolerances import RULES

FIRST_NOTE_OF_DEVICE = 24
_SYMBOLS = ((r"\bK([pi])\b", r"<i>K</i><sub>\1</sub>"), (r"\b([fkmσ])_([a-z])(?![a-z_])", r"<i>\1</i><sub>\2</sub>"))


def maths(text: str) -> Markup:
    """Return text with Kp, Ki, f_a and the like set as symbols."""
    marked = str(escape(text))
    for pattern, replacement in _SYMBOLS:
        marked = re.sub(pattern, replacement, marked)
    return Markup(marked)


def accepted(claim: Claim) -> str:
    """Return the numbers a claim accepts, in words."""
    low, high = claim.accepted
    low_text, high_text = (shown(end, claim.digits) if math.isfinite(end) else "" for end in claim.accepted)
    if low == high:
        return low_text
    if math.isinf(high):
        return f"at least {low_text}"
    return f"at most {high_text}" if math.isinf(low) else f"{low_text} to {high_text}"


def notes_of(claim: Claim) -> str:
    """Return the page of notes on the paper that has a claim's."""
    return "paper-notes-device.md" if claim.note >= FIRST_NOTE_OF_DEVICE else "paper-notes.md"


def provenance(results: Results) -> dict[str, Any]:
    """Return what a reader needs to make the same page again: version, digests of the systems, seeds."""
    systems = results.systems | bench_systems()
    digests = {name: hashlib.sha256(system.model_dump_json().encode()).hexdigest() for name, system in systems.items()}
    strokes = len(protocol.LOADS) * len(protocol.LEVELS_N)
    return {
        "version": package_version(),
        "systems": digests,
        "seeds": {"traces": 1, "maps": 2, "cuts": gains.SEEDS, "noise": noise.SEEDS, "rigs": 1, "strokes": strokes},
    }


def render(results: Results, claims: Sequence[Claim], figures: Mapping[str, str]) -> str:
    """Return the page's HTML from computed results, claims, and figures as SVG elements by name."""
    environment = Environment(
        loader=PackageLoader("frictionloop.report"),
        autoescape=select_autoescape(default_for_string=True, default=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters |= {"maths": maths, "accepted": accepted}
    environment.globals |= {
        "with_unit": with_unit,
        "shown": shown,
        "symbols": SYMBOLS,
        "rules": RULES,
        "notes_of": notes_of,
    }
    named = {claim.id: claim for claim in claims}
    return environment.get_template("index.html.jinja").render(
        groups=list(grouped(claims).items()),
        first=[named[id] for id in FIRST],
        counts=counts(claims),
        told=told(claims),
        figures={name: Markup(figure) for name, figure in figures.items()},
        facts=facts(results, claims),
        beyond=beyond_rows(results.beyond),
        provenance=provenance(results),
    )
