"""The controller on the microcontroller: its parameter table, its image.

export        a system as parameter table: words, numbers with units, the system itself
build         the image that runs it, with the table beside it
law           a system's control law as C99, for a board of one's own
"""

from __future__ import annotations

from frictionloop.quantities.lazily import lazily

HOMES = {"exported": "Built Exported build export", "law_source": "LawSource law", "board_fit": "board_findings"}
__getattr__ = lazily(__name__, HOMES)
__all__ = [name for names in HOMES.values() for name in names.split()]


def __dir__() -> list[str]:
    return sorted(__all__)
