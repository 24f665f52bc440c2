"""The observer laws on the bench: what they leave beside a PI law, and on which side the resonance may be believed."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl

BELIEVED = {
    "controller.model.nominal_n": 2.2, "controller.model.resonance_hz": 139.0, "controller.model.sensor_hz": 350.0,
    "motion.stroke_mm": 240.0,
}  # fmt: skip
CALM = {"motion.tremor_um": 30.0, "motion.tremor_n": 0.03}


def people():
    drawn = fl.fingers(60, 23)
    able = fl.capable(drawn, contact_s=10.0)["capable"].values
    return [{**each, **CALM} for each, yes in zip(drawn, able, strict=True) if yes][:12]


def residual_n(overrides, length_um, **sensor):
    system = fl.bench().evolve({"finger.slip_length_um": length_um, "motion.stroke_mm": 240.0, **overrides, **sensor})
    swept = fl.sweep(system, people(), 4.0, metrics=["rms_error"], score_from_s=1.0, progress=False)
    return float(np.median(swept["rms_error"].values))


@pytest.mark.parametrize("length_um", [11.5, 0.0])
def test_both_leave_less_than_the_retuned_pi(length_um):
    pi = residual_n(fl.RETUNED, length_um)
    for kind in ("observer", "super_twisting"):
        assert residual_n({"controller.kind": kind, **BELIEVED}, length_um) < 0.75 * pi


@pytest.mark.parametrize("kind", ["observer", "super_twisting"])
def test_a_resonance_believed_too_high_is_fatal_and_one_too_low_is_benign(kind):
    """Under a slider, which damps nothing: the true one 10 % below what is believed, and up to 10 % above."""
    law = {"controller.kind": kind, **BELIEVED}
    below, right, above, far = (residual_n(law, 0.0, **{"sensor.resonance_hz": hz}) for hz in (125, 139, 146, 153))
    assert below > 2.0 * right
    assert max(above, far) < 1.1 * right
