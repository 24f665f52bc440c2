"""What every figure shares: one style, and drawing to files that are the same bytes every time."""

from frictionloop.quantities.lazily import lazily

HOMES = {"style": "new_figure one_panel png styled svg write_both"}
__getattr__ = lazily(__name__, HOMES)
