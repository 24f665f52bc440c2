"""Sphinx extension: docstrings as this package writes them.

|x| is a magnitude and not reStructuredText's substitution, and what a parameter block accepts stands on its own page
instead of in a list of its types.
"""

from __future__ import annotations

import importlib
import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

from frictionloop.parameters.block import Block


def magnitudes(_app: Sphinx, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Escape the bars that stand outside of literals."""
    for i, line in enumerate(lines):
        parts = re.split(r"(``.*?``)", line)
        lines[i] = "".join(part if part.startswith("``") else part.replace("|", "\\|") for part in parts)


def blocks(_app: Sphinx, _domain: str, kind: str, content: nodes.Element) -> None:
    """Take the list of types out of the description of a parameter block."""
    module = importlib.import_module(content.parent[0]["module"] or "frictionloop") if kind == "class" else None
    described = getattr(module, content.parent[0]["fullname"], None)
    if isinstance(described, type) and issubclass(described, Block):
        for fields in [child for child in content.children if isinstance(child, nodes.field_list)]:
            content.remove(fields)


def signatures(_app: Sphinx, kind: str, _name: str, of: Any, _options: Any, given: str, returns: str) -> Any:
    """Leave the values out of a default that is a block."""
    if kind == "class" and issubclass(of, Block) and given:
        return "(" + re.sub(r"(=\w+)\((?:[^()]|\([^()]*\))*\)", r"\1()", given[1:-1]) + ")", returns
    return None


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension; autodoc adds the types at priority 500."""
    app.connect("autodoc-process-docstring", magnitudes)
    app.connect("autodoc-process-signature", signatures)
    app.connect("object-description-transform", blocks, priority=800)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
