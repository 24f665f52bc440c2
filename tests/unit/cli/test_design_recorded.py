"""What a design takes of recorded signals."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.analysis.levels import at_levels


@pytest.mark.slow
def test_a_design_takes_the_levels_of_a_recorded_set_point(frictionloop, tmp_path):
    (tmp_path / "wanted.csv").write_text("# rate_hz: 100\nforce [N]\n0.4\n0.8\n0.5\n")
    (tmp_path / "slide.csv").write_text("# rate_hz: 100\nforce [N]\n0.4\n0.8\n0.5\n")
    recorded = ("--setpoint.kind", "recording", "--setpoint.path", "wanted.csv", "--setpoint.column", "force")
    slide = ("--disturbance.kind", "recording", "--disturbance.path", "slide.csv", "--disturbance.column", "force")
    answer = frictionloop("design", "controller", *recorded, *slide, "--law", "pi", "--out", "new.toml", "--json")
    told = answer.json()
    assert told["tracking"] is None  # a recording is shorter than 1 s
    levels = {each["where"]["recording"]: each for each in told["findings"] if each["code"] == "RECORDED-LEVEL"}
    assert (levels["setpoint"]["value"], levels["setpoint"]["amplitude"]) == pytest.approx((0.6, 0.2))
    new = fl.read_toml(tmp_path / "new.toml")
    assert (new.setpoint.kind, new.disturbance.kind) == ("recording", "recording")
    levels = at_levels(new)
    assert (levels.setpoint.offset_n, levels.setpoint.amplitude_n) == pytest.approx((0.6, 0.2))
    assert levels.disturbance == fl.Constant(offset_n=0.0)  # the mean friction was left in
    less = new.evolve({"disturbance.scale": 0.1})
    assert at_levels(less).disturbance.offset_n == pytest.approx(0.17 / 3)
