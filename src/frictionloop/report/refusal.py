"""The picture of a refusal: what an analysis saw when it refused."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image  # matplotlib needs it too

from frictionloop.identification.refused import Refused
from frictionloop.report.certificate_figures import DRAWINGS


def refused_figure(refused: Refused) -> Figure | None:
    """Return the first figure of what an analysis saw when it refused, None if it saw nothing that is drawn."""
    found = (draw(refused.curves) for name, draw in DRAWINGS[refused.kind].items() if name in refused.curves)
    return next(found, None)


def draw_refused(refused: Refused, path: Path) -> bool:
    """Draw what an analysis saw when it refused, one figure below the other; return whether there was anything."""
    found = [draw(refused.curves) for name, draw in DRAWINGS[refused.kind].items() if name in refused.curves]
    if not found:
        return False
    images = []
    for figure in found:
        buffer = BytesIO()
        figure.savefig(buffer, format="png", dpi=120)
        images.append(Image.open(buffer).convert("RGB"))
    page = Image.new("RGB", (max(each.width for each in images), sum(each.height for each in images)), "white")
    top = 0
    for each in images:
        page.paste(each, (0, top))
        top += each.height
    page.save(path)
    return True
