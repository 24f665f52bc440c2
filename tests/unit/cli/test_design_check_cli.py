"""``frictionloop design check``: the verdict first, a table, and the same as JSON."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.occlusions import moistest
from frictionloop.cli.controller_also import MATTER, assumed, assumed_in_file, given_in
from frictionloop.cli.must_hold import MustHold
from frictionloop.cli.other_fingers import OtherFingers
from frictionloop.cli.saved_controller import by_file
from frictionloop.parameters import write_toml

CHECK = ("design", "check")
RIGID = ("--finger.kind", "rigid")
WITH_KP = ("--controller.kind", "pi", "--controller.kp")
PI = (*WITH_KP, "0.05", "--controller.ki")


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
    assert said.startswith(
        "DOES NOT HOLD at 5 of 6 slip lengths and speeds looked at, pressed with 0.5 N alone "
        "UNSTABLE slip length 0 um at 10, 20,"
    )
    assert "mm/s with the resonance 5 % lower: starts to ring near 13" in said
    assert "slip length 11.5 um at 80 mm/s with the resonance 10 % lower: starts to ring near 12" in said
    assert "BEYOND LIMITS slip length 11.5 um at 20 mm/s with the resonance 5 % lower (Ms 3.0" in said
    assert "the limit is 2, gain margin 1." in said and "HOLDS slip length 11.5 um at 10 mm/s looked at 0.5 to" in said
    assert "would hold kp at most 0.0" in said and "`frictionloop design controller --preset bench` searches" in said
    assert "resonance finger -10 % -5 % 0 +5 % +10 % gain limit 2.6 2 1.7 2 2.6 11.5 um 20 mm/s dry" in said
    assert not {"nan", "inf"} & set(said.split())


def test_a_file_whose_gains_hold(frictionloop):
    Path("c.toml").write_text('preset = "bench"\n[controller]\nkind = "pi"\nkp = 0.0\nki = 7.0\n')
    found = frictionloop(*CHECK, "c.toml", "--json").json()
    assert (found["holds"], found["would_hold"], found["law"]) == (True, {}, "pi")
    at = {(place["slip_length_um"], *place["speeds_mm_s"]) for place in found["places"]}
    assert at == {(length_um, speed) for length_um in (11.5, 0.0) for speed in (10.0, 20.0, 80.0)}
    assert {place["how"] for place in found["places"]} == {"within"}
    for place in found["places"]:
        at = [(each["occluded"] > 0, each["resonance_off"]) for each in place["corners"]]
        assert set(at) == {(moist, off) for moist in (False, True) for off in (-0.1, -0.05, 0.0, 0.05, 0.1)}
        worst = place["worst"]
        there = {"finger.slip_length_um": place["slip_length_um"], "motion.speed_mm_s": worst["speed_mm_s"]}
        there["sensor.resonance_hz"] = 145.0 * (1 + worst["resonance_off"])
        loop = fl.linearise(fl.read_toml("c.toml").evolve(there), force_n=worst["force_n"], occluded=worst["occluded"])
        assert worst["sensitivity_peak"] == pytest.approx(loop.margins().sensitivity_peak, rel=1e-5)


def test_one_place_and_what_is_asked_for(frictionloop):
    little = (*RIGID, *WITH_KP, "0", "--controller.ki", "7")
    out = " ".join(frictionloop(*CHECK, *little).out.split())
    assert out.startswith(
        "HOLDS at the slip length and speed looked at, pressed with 0.5 N alone "
        "this loop at 20 mm/s looked at 0.5 to 0.7 N;"
    )
    assert "room for the file's finger the gain of the loop may be" in out
    tight = " ".join(frictionloop(*CHECK, *little, "--sensitivity-peak", "1.05").out.split())
    assert tight.startswith(
        "DOES NOT HOLD at the slip length and speed looked at, pressed with 0.5 N alone "
        "BEYOND LIMITS this loop at 20 mm/s (Ms 1."
    )
    assert "would hold ki at most " in tight and "kp at most" not in tight


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (("--setpoint.offset_n", "2"), "saturation is the limit"),
        (("--controller.kind", "oracle"), "is no law"),
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


@pytest.mark.slow
def test_a_slider_that_does_alike_at_all_speeds_is_one_row(frictionloop):
    said = " ".join(frictionloop(*CHECK, *PI, "60", "--slip-lengths-um", "0").out.split())
    assert said.startswith(
        "DOES NOT HOLD at 3 of 3 slip lengths and speeds looked at, pressed with 0.5 N alone "
        "UNSTABLE slip length 0 um at 10, 20, 80"
    )
    assert "0 um 10, 20, 80 mm/s dry" in said and "11.5 um" not in said.partition("resonance finger")[2]


@pytest.mark.slow
def test_a_range_of_loads_clips_what_no_amplitude_gives_and_says_so(frictionloop):
    light = ("--setpoint.offset_n", "0.4", "--setpoint.amplitude_n", "0.25", "--motion.contact_s", "10")
    few = ("--plate.max_amplitude_um", "2.2", "--controller.model.max_amplitude_um", "2.2", "--slip-lengths-um", "0")
    weak = ("--controller.kind", "pi", "--controller.kp", "0", "--controller.ki", "2")
    at = fl.bench().evolve({"motion.load_n": 1.2, "friction.moist_loss": 0.0})
    least = at.friction.nominal_n * 2.4**at.friction.load_exponent * math.exp(-0.38 * 2.2**2)
    said = " ".join(frictionloop(*CHECK, *weak, *light, *few, "--loads", "0.4,1.2").out.split())
    assert said.startswith(
        "HOLDS but OUT OF REACH; rows below. Where it holds: at every slip length and speed looked at, "
        "pressed with 0.4 to 1.2 N slip length 0 um at 10, 20, 80 mm/s OUT OF REACH 0.15 N of"
    )
    assert f"a finger just landed: 0.203 N pressed with 0.693 N, {least:.3g} N pressed with 1.2 N are looked at" in said
    said = " ".join(frictionloop(*CHECK, *weak, *light, *few, "--motion.load_n", "1.2").out.split())
    assert f"0.15 N of a finger just landed: {least:.3g} N is looked at" in said


@pytest.mark.slow
def test_a_law_that_believes_the_friction_of_another_load_is_told_that_of_this_one(frictionloop):
    weak = (*WITH_KP, "0", "--controller.ki", "2", "--slip-lengths-um", "0", "--motion.load_n", "0.8")
    there = f"{0.95 * 1.6**0.9:.3g}"
    said = " ".join(frictionloop(*CHECK, *weak).out.split())
    assert "the law believes 0.95 N without vibration, that of friction.reference_load_n = 0.5 N;" in said
    assert f"the finger has {there} N, which `--controller.model.nominal_n {there}` tells it" in said
    told = frictionloop(*CHECK, *weak, "--controller.model.nominal_n", there).out
    assert "the law believes" not in told


@pytest.mark.slow
def test_speeds_that_were_asked_for_are_judged_apart_from_slower_and_faster_ones(frictionloop):
    weak = (*WITH_KP, "0", "--controller.ki", "70", "--slip-lengths-um", "11.5", "--speeds", "15,25")
    found = frictionloop(*CHECK, *weak, "--json").json()
    asked, slower, faster = found["places"]
    assert [asked["how"], slower["how"], faster["how"]] == ["within", "within", "beyond"]
    assert (found["holds"], found["holds_as_asked"]) == (False, True)
    said = " ".join(frictionloop(*CHECK, *weak).out.split())
    assert said.startswith(
        "HOLDS but elsewhere BEYOND LIMITS; rows below. Where it holds: at every slip length and speed asked for, "
        "pressed with 0.5 N alone BEYOND LIMITS slip length 11.5 um at 80 mm/s"
    )
    assert "everywhere in the table, the slower and faster places too, pressed with 0.5 N alone" in said
    one = frictionloop(*CHECK, *weak[:-1], "20", "--json").json()
    assert [each["how"] for each in one["places"]] == ["within", "within", "beyond"]
    alone = " ".join(frictionloop(*CHECK, *weak[:-2]).out.split())  # without --speeds, at that of the preset
    assert alone.startswith(
        "HOLDS but elsewhere BEYOND LIMITS; rows below. Where it holds: at 20 mm/s, the speed given, on every contact "
        "looked at, pressed with 0.5 N alone BEYOND LIMITS slip length 11.5 um at 80 mm/s"
    )


@pytest.mark.parametrize(("contact_s", "lifted_s"), [(5.0, 0.5), (2.0, 10.0), (30.0, 3.0)])
def test_a_finger_that_lands_again_and_again_is_as_moist_as_contact_after_contact_leaves_it(contact_s, lifted_s):
    bench = fl.bench().evolve({"motion.contact_s": contact_s, "motion.lifted_s": lifted_s, "friction.drying_s": 8.0})
    friction, occluded = bench.friction, 0.0
    for _ in range(2000):
        occluded *= np.exp(-lifted_s / friction.drying_s)  # in the air
        occluded = 1.0 - (1.0 - occluded) * np.exp(-contact_s / friction.occlusion_s)
    assert moistest(friction, bench.motion) == pytest.approx(occluded, rel=1e-9)
    never = -np.expm1(-10.0 / friction.occlusion_s)
    assert moistest(friction, fl.bench().motion) == pytest.approx(never, rel=1e-9), "one that never lifts, after 10 s"


@pytest.mark.slow
def test_contacts_that_follow_each_other_are_looked_at_with_what_moisture_they_leave(frictionloop):
    given = (*CHECK, *PI, "60", "--slip-lengths-um", "11.5", "--motion.contact_s", "5")
    said = " ".join(frictionloop(*given).out.split())
    assert "a moist finger (occluded 92%)" in said and "fully moist" not in said
    assert "moist contacts of 5 s, 0.5 s apart, in the end leave a finger 92% occluded, a single one 22%" in said
    found = frictionloop(*given, "--json").json()
    states = {corner["occluded"] for place in found["places"] for corner in place["corners"]}
    assert sorted(states) == [0.0, pytest.approx(0.92, abs=0.005)]


@pytest.mark.slow
def test_a_check_counts_the_fingers_on_which_it_holds(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    given = (
        *CHECK,
        *PI[:2],
        "--controller.kp",
        "0.03",
        "--controller.ki",
        "20",
        "--fingers",
        "8",
        "--slip-lengths-um",
        "11.5",
    )
    found = frictionloop(*given, "--json").json()["fingers"]
    held, rings = found["hold"], sum(not each for each in found["stable"])
    assert found["count"] == 8 and sum(found["holds"]) == held and 0 < held < 8
    answer = frictionloop(*given)
    said = " ".join(answer.out.split())
    assert (
        f"the limits hold on {held} of 8 fingers of seed 0; slip length 11.5 um, 20 mm/s, none more than 39% occluded; "
        "each has its own"
        in said
        and "NOT ON ALL FINGERS" in said
    )
    assert f"on {8 - held - rings} the loop is stable, beyond a limit; on {rings} it is unstable" in said
    least = min(range(8), key=lambda k: found["gain_factor"][k])
    system = "--preset bench --controller.kind pi --slip-lengths-um 11.5 --fingers 8 --fingers-seed 1"
    assert (
        f"`frictionloop design check {system}`, with these gains and `--out my-gains.toml`, checks them on others"
        in said
    )
    assert f"the worst is finger {least}:" in said and "on all 8 the limits hold with `--controller.kp" in said
    assert ("; it cannot be given every force asked for" in said) is not found["in_reach"][least]
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 80


def test_a_check_without_fingers_says_how_to_look_at_them(frictionloop):
    given = (*CHECK, *PI, "7", "--slip-lengths-um", "11.5")
    said = " ".join(frictionloop(*given).out.split())
    assert "% of 1000 bring a loop gain above" in said and "`--fingers 100` counts the fingers on which" in said
    refused = frictionloop(*given, "--population", "people.toml")
    assert "population: says where fingers come from; accepted: with --fingers N" in refused.err


@pytest.mark.slow
def test_what_was_checked_is_saved_with_what_was_found(frictionloop, tmp_path):
    gains = ("--controller.kp", "0.03", "--controller.ki", "20", "--fingers", "8", "--slip-lengths-um", "11.5")
    said = frictionloop(*CHECK, *PI[:2], *gains, "--out", "g.toml").out
    assert "saved controller as g.toml" in " ".join(said.split())
    assert fl.read_toml("g.toml").controller.ki == 20.0
    lines = (tmp_path / "g.toml").read_text().split("\nschema")[0].splitlines()
    head = " ".join(" ".join(line.removeprefix("# ").split()) for line in lines)
    assert "NOT ON ALL FINGERS: the limits hold on " in head
    assert "would hold" not in head
    assert "Look again: frictionloop design check FILE --slip-lengths-um 11.5 --fingers 8 as in bench()," in head
    again = " ".join(frictionloop("design", "check", "g.toml").out.split())
    assert "by the file `--slip-lengths-um 11.5 --fingers 8` looks at what it was designed or checked for" in again
    assert "exists and is not replaced" in frictionloop("design", "check", "g.toml", "--out", "g.toml").err


@pytest.mark.slow
def test_a_check_that_is_stopped_tells_what_it_has_found(frictionloop, monkeypatch):
    """Ctrl-C at the fourth of eight fingers: the verdict on the finger of the file, and on three others."""
    from frictionloop.design import on_fingers

    seen, of_one = [], on_fingers._of

    def look(*given):
        seen.append(given)
        if len(seen) > 3:
            raise KeyboardInterrupt
        return of_one(*given)

    monkeypatch.setattr(on_fingers, "_of", look)
    gains = ("--controller.kp", "0.03", "--controller.ki", "20", "--fingers", "8", "--slip-lengths-um", "11.5")
    answer = frictionloop(*CHECK, *WITH_KP[:2], *gains, "--out", "c.toml")
    assert answer.code == 130 and answer.err.endswith("interrupted: 3 of 8 fingers looked at\n")
    said = " ".join(answer.out.split())
    assert (
        said.startswith("HOLDS but elsewhere") and "of 3 fingers of the first 3 of seed 0; slip length 11.5 um" in said
    )
    assert "of 3 fingers of the first 3 of seed 0" in " ".join(Path("c.toml").read_text().replace("#", " ").split())


@pytest.mark.slow
def test_a_check_of_a_designed_file_tells_what_it_was_designed_with_and_what_nobody_gave(frictionloop, tmp_path):
    Path("lab.toml").write_text('preset = "bench"\n[motion]\nload_n = 0.5\n[controller]\ndelay_s = 200e-6\n')
    said = frictionloop(
        "design", "controller", "lab.toml", "--law", "pi", "--sensor-error", "0.5", "--out", "c.toml"
    ).out
    (line,) = re.findall("^# (as in bench.*)", Path("c.toml").read_text(), re.M)
    line = line.replace("motion.lifted_s = 0.5 s, ", "")  # this finger never lifts
    assert " ".join(said.split()).endswith(f"{line} saved controller as c.toml")
    assert "motion.load_n = " not in line and "controller.delay_s = " not in line and "sensor.q = 20" in line
    plain = " ".join(frictionloop("design", "check", "c.toml").out.split())
    assert plain.endswith(line)
    assert "by the file `--sensor-error 0.5` looks at what it was designed or checked for" in plain
    partly = " ".join(frictionloop("design", "check", "c.toml", "--speeds", "20").out.split())
    assert "by the file `--sensor-error 0.5`, with which it was designed or checked, is left out here" in partly
    whole = frictionloop("design", "check", "c.toml", "--speeds", "20", "--sensor-error", "0.4").out
    assert "by the file" not in whole


@pytest.mark.parametrize(
    ("head", "must", "others", "said"),
    [
        ("--loads 0.4,0.6 --fingers 8 --population 'my people.toml'", {"loads": "0.4,0.6"}, {},
         "`--fingers 8 --population 'my people.toml'`, with which it was designed or checked, is left out here"),
        ("--loads 0.4,0.6 --fingers 8", {}, {"fingers": 2},
         "`--loads 0.4,0.6`, with which it was designed or checked, is left out here"),
        ("--loads 0.4,0.6 --fingers 8", {}, {},
         "`--loads 0.4,0.6 --fingers 8` looks at what it was designed or checked for"),
        ("--slip-lengths-um 0", {"speeds": "20"}, {},
         "`--slip-lengths-um 0`, with which it was designed or checked, is left out here"),
        ("--loads 1", {"loads": "0.4"}, {}, ""),
        ("", {}, {}, ""),
    ],
)  # fmt: skip
def test_what_a_file_was_designed_with_and_a_check_leaves_out(tmp_path, head, must, others, said):
    file = tmp_path / "c.toml"
    file.write_text(f"# Look again: frictionloop design check FILE {head}\nschema = 1\n", encoding="utf-8")
    assert by_file(file, MustHold(**must), OtherFingers(**others)) == said
    file.write_text("schema = 1\n", encoding="utf-8")
    assert by_file(file, MustHold(**must), OtherFingers(**others)) == "" == by_file(None, MustHold(), OtherFingers())


def test_what_somebody_gave_is_known_from_the_head_of_a_file_that_was_written_whole(tmp_path):
    system = fl.bench()
    some = {"motion.load_n", "sensor.q"}
    for given in (some, set(MATTER)):
        file = tmp_path / "c.toml"
        write_toml(system, file, said=["A controller.", assumed_in_file(system, given)])
        assert given_in(file) == given
        assert ("sensor.q = 20" in assumed(system, given_in(file))) is False
    write_toml(system, file)
    assert given_in(file) == set() == given_in(None)
    assert "motion.lifted_s" not in assumed(system, some) and "motion.lifted_s" in assumed_in_file(system, some)


@pytest.mark.slow
def test_a_file_of_another_contact_is_checked_on_it_without_a_flag(frictionloop):
    frictionloop(*CHECK, *PI, "60", "--finger.slip_length_um", "0", "--out", "s.toml")
    assert re.search("^# Look again: frictionloop design check FILE$", Path("s.toml").read_text(), re.M)
