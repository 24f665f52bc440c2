"""The codes of findings and errors as a table, from the catalogue that `frictionloop explain` reads."""

from __future__ import annotations

from tables import table

from frictionloop.findings import CATALOGUE
from frictionloop.findings.catalogue import SEVERITIES


def findings() -> str:
    """Return code, title and explanation, the worst severity first, then as the catalogue has them."""
    rows = [
        (f"`{code}`", severity, f"{each.title}. {' '.join(each.explanation.split())}".replace("|", "\\|"))
        for severity in SEVERITIES
        for code, each in CATALOGUE.items()
        if each.severity == severity
    ]
    return table(("Code", "Severity", "What it means, and what to do"), rows)
