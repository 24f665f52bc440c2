"""Sphinx extension: on the pages of ``executed_pages``, code blocks run and show what they print and draw."""

from __future__ import annotations

import tempfile
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import matplotlib as mpl
from docutils import nodes
from matplotlib.collections import QuadMesh
from matplotlib.figure import Figure
from page import LANGUAGES, Page
from sphinx.application import Sphinx
from sphinx.errors import ExtensionError
from sphinx.transforms import SphinxTransform

from frictionloop.figures.style import svg
from frictionloop.loop.registered_blocks import forget

FIGURES = "_build/figures"
"""Folder of the drawn figures, below the documentation's sources."""


class Executed(SphinxTransform):
    """Run the blocks of a page and put their output beneath them."""

    default_priority = 300

    def apply(self, **_: Any) -> None:
        """Change the document in place."""
        name = self.env.docname
        if not any(fnmatch(name, pattern) for pattern in self.config.executed_pages):
            return
        with tempfile.TemporaryDirectory() as folder:
            page = Page(Path(folder), self.config.executed_style)
            for block in list(self.document.findall(nodes.literal_block)):
                if block.get("language") in LANGUAGES:
                    self._run(page, block)
        forget()  # what the page has registered is not of the next

    def _run(self, page: Page, block: nodes.literal_block) -> None:
        try:
            text, figures = page.run(block["language"], block.astext())
        except Exception as error:
            where = f"{self.env.doc2path(self.env.docname)}:{block.line}"
            raise ExtensionError(f"{where}: {type(error).__name__}: {error}") from error
        if block["language"] == "console":
            block.parent.replace(block, _literal(text, "console", []))
            return
        output = [_literal(text.rstrip(), "text", ["output"])] if text.strip() else []
        output += [self._image(page, figure) for figure in figures]
        position = block.parent.index(block) + 1
        block.parent[position:position] = output

    def _image(self, page: Page, figure: Figure) -> nodes.image:
        page.names["_drawn"] = page.names.get("_drawn", 0) + 1
        name = f"{self.env.docname.replace('/', '-')}-{page.names['_drawn']}"
        file = Path(self.env.srcdir) / FIGURES / f"{name}.svg"
        file.parent.mkdir(parents=True, exist_ok=True)
        for mesh in figure.findobj(QuadMesh):  # as vectors its cells would show seams
            mesh.set_rasterized(True)
        with mpl.rc_context({"savefig.dpi": 200}):
            file.write_text(svg(figure, name), encoding="utf-8")
        return nodes.image(uri=f"/{FIGURES}/{name}.svg", alt=_alt(figure), classes=["drawn"])


def _literal(text: str, language: str, classes: list[str]) -> nodes.literal_block:
    return nodes.literal_block(text, text, language=language, classes=classes)


def _alt(figure: Figure) -> str:
    """Return what a figure shows, from its labels."""
    parts = [f"{a.get_title(loc='left') or a.get_title()}: {a.get_ylabel()} over {a.get_xlabel()}" for a in figure.axes]
    return "; ".join(part.strip(": ") for part in parts)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the extension."""
    app.add_config_value("executed_pages", [], "env", list)
    app.add_config_value("executed_style", {}, "", dict)
    app.add_transform(Executed)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
