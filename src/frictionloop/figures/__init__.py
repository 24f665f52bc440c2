"""What every figure shares: one style, and drawing to files that are the same bytes every time."""

from frictionloop.quantities.optional_libraries import lazily

HOMES = {"style": "new_figure one_panel png styled svg write_both"}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
