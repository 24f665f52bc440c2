"""Sphinx extension: in docstrings |x| is a magnitude and not reStructuredText's substitution."""

from __future__ import annotations

import re
from typing import Any

from sphinx.application import Sphinx


def magnitudes(_app: Sphinx, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Escape the bars that stand outside of literals."""
    for i, line in enumerate(lines):
        parts = re.split(r"(``.*?``)", line)
        lines[i] = "".join(part if part.startswith("``") else part.replace("|", "\\|") for part in parts)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.connect("autodoc-process-docstring", magnitudes)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
