"""The finger of the bench beside a measured slide, the model's side: three minutes.

``python -m studies.finger_validation`` keeps median and 5 to 95 % of every statistic of 200 fingers, as drawn and at
the level that was measured, for *pages/finger-validation.md*.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

import frictionloop as fl
from studies.kept import keep
from studies.slide import slide_statistics
from studies.slide_onset import stick_to_slip

PLAIN = fl.bench().evolve(
    {
        "controller.kp": 0.0,  # the command then is the clamp's low end,
        "controller.ki": 0.0,
        "controller.model.max_amplitude_um": 1e-3,  # which is 1 nm of vibration
        "motion.speed_mm_s": 40.0,
        "motion.stroke_mm": 100.0,
        "motion.reversal_s": 0.48,  # 250 mm/s2 from rest
    }
)
LEVEL = {"friction.nominal_n": 0.2, "motion.tremor_um": 3.0}
SCALES = {"stiffness_n_m": 1e-3} | dict.fromkeys(("fall_s", "fall_m", "rise_s", "travel_m"), 1e3)
"""What is told in N/mm, ms and mm."""


def slides(changes: Mapping[str, Any], count: int = 200) -> dict[str, np.ndarray]:
    """Return statistics of fingers, each pressed on at rest and then slid for 1.6 s."""
    found = []
    for finger in fl.fingers(count, seed=0):
        run = fl.simulate(PLAIN.evolve({**finger, "motion.load_n": 0.52, **changes}), duration_s=1.6, seed=0)
        each = slide_statistics(run, 0.26, 1.46)._asdict()
        if "motion.tremor_um" in changes:  # else it does not rest at t = 0
            each |= stick_to_slip(run, 0.0, 0.2)._asdict()
        found.append(each)
    return {name: np.array([each[name] for each in found]) for name in found[0]}


def told(values: np.ndarray, scale: float) -> str:
    """Return the median and 5 to 95 %."""
    low, median, high = np.percentile(scale * values, (5, 50, 95))
    return f"{median:.3f} [{low:.3f} to {high:.3f}]"


def main() -> None:
    """Keep a row for each statistic: as drawn, and at the measured level."""
    drawn, level = slides({}), slides(LEVEL)
    rows = [
        (name, told(drawn[name], scale) if name in drawn else "", told(values, scale))
        for name, values in level.items()
        for scale in [SCALES.get(name, 1.0)]
    ]
    keep("finger-validation", "finger_validation", ("statistic", "as drawn", "at the measured level"), rows)


if __name__ == "__main__":
    main()
