"""A designed controller with its gains lowered until its limits hold on other people's fingers too."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import xarray as xr

from frictionloop.design.corners import corners
from frictionloop.design.elsewhere import elsewhere
from frictionloop.design.held import CHECKED, ENDS, LOADS, lowered
from frictionloop.design.synthesis import LEAST_KI
from frictionloop.design.wanted import Designed, Wanted
from frictionloop.parameters import System


class ForFingers(NamedTuple):
    """A controller for fingers, and what was made of its gains."""

    designed: Designed
    factor: float = 1.0
    """On the gains before; 1 where they hold on all fingers, or were not lowered."""
    wanting: bool = False
    """Whether they do not hold on all and were not lowered: too little would be left, or the law has none of them."""
    least_ki: float | None = None
    """Where they were not lowered, as the ki that holds on all is too small to be of use: that ki, 1/s."""


def for_fingers(system: System, found: Designed, many: xr.Dataset, wanted: Wanted) -> ForFingers:
    """Return a controller with PI gains that hold on all fingers which were looked at, looked at wherever it was.

    ``many`` is what `check_fingers` finds of the controller. Of its gains every smaller factor holds as well, so the
    least factor of a finger holds on all. Gains of another law stay, and so do those that would leave a ki below
    `LEAST_KI`, with which nothing is lowered that is felt.
    """
    factor = float(np.nanmin(many["gain_factor"].values))
    if factor >= 1.0:
        return ForFingers(found)
    lower = lowered(found, factor)
    if lower is None:
        return ForFingers(found, wanting=True)
    if (ki := float(lower.overrides["controller.ki"])) <= LEAST_KI:
        return ForFingers(found, wanting=True, least_ki=ki)
    there = system.evolve(lower.overrides)
    at = corners(there, wanted.limits, wanted.over(CHECKED, LOADS), wanted.lean)
    more = elsewhere(there, wanted.limits, wanted.over(ENDS, LOADS), wanted.lean)
    return ForFingers(lower._replace(corners=tuple(at), elsewhere=more), factor)
