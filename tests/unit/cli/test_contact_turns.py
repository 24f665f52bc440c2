"""A finger that turns on the plate within its contacts is asked about, and the flags make each contact one stroke."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli.contact_turns import question
from frictionloop.firmware.board_fit import board_findings

LIFTS = {"motion.speed_mm_s": 80.0, "motion.contact_s": 2.0, "motion.lifted_s": 0.5, "motion.stroke_mm": 160.0}


def told_changes(system):
    words = question(system).partition("in the air")[2].partition(": ")[2].split()
    return {path.removeprefix("--"): float(value) for path, value in zip(words[::2], words[1::2], strict=True)}


@pytest.mark.parametrize("speed_mm_s", [20.0, 80.0, 150.0])
def test_the_flags_make_each_contact_one_stroke(speed_mm_s):
    system = fl.bench().evolve(LIFTS | {"motion.speed_mm_s": speed_mm_s, "motion.tremor_um": 0.0})
    one = system.evolve(told_changes(system))
    assert question(one) == ""
    run = fl.simulate(one, 10.0)
    turned = np.abs(run["speed"].values) < 0.999 * np.abs(run["speed"].values).max()
    assert np.ptp(run["speed"].values) > 0 and turned.any() and not np.any(turned & (run["load"].values > 0.0))


@pytest.mark.slow
def test_a_finger_that_turns_within_its_contacts_is_asked_about(frictionloop):
    flags = [each for path, value in LIFTS.items() for each in (f"--{path}", f"{value:g}")]
    said = " ".join(frictionloop("simulate", "--preset", "bench", *flags).err.split())
    assert "motion.contact_s is 2 s and a stroke lasts 2.04 s, so the finger turns round on the plate" in said
    assert "--motion.stroke_mm 185 --motion.reversal_s 0.5 --motion.start 0.05 --board.position_m_per_count 3" in said
    back_and_forth = fl.bench().evolve(LIFTS | {"motion.contact_s": 6.0})
    assert question(fl.bench()) == question(fl.paper()) == question(back_and_forth) == ""


def test_a_stroke_that_is_longer_than_the_plate_says_which_plate():
    said = question(fl.bench().evolve(LIFTS | {"motion.speed_mm_s": 150.0}))
    assert "on a plate of 347 mm: " in said and "--touch.load.length_mm 346.875 --board.position_m" in said


def test_a_stroke_that_the_board_cannot_read_brings_the_scale_that_can():
    lifts = fl.bench().evolve(LIFTS | {"motion.speed_mm_s": 50.0, "motion.contact_s": 1.0})
    made = lifts.evolve(told_changes(lifts))
    assert made.motion.stroke_mm > 65.5 and [*board_findings(made)] == []
    short = lifts.evolve({"motion.contact_s": 0.5})
    assert "board" not in question(short)


def test_a_design_refuses_a_stroke_that_no_run_takes_before_it_searches(frictionloop):
    answer = frictionloop("design", "controller", "--preset", "bench", "--motion.stroke_mm", "300")
    assert answer.code == 2 and "searching" not in answer.err and "designing" not in answer.err
    assert "motion.stroke_mm = 300 mm: the plate between the load cells is" in answer.err


def test_a_speed_that_is_swept_is_asked_about_too(frictionloop):
    one = fl.bench().evolve(LIFTS | {"motion.speed_mm_s": 20.0, "motion.tremor_um": 0.0})
    fl.write_toml(one.evolve(told_changes(one)), "one.toml")
    words = ("sweep", "one.toml", "--duration-s", "0.1", "--over")
    (said,) = [each for each in frictionloop(*words, "motion.speed_mm_s=20,40").noted if "turns" in each]
    assert said.startswith("with motion.speed_mm_s = 40: motion.contact_s is 2 s") and "sweep one at a time" in said
    assert not any("turns" in each for each in frictionloop(*words, "motion.load_n=0.4,0.5").noted)
