"""Sphinx extension: writes the studio as one page, which docs/studio.md shows and the front page links."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import frictionloop as fl


def write(app: Sphinx, error: Exception | None) -> None:
    """Write the page beside the others."""
    if error is None and app.builder.format == "html":
        fl.studio.export(Path(app.outdir, "play.html"))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
