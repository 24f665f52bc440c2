"""The catalogue: of every code its severity, title, template and explanation, from *catalogue.toml*."""

from __future__ import annotations

import tomllib
from importlib.resources import files
from typing import Literal, NamedTuple, get_args

from frictionloop.quantities import check_known

Severity = Literal["error", "warning", "note"]
"""Worst first."""
SEVERITIES: tuple[Severity, ...] = get_args(Severity)


class Entry(NamedTuple):
    """What the catalogue says of a code."""

    severity: Severity
    title: str
    """At most 12 words."""
    template: str
    """At most 25 words around {value}, {unit}, {limit}, {where}, {remedy} and what else there is; of an error ""."""
    explanation: str
    """At most 60 words."""


_TEXT = files("frictionloop.findings").joinpath("catalogue.toml").read_text(encoding="utf-8")
CATALOGUE = {code: Entry(**({"template": ""} | each)) for code, each in tomllib.loads(_TEXT).items()}
"""Entries by code, such as RING-MOIST."""


def explain(code: str) -> Entry:
    """Return what the catalogue says of a code.

    Parameters
    ----------
    code
        Of a finding or an error, such as RING-MOIST.

    Raises
    ------
    FrictionloopError
        For a code that is not in it, naming near ones.
    """
    check_known("code", [code], CATALOGUE)
    return CATALOGUE[code]
