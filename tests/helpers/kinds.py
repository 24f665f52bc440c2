"""What a block of a System may be."""

from __future__ import annotations

import frictionloop as fl
from frictionloop.parameters import refusals


def kinds_of(block):
    """The parameter classes of a block."""
    return refusals.kinds_of(fl.System, block)
