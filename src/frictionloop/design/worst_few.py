"""The best gains for many plants, found on the few that limit them and then looked at on all."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from frictionloop.analysis.state_space import Array
from frictionloop.design.gain_search import Gains, best_gains
from frictionloop.design.plants import Plants

AT_ONCE = 4
"""Plants beyond their limit that are looked at from then on, the worst first (chosen for speed)."""
ROUNDING = 1e-9
"""Share by which a limit or a residual may be missed by rounding."""


@dataclass
class WorstFew:
    """Plants, by number, that have limited gains so far: of hundreds a handful, and the same for notches alike."""

    few: set[int] = field(default_factory=lambda: {0})

    def gains(self, plants: Plants, peaks: Sequence[float], density: Array | None, refine: bool) -> Gains:
        """Return `best_gains` of all plants.

        The best gains of fewer plants are no dearer: if they hold on all, and leave no more on any, no better ones do.
        With a disturbance that is so up to the steps of the ki that are tried.
        """
        limits, most_kp = np.asarray(peaks, dtype=float), plants.kp_limit()
        while True:
            some = sorted(self.few)
            found = best_gains(plants.some(some), limits[some].tolist(), density, refine, most_kp)
            if found.ki == 0.0 or not (more := _beyond(plants, limits, density, found) - self.few):
                return found
            self.few |= more


def _beyond(plants: Plants, limits: Array, density: Array | None, found: Gains) -> set[int]:
    """Return the worst plants on which gains are unstable, beyond their Ms, or leave more of a disturbance."""
    law = plants.pi(found.kp, found.ki)
    returned = np.min(np.abs(plants.returned(law)), axis=1) * limits
    excess = np.where(plants.stable(law), 1.0 - returned, np.inf)
    worst = np.argsort(-excess)[:AT_ONCE]
    more = {int(each) for each in worst if excess[each] > ROUNDING}
    if density is not None:
        left = plants.residual_n(law, density)
        if left.max() > (found.cost + 1.0) * (1.0 + ROUNDING):
            more.add(int(np.argmax(left)))
    return more
