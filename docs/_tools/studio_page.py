"""Sphinx extension: writes the page of a recorded run that docs/studio.md shows, by what ``studio --export`` calls."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from sphinx.application import Sphinx

import frictionloop as fl
from frictionloop.cli.effect import LAW
from frictionloop.studio.replay import page_of, played, stroked

NAME = "studio-demo.html"
SEED = 0


def demo() -> str:
    """Return the page: a finger that the model does not know, under the ghost of the studio."""
    system = fl.bench().evolve({**LAW, "setpoint": {"kind": "effect"}, "friction.nominal_n": 1.3})
    return page_of([played(stroked(system, SEED), "ghost finger on a grating")], "The studio: a recorded run")


def write(app: Sphinx, error: Exception | None) -> None:
    """Write the page beside the others."""
    if error is None and app.builder.format == "html":
        Path(app.outdir, "_static", NAME).write_text(demo(), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Register with Sphinx."""
    app.connect("build-finished", write)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
