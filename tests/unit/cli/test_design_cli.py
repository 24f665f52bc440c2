"""``frictionloop design`` and ``explain``: flags in, the answer of the public function out, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from golden import check_golden
from matplotlib.image import imread

import frictionloop as fl
from frictionloop.cli import screen
from frictionloop.cli.design import MustHold
from frictionloop.design import Requirements
from frictionloop.design.controller_synthesis import SYNTHESES
from frictionloop.findings import CATALOGUE

DESIGN, CONTROLLER, CHECK = "design", ("design", "controller"), ("design", "check")
WEAK = ("--controller.kind", "pi", "--controller.kp", "0", "--controller.ki", "7")
ASKED = ("--slip-lengths-um", "11.5", "--sensitivity-peak", "1.6")
RINGS = ("--controller.kind", "pi", "--controller.kp", "0.05", "--controller.ki", "60", "--slip-lengths-um", "0")


@pytest.mark.parametrize("verb", ["controller", "check", "sensor", "plate"])
def test_help_has_examples_that_fit(frictionloop, monkeypatch, verb):
    monkeypatch.setenv("COLUMNS", "80")
    out = frictionloop(DESIGN, verb, "--help").out
    assert f"\n  frictionloop design {verb}" in out and "--all" in out and "--html" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80
    assert f"    {verb} " in frictionloop(DESIGN).out


def test_the_screen_is_the_answer_and_the_exit_code_the_verdict(frictionloop):
    found = fl.design.check(
        fl.bench().evolve({"controller.kind": "pi", "controller.kp": 0.05, "controller.ki": 60.0}),
        Requirements(slip_lengths_um=(0.0, 0.0)),
        None,
        given={"controller.kind", "controller.kp", "controller.ki"},
    )
    answer = frictionloop(*CHECK, *RINGS)
    assert [line.rstrip() for line in answer.out.splitlines()] == str(found).splitlines()
    assert (answer.code, answer.noted) == (screen.DOES_NOT_HOLD, [])


def test_everything_and_a_page_and_json_know_the_same(frictionloop):
    every = frictionloop(*CHECK, *WEAK, *ASKED, "--all", "--html", "a.html")
    told = frictionloop(*CHECK, *WEAK, *ASKED, "--json").json()
    page = Path("a.html").read_text(encoding="utf-8")
    assert every.code == 0 and "saved page: a.html" in every.out and told["holds"] and told["saved"] == {}
    for each in told["findings"]:
        assert each["code"] in every.out and each["code"] in page
    assert "least margins" in every.out and "more: --all" not in every.out


def test_a_controller_is_saved_with_what_it_was_checked_for_and_read_again(frictionloop):
    assert "saved controller: c.toml" in frictionloop(*CHECK, *WEAK, *ASKED, "--out", "c.toml").out
    table = fl.design.read_designed("c.toml")
    assert table.requirements == Requirements(1.6, slip_lengths_um=(11.5,))
    again = frictionloop(*CHECK, "c.toml", "--json").json()
    assert again["requirements"]["sensitivity_peak"] == 1.6 and len(again["places"]) == 3
    refused = frictionloop(*CHECK, "c.toml", "--out", "c.toml")
    assert refused.code == 2 and "delete it first" in refused.err


@pytest.mark.slow
def test_a_design_is_that_of_python_with_figures_beside_it(frictionloop):
    answer = frictionloop(*CONTROLLER, "--law", "pi", "--out", "c.toml", "--plots", "figures", "--json")
    told, found = answer.json(), fl.design.controller(fl.bench(), "pi")
    assert told["overrides"] == found.overrides and told["holds"] and told["saved"]["controller"] == "c.toml"
    assert fl.read_toml("c.toml") == found.system
    for name in ("sensitivity", "step"):
        assert Path(f"figures/{name}.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")
        assert imread(f"figures/{name}.png").shape[2] == 4


def test_flags_of_what_must_hold_are_fields_of_requirements():
    given = MustHold(speeds="20,60", loads="0.4", slip_lengths_um="0,30", delay_error=0.1, finger_gain=1.5)
    assert given.requirements(None) == Requirements(
        speeds_mm_s=(20.0, 60.0), loads_n=(0.4,), slip_lengths_um=(0.0, 30.0), delay_error=0.1, finger_gain=1.5
    )
    assert MustHold().requirements(None) == Requirements()


def test_a_synthesis_that_fails_leaves_nothing(frictionloop, monkeypatch):
    def fails(*_):
        raise fl.FrictionloopError("law hinf: no solution", "NO-CONTROLLER")

    monkeypatch.setitem(SYNTHESES, "hinf", fails)
    answer = frictionloop(*CONTROLLER, "--law", "hinf", "--out", "c.toml", "--slip-lengths-um", "11.5")
    assert (answer.code, answer.out, answer.err) == (2, "", "error: law hinf: no solution  [NO-CONTROLLER]\n")
    assert list(Path().iterdir()) == []


def test_a_part_is_that_of_python_and_saved(frictionloop):
    told = frictionloop(
        DESIGN, "sensor", "--resonance-hz", "200", "--save-design", "s.toml", "--spice", "s.cir", "--json"
    )
    found = fl.design.sensor(resonance_hz=200.0)
    assert told.json() == json.loads(found.to_json()) | {"saved": {"design": "s.toml", "netlist": "s.cir"}}
    assert frictionloop(DESIGN, "sensor", "s.toml", "--json").json()["sensor"] == pytest.approx(found.suspended)
    assert Path("s.cir").read_text().endswith(".end\n")
    assert "delete it first" in frictionloop(DESIGN, "sensor", "--save-design", "s.toml").err
    flags = ("--frequency-hz", "38000", "--drive.quality-factor", "150", "--drive.finger_on", "true")
    plate = fl.design.plate(overrides={"drive.quality_factor": 150, "drive.finger_on": True}, frequency_hz=38e3)
    assert frictionloop(DESIGN, "plate", *flags, "--json").json() == json.loads(plate.to_json()) | {"saved": {}}


def test_doubts_about_a_part_stand_in_the_answer(frictionloop):
    for tokens in (("sensor", "--electrodes.gap_um", "1e5"), ("plate", "--geometry.thickness_mm", "0.003")):
        answer = frictionloop(DESIGN, *tokens)
        assert "UNIT-DOUBT" in answer.out and answer.err == ""


def test_a_code_is_explained_and_all_are_listed(frictionloop):
    check_golden("explain.txt", frictionloop("explain", "ring-moist").out)
    assert [line.split()[0] for line in frictionloop("explain", "--all").out.splitlines() if line[:1].isupper()] == [
        *CATALOGUE
    ]
    assert frictionloop("explain", "RING-MOIST", "--json").json()["title"] == CATALOGUE["RING-MOIST"].title
    refused = frictionloop("explain", "RING-MOST")
    assert refused.code == 2 and "did you mean RING-MOIST" in refused.err
