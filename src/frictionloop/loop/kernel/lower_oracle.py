"""From Systems to the numbers of an oracle's trials."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from frictionloop.loop.kernel.lower_finger import contact_of_step
from frictionloop.loop.kernel.slab import Slab
from frictionloop.loop.kernel.structure import delay_periods, kernel_of, substeps_of, switch_s
from frictionloop.parameters import OracleController, System
from frictionloop.physics.plate import plate_coefficients

STEPS, LANDING, TRIALS = 4, 8, 3
"""Of a trial; more of any changes the residual on fingers(100, 3) by less than 0.1 mN (docs/oracle).

In 8 periods of 200 us the envelope of 100 Hz gets from rest to 63 % of what the drive can do.
"""


def plan_of(system: System) -> dict[str, int]:
    """Return how an oracle looks ahead; nothing is looked at for other controllers."""
    c = system.controller
    if not isinstance(c, OracleController) or kernel_of(system) != "substeps":
        return {}
    substeps, late = substeps_of(system), delay_periods(system)
    rest = round(switch_s(system) * c.rate_hz * substeps)
    ahead = late * substeps + rest
    return {
        "preview": c.preview,
        "late": late,
        "predicted": ahead,
        "steps": STEPS,
        "landing": LANDING,
        "trials": TRIALS,
    }


def lower_oracle(slab: Slab, systems: Sequence[System]) -> None:
    """Set the rows that only an oracle reads."""
    period = 1.0 / systems[0].controller.rate_hz
    h = period / STEPS
    slab.view("trial_coefficients")[:] = np.array(
        [
            (*contact_of_step(s, h), compliance, *plate_coefficients(s.plate, h))
            for s, compliance in zip(systems, slab.view("compliance")[0], strict=True)
        ]
    ).T
    slab.view("trial_decay")[0] = [plate_coefficients(s.plate, period).whole for s in systems]
