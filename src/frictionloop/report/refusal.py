"""The picture of a refusal: what an analysis saw when it refused."""

from __future__ import annotations

import os
from io import BytesIO

from matplotlib.figure import Figure
from PIL import Image  # matplotlib needs it too

from frictionloop.figures.style import png
from frictionloop.identification.entry_result import Refused
from frictionloop.quantities import replacing
from frictionloop.report.certificate_figures import DRAWINGS


def refused_figure(refused: Refused) -> Figure | None:
    """Return the first figure of what an analysis saw when it refused, None if it saw nothing that is drawn."""
    found = (draw(refused.curves) for name, draw in DRAWINGS[refused.kind].items() if name in refused.curves)
    return next(found, None)


def draw_refused(refused: Refused, path: str | os.PathLike[str]) -> Refused:
    """Draw what an analysis saw when it refused, and return the refusal with the picture's name, if anything was drawn.

    Parameters
    ----------
    refused : Refused
        From an analysis of `frictionloop.identification`.
    path : path
        Picture (.png) to write: one figure below the other.

    Raises
    ------
    FrictionloopError
        For a path that cannot be written.
    """
    found = [draw(refused.curves) for name, draw in DRAWINGS[refused.kind].items() if name in refused.curves]
    if not found:
        return refused
    images = [Image.open(BytesIO(png(figure))).convert("RGB") for figure in found]
    page = Image.new("RGB", (max(each.width for each in images), sum(each.height for each in images)), "white")
    top = 0
    for each in images:
        page.paste(each, (0, top))
        top += each.height
    with replacing(path) as beside:
        page.save(beside, format="png")
    return Refused(f"{refused}; picture: {path}", refused.kind, refused.curves)
