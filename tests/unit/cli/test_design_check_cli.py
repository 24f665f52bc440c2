"""``frictionloop design check``: the verdict first, a table, and the same as JSON."""

from __future__ import annotations

from pathlib import Path

import pytest

import frictionloop as fl

CHECK = ("design", "check")
RIGID = ("--finger.kind", "rigid")
PI = ("--controller.kind", "pi", "--controller.kp", "0.05", "--controller.ki")


def test_help_has_examples_that_fit(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    out = frictionloop(*CHECK, "--help").out
    assert "\n  frictionloop design check my-controller.toml" in out
    assert "--resonance-error" in out and "--law" not in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


def test_the_verdict_comes_first_and_the_answer_fits(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    answer = frictionloop(*CHECK, *PI, "60")
    assert (answer.code, answer.noted) == (0, [])
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 80
    said = " ".join(answer.out.split())
    assert said.startswith("DOES NOT HOLD at 4 of 6 contacts and speeds looked at UNSTABLE contact slider at 10, 20,")
    assert "mm/s with the resonance 5 % lower: rings near 13" in said
    assert "CLOSE TO UNSTABLE contact dahl at 80 mm/s with the resonance 10 % lower (Ms 9.9" in said
    assert "the limit is 2.6, gain margin 1.1" in said and "HOLDS contact dahl at 10, 20 mm/s looked at 0.5 to" in said
    assert "would hold kp at most 0.0" in said and "`frictionloop design controller --preset bench` searches" in said
    assert "resonance finger -10 % -5 % 0 +5 % +10 % gain limit 2.6 2 1.7 2 2.6 dahl 20 mm/s dry" in said
    assert not {"nan", "inf"} & set(said.split())


def test_a_file_whose_gains_hold(frictionloop):
    Path("c.toml").write_text('preset = "bench"\n[controller]\nkind = "pi"\nkp = 0.0\nki = 7.0\n')
    found = frictionloop(*CHECK, "c.toml", "--json").json()
    assert (found["holds"], found["would_hold"], found["law"]) == (True, {}, "pi")
    at = {(place["contact"], *place["speeds_mm_s"]) for place in found["places"]}
    assert at == {(contact, speed) for contact in ("dahl", "slider") for speed in (10.0, 20.0, 80.0)}
    assert {place["how"] for place in found["places"]} == {"within"}
    for place in found["places"]:
        at = [(each["occluded"] > 0, each["resonance_off"]) for each in place["corners"]]
        assert set(at) == {(moist, off) for moist in (False, True) for off in (-0.1, -0.05, 0.0, 0.05, 0.1)}
        worst = place["worst"]
        there = {"finger.contact": place["contact"], "motion.speed_mm_s": worst["speed_mm_s"]}
        there["sensor.resonance_hz"] = 145.0 * (1 + worst["resonance_off"])
        loop = fl.linearise(fl.read_toml("c.toml").evolve(there), force_n=worst["force_n"], occluded=worst["occluded"])
        assert worst["sensitivity_peak"] == pytest.approx(loop.margins().sensitivity_peak, rel=1e-5)


def test_one_place_and_what_is_asked_for(frictionloop):
    little = (*RIGID, *PI, "7", "--controller.kp", "0")
    out = " ".join(frictionloop(*CHECK, *little).out.split())
    assert out.startswith("HOLDS at the contact and speed looked at this loop at 20 mm/s looked at 0.5 to 0.7 N;")
    assert "room the gain of the loop may be" in out
    tight = " ".join(frictionloop(*CHECK, *little, "--sensitivity-peak", "1.05").out.split())
    assert tight.startswith(
        "DOES NOT HOLD at the contact and speed looked at BEYOND LIMITS this loop at 20 mm/s (Ms 1."
    )
    assert "would hold ki at most " in tight and "kp at most" not in tight


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (("--setpoint.offset_n", "2"), "saturation is the limit"),
        (("--controller.kind", "oracle"), "its runs show what it does: frictionloop simulate"),
        (("--sensitivity-peak", "1"), "sensitivity_peak = 1: must be above 1"),
        (("--law", "pi"), "Unknown option"),
        (("no.toml",), "no.toml: cannot be read"),
    ],
)
def test_bad_input_is_one_line(frictionloop, tokens, said):
    answer = frictionloop(*CHECK, *tokens)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: ") and answer.err.count("\n") == 1
    assert said in answer.err
