"""Claims of Sec. 4.1 about the plate and the gains on the device."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from frictionloop.analysis import kp_limit
from frictionloop.hardware.plate.readings import FREQUENCY_HZ, LINES, plate_readings
from frictionloop.parameters import bench
from frictionloop.parameters.plate_design import Side
from frictionloop.report.claims.claim import Claim, Group, python
from frictionloop.report.device import CONTROLLERS, IDEAL
from frictionloop.report.numbers import number
from frictionloop.report.results import Results
from frictionloop.report.tolerances import LAST_DIGIT, as_printed

SIDES: dict[Side, str] = {"length": "16 lines along 255 mm", "width": "16 lines across 140 mm"}
BENCH_ITSELF = "the bench"
VARIANTS: dict[str, Mapping[str, Any]] = {
    BENCH_ITSELF: {},
    "without computing delay": {"controller.delay_s": 0.0},
    "without the resonance": {"sensor.kind": "lowpass"},
    "without either": CONTROLLERS[IDEAL],
}
"""The bench and what keeps the printed gains from holding on it."""


def _mode(_: Results) -> Claim:
    found = {(each.wave_along, each.solved_for): each for each in plate_readings()}
    sixteen = {SIDES[side]: 1e-3 * found[side, "frequency"].mode.frequency_hz for side in SIDES}
    fits = found["width", "lines"].mode
    thick = found["length", "thickness"].mode.thickness_mm
    return Claim(
        id="plate-mode",
        of=Group.SLIP,
        note=31,
        quantity="16 lines along 255 mm",
        meant=f"{fits.nodal_lines} lines across the 140 mm",
        title="255 × 140 × 3 mm³ of glass have a 16×0 mode at 46 kHz",
        place="Sec. 4.1",
        quote="A glass plate of dimension 255 × 140 × 3 mm³ vibrating at 46 kHz in a 16 × 0 mode",
        published=1e-3 * FREQUENCY_HZ,
        unit="kHz",
        measure=f"frequency of the mode with {LINES} nodal lines on 3 mm of glass (thick-plate theory)",
        readings=sixteen,
        accepted=as_printed(1e-3 * FREQUENCY_HZ),
        tolerance=LAST_DIGIT,
        explanation=f"No plate has all three numbers. 3 mm and 46 kHz are a mode of {fits.nodal_lines} lines across "
        f"the 140 mm side ({number(1e-3 * fits.frequency_hz)} kHz), which the bench takes; 16 lines along 255 mm at "
        f"46 kHz need {thick:.1f} mm of glass.",
        command=python(
            "from frictionloop.hardware.plate.readings import *; print(next(each.mode.frequency_hz * 1e-3 "
            "for each in plate_readings() if (each.wave_along, each.solved_for) == ('length', 'frequency')))"
        ),
    )


def _stable(_: Results) -> Claim:
    limits = {name: kp_limit(bench().evolve(changes)) for name, changes in VARIANTS.items()}
    return Claim(
        id="printed-gains-stable",
        of=Group.DEVICE,
        note=32,
        quantity="largest stable Kp",
        title="The printed gains are stable on the device",
        place="Sec. 4.1",
        quote="The controller parameters were set to Kp = 10 and Ki = 2",
        published=10.0,
        measure="largest Kp at which the linear loop is stable, Ki = 2",
        readings={BENCH_ITSELF: limits[BENCH_ITSELF]},
        assumed={name: limit for name, limit in limits.items() if name != BENCH_ITSELF},
        accepted=(10.0, math.inf),
        tolerance="stable: the printed gain lies below the limit",
        explanation=f"With the measured resonance and 300 µs of delay and hold the limit is Kp = "
        f"{limits[BENCH_ITSELF]:.2f}. The resonance alone forbids 10, and so does one period of computing "
        f"({limits['without the resonance']:.1f}). On the device a scale between table and converter may hide, so "
        f"that its 10 need not be 10 N/N.",
        command=python("import frictionloop as fl; print(fl.kp_limit(fl.bench()))"),
    )


CLAIMS = (_mode, _stable)
