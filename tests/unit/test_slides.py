"""Slides of a finger: found in a long record, with friction and load exponent of known ones."""

from __future__ import annotations

import numpy as np
import pytest
from finger_strokes import strokes

import frictionloop as fl
from frictionloop.identification import friction


def test_slides_are_found_with_their_friction():
    found = friction(strokes(share=0.01))
    assert len(found.slides) == 6
    assert [np.sign(slide.speed_m_s) for slide in found.slides] == [1, -1] * 3
    for slide in found.slides:
        assert abs(slide.speed_m_s) == pytest.approx(0.04, rel=0.02)
        assert slide.friction_n == pytest.approx(0.3 * (slide.load_n / 0.5) ** 0.8, rel=0.03)
    assert found.exponent.value == pytest.approx(0.8, abs=0.1)
    assert found.level_n(0.5) == pytest.approx(0.3, rel=0.02)


def test_the_sign_of_the_sensor_does_not_matter():
    one, other = friction(strokes(drift=0.0)), friction(strokes(drift=0.0, sign=-1.0))
    assert other.mu.value == pytest.approx(one.mu.value, rel=1e-3)


def test_a_simulated_bench():
    """The finger of the bench slides on a plate that is still: friction over load is that of its law."""
    flat = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.load_exponent": 1.0}
    run = fl.plain_stroke(fl.bench().evolve(flat), 0.0, duration_s=6.0)
    # What the finger feels, without the sensor in between.
    found = friction(run[["position", "load"]].assign(f_m=run.f_a))
    assert len(found.slides) >= 2 and [each.code for each in found.findings if each.code == "NOT-TOLD"]
    assert found.mu.value == pytest.approx(0.95 / 0.5, rel=0.02)
    assert found.level_n(0.5) == pytest.approx(0.95, rel=0.05)
    assert all(abs(slide.speed_m_s) == pytest.approx(0.02, rel=0.1) for slide in found.slides)
