"""The paper's figures and claims, rebuilt: one self-contained page, SVG figures, and the claims as JSON."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from frictionloop.quantities.extra import needed

if TYPE_CHECKING:
    from frictionloop.report.build import reproduce
    from frictionloop.report.claims import Claim, Verdict, claim_lines, claims_tables
    from frictionloop.report.claims.told import summary

__all__ = ["Claim", "Verdict", "claim_lines", "claims_tables", "reproduce", "summary"]

_HOME = {
    "reproduce": "build",
    "Claim": "claims",
    "Verdict": "claims",
    "claim_lines": "claims",
    "claims_tables": "claims",
    "summary": "counts",
}


def __getattr__(name: str) -> Any:
    """Import a name when it is first used: drawing libraries load only when something is drawn."""
    if name not in _HOME:
        raise AttributeError(f"module 'frictionloop.report' has no attribute {name!r}")
    if name == "reproduce":
        needed("matplotlib", "matplotlib", "report")
        needed("jinja2", "jinja2", "report")
    return getattr(importlib.import_module(f"frictionloop.report.{_HOME[name]}"), name)
