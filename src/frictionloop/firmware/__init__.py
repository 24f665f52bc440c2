"""The controller on the microcontroller: its parameter table, its image.

export        a system as parameter table: words, numbers with units, the system itself
build         the image that runs it, with the table beside it
law           a system's control law as C99, for a board of one's own
"""

from __future__ import annotations

from frictionloop.quantities.optional_libraries import lazily

HOMES = {
    "system_export": "Built Exported build export",
    "standalone_law": "LawSource law",
    "board_compatibility": "board_findings",
}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
