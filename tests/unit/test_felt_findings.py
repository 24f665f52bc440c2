"""Findings of effects, experiments, the studio and the report, each through a public call."""

from __future__ import annotations

import json

import numpy as np
import pytest
from PIL import Image

import frictionloop as fl
from frictionloop.experiments.running import ran

R, X = fl.rendering, fl.experiments
BENCH = fl.bench().evolve({"controller.kind": "notch_pi", "controller.feedforward": True})


def codes(result):
    """Return the codes of a result, which JSON and its page have as well."""
    found = {each.code for each in result.findings}
    assert {each["code"] for each in json.loads(result.to_json())["findings"]} == found
    assert all(code in result.to_html() for code in found)
    return found


def test_what_of_an_effect_is_clamped_too_steep_out_of_reach_or_faint():
    assert codes(R.check(R.Grating(offset_n=0.8, amplitude_n=0.3), BENCH, 80.0)) == {"EFFECT-CLAMPED"}
    assert codes(R.check(R.Grating(spacing_mm=0.4), BENCH, 80.0)) == {"EFFECT-STEEP"}
    assert "EFFECT-REACH" in codes(R.preview(R.Grating(offset_n=0.3, amplitude_n=0.25), BENCH, 80.0))
    assert "EFFECT-FAINT" in codes(R.preview(R.Grating(amplitude_n=0.002), BENCH, 80.0))
    with pytest.raises(fl.FrictionloopError) as error:
        R.check(R.Constant(level_n=2.0), BENCH)
    assert error.value.code == "EFFECT-OUT"


def test_what_a_file_does_not_carry_its_scale_and_its_size(tmp_path):
    np.savetxt(tmp_path / "force.csv", np.full(100, 0.4), header="force", comments="")
    assert codes(R.import_effect(tmp_path / "force.csv", rate_hz=1000.0)) == {"SCALE-TAKEN"}
    Image.fromarray(np.zeros((200, 300), np.uint8)).save(tmp_path / "large.png")
    large = R.import_effect(tmp_path / "large.png", mm_per_pixel=0.1, polarity="dark")
    assert codes(large) == {"PICTURE-REDUCED"} and large.pixels == (300, 200)
    event = {"Time": 0.0, "EventType": "HapticContinuous", "EventDuration": 0.1, "EventParameters": []}
    sound = {"Time": 0.0, "EventType": "AudioCustom", "EventParameters": []}
    pattern = {"Version": 1.0, "Pattern": [{"Event": event}, {"Event": sound}]}
    (tmp_path / "click.ahap").write_text(json.dumps(pattern))
    assert codes(R.import_effect(tmp_path / "click.ahap", full_n=0.2)) == {"EFFECT-LEFT"}


def test_a_protocol_that_few_fingers_can_be_given():
    plan = X.read_protocol("magnitude-estimation")
    high = plan.evolve({"method.levels": [1.3, 1.4]})
    found = X.check(high)
    assert codes(found) == {"STUDY-REACH"} and found.share_in_reach < 0.25


def test_what_the_log_of_a_session_keeps(tmp_path):
    session = X.run(X.read_protocol("jnd-friction-staircase"), tmp_path / "P01", "P01", trials=1).folder
    assert codes(ran(session)) == set()
    events = [
        {"event": "adjusted", "what": "levels", "factor": 0.8},
        {"event": "given up", "condition": "closed", "marked": 20},
    ]
    with (session / "log.jsonl").open("a") as log:
        log.writelines(json.dumps(each) + "\n" for each in events)
    found = ran(session)
    assert codes(found) == {"STUDY-LEVELS", "STUDY-GIVEN-UP"}
    assert (found.levels_factor, found.given_up) == (0.8, {"closed": 20})
