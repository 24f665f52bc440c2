"""``frictionloop design controller``: what it prints, what it writes, and what it refuses."""

from __future__ import annotations

import itertools
import json
import math
import re
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread

import frictionloop as fl
from frictionloop.analysis.headroom import headroom
from frictionloop.analysis.operating import law_at
from frictionloop.cli import main, screen
from frictionloop.cli.controller_followed import followed, followed_text
from frictionloop.cli.controller_holds import wanted_flags
from frictionloop.cli.design_controller import _loads_said
from frictionloop.design import synthesis
from frictionloop.design.leaning import Lean
from frictionloop.design.on_fingers import check_fingers
from frictionloop.design.requirements import Requirements
from frictionloop.design.response_figures import figure_sensitivity, step_run, stepped
from frictionloop.design.synthesis import SYNTHESES, design_controller

CONTROLLER = ("design", "controller")
CONTACT_S, OCCLUSION_S = 10.0, 20.0


@pytest.fixture(scope="module")
def designed(tmp_path_factory, request):
    """Answer, system and figures of one whole run with the default law."""
    folder = tmp_path_factory.mktemp("designed")
    capture = request.config.pluginmanager.getplugin("capturemanager")
    saved = folder / "c.toml"
    with capture.global_and_fixture_disabled(), pytest.MonkeyPatch.context() as patch:
        lines = []
        keep = lambda *words, file=None, **_: file or lines.append(" ".join(map(str, words)))  # noqa: E731
        patch.setattr("builtins.print", keep)
        with pytest.raises(SystemExit) as left:
            main([*CONTROLLER, "--out", str(saved), "--plots", str(folder / "figures"), "--json"])
    assert left.value.code == 0
    return json.loads("\n".join(lines)), fl.read_toml(saved), folder


def test_help_has_examples_that_fit(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    out = frictionloop(*CONTROLLER, "--help").out
    assert "\n  frictionloop design controller my-bench.toml" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


@pytest.mark.slow
def test_the_margins_are_those_of_the_file(designed):
    found, system, _ = designed
    assert found["system"] == json.loads(json.dumps(system.model_dump()))
    at = {(row["stroke"], row["resonance_off"]) for row in found["margins"]}
    strokes = ("slip length 11.5 um, 20 mm/s", "slip length 0 um, 20 mm/s")
    assert at == {(stroke, off) for stroke in strokes for off in (-0.1, -0.05, 0.0, 0.05, 0.1)}
    for row in found["margins"]:
        length, speed = row["stroke"].removeprefix("slip length ").split(" um, ")
        there = system.evolve(
            {"sensor.resonance_hz": 145.0 * (1 + row["resonance_off"]), "finger.slip_length_um": float(length)}
        )
        assert speed == "20 mm/s"
        margins = fl.linearise(there, force_n=row["force_n"], occluded=row["occluded"]).margins()
        for name in ("sensitivity_peak", "gain_margin", "phase_margin_deg", "delay_margin_s"):
            assert row[name] == pytest.approx(getattr(margins, name), rel=1e-5)
        assert margins.stable


@pytest.mark.slow
def test_the_margins_hold_between_the_corners_too(designed):
    found, system, _ = designed
    moist = 1 - math.exp(-CONTACT_S / OCCLUSION_S)
    assert sorted({row["occluded"] for row in found["margins"]}) == pytest.approx([0.0, moist])
    f = np.union1d(np.geomspace(0.1, 2500, 4000), np.linspace(100, 200, 2000))
    for off in (-0.1, -0.07, -0.03, 0.0, 0.03, 0.07, 0.1):
        limit = 1.7 if off == 0 else 2.0 if abs(off) < 0.05 else 2.6
        there = system.evolve({"sensor.resonance_hz": 145.0 * (1 + off)})
        for length_um, occluded in itertools.product((11.5, 0.0), (0.0, moist / 2, moist)):
            there = there.evolve({"finger.slip_length_um": length_um})
            loop = fl.linearise(there, force_n=0.55, occluded=occluded)
            assert loop.is_stable()
            assert np.abs(loop.responses(f)["S"]).max() <= limit * 1.001


@pytest.mark.slow
def test_what_is_left_to_gain(designed):
    found, system, _ = designed
    left = found["headroom"]
    assert 0 < left["least_rms_n"] < left["residual_rms_n"] < left["disturbance_rms_n"]
    assert left["bode_integral"] == pytest.approx(left["unstable_sum"], abs=1e-6)
    # Delay and half a hold take 300 us: 360 f 300e-6 = 45 degrees.
    assert left["delay_limit_hz"] == pytest.approx(45 / (360 * 300e-6), rel=1e-6)
    # Roughness, tremor and drift as the parameters have them: 5 % and, by the load, 6 % and the drift.
    friction, motion, force = system.friction, system.motion, 0.6
    parts = (friction.roughness_rms, friction.load_exponent * motion.tremor_n / motion.load_n)
    parts += (friction.load_exponent * motion.load_drift,)
    assert left["disturbance_rms_n"] == pytest.approx(force * math.hypot(*parts), rel=0.03)


@pytest.mark.slow
def test_it_simulates_and_follows(designed):
    _, system, _ = designed
    rms = {name: fl.rms_error(fl.simulate(each, 4.0)) for name, each in (("new", system), ("old", fl.bench()))}
    assert rms["new"] < 0.25 * rms["old"]


@pytest.mark.slow
def test_the_error_on_the_files_own_set_point_is_told_beside_the_one_before(designed):
    found, system, _ = designed
    runs = {"rms_error_n": system, "before_rms_error_n": fl.bench()}
    runs["open_loop_rms_error_n"] = fl.bench().evolve({"controller.kind": "lookup"})
    assert found["followed"] == {
        "seconds": 10.0,
        "setpoint_rms_n": pytest.approx(0.1 / math.sqrt(2), rel=0.03),  # of its sine, but at reversals
        "rms_error_n_at_mm_s": {},
    } | {name: fl.rms_error(fl.simulate(each)) for name, each in runs.items()}


def test_the_error_at_the_ends_of_the_speeds_is_told_beside_the_set_points_own(capsys):
    before = fl.bench().evolve({"setpoint.kind": "sine", "setpoint.amplitude_n": 0.05})
    after = before.evolve(fl.RETUNED)
    found = followed(before, after, (10.0, 20.0, 40.0))
    assert found.setpoint_rms_n == pytest.approx(0.05 / math.sqrt(2), rel=0.03)
    # Not again at 20 mm/s, the speed of the system.
    assert found.rms_error_n_at_mm_s == {
        each: fl.rms_error(fl.simulate(after.evolve({"motion.speed_mm_s": each}))) for each in (10.0, 40.0)
    }
    screen.show(*followed_text(before, found))
    said = " ".join(capsys.readouterr().out.split())
    slow, fast = (1e3 * each for each in found.rms_error_n_at_mm_s.values())
    assert f"; {slow:.3g} mN at 10 mm/s; {fast:.3g} mN at 40 mm/s" in said
    assert f"set-point {1e3 * found.setpoint_rms_n:.3g} mN its own rms about its mean" in said
    # A finger that lifts after each stroke lifts after each at another speed; one that cannot be is left out.
    each = fl.bench().evolve({"motion.contact_s": 2.0}).evolve(fl.RETUNED)
    each = each.evolve(each.motion.in_contacts())
    there = each.evolve({"motion.speed_mm_s": 10.0, "motion.contact_s": 4.0})
    there = there.evolve(there.motion.in_contacts())
    at = followed(each, each, (0.01, 10.0)).rms_error_n_at_mm_s | followed(each, each, (10.0,)).rms_error_n_at_mm_s
    assert at[10.0] == fl.rms_error(fl.simulate(there))
    assert math.isnan(at[0.01])
    held = before.evolve({"setpoint.kind": "constant", "setpoint.offset_n": 0.6})
    quiet = followed(held, held, (20.0,))
    assert (quiet.setpoint_rms_n, quiet.rms_error_n_at_mm_s) == (0.0, {})
    screen.show(*followed_text(held, quiet))
    assert "about its mean" not in capsys.readouterr().out


@pytest.mark.slow
def test_figures_are_drawn(designed):
    figures = designed[2] / "figures"
    names = ["sensitivity.png", "sensitivity.svg", "step.png", "step.svg"]
    assert sorted(path.name for path in figures.iterdir()) == names
    for name in ("sensitivity", "step"):
        assert (figures / f"{name}.svg").read_text(encoding="utf-8").rstrip().endswith("</svg>")
        assert imread(figures / f"{name}.png").shape[2] == 4


@pytest.mark.parametrize("columns", [80, pytest.param(100, marks=pytest.mark.slow)])
def test_the_answer_fits_and_says_what_was_found(frictionloop, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    answer = frictionloop(*CONTROLLER, "--law", "pi", "--out", "c.toml")
    assert (answer.code, answer.err) == (0, "")
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= columns
    controller = fl.read_toml("c.toml").controller
    assert f"{controller.kp:.4g}" in answer.out
    assert f"{controller.ki:.4g} 1/s" in answer.out
    first = " ".join(answer.out.split())
    assert first.startswith(
        "HOLDS but CLOSE TO UNSTABLE when fully moist; rows below. Where it holds: slip length 0 to 11.5 um, 20 mm/s;"
    )
    assert "0.5 to 0.7 N; a finger just landed and a moist finger" in first
    assert "wider for other speeds and loads, `--speeds 10,20` and `--loads 0.35,0.7` design between these" in first
    assert (
        "Within the same limits, resonance off too: slip length 11.5 um at 10, 80 mm/s; slip length 0 um at 10, 80"
        in first
    )
    assert "go on with frictionloop simulate c.toml --plot run.svg A simulation runs at 20 mm/s" in first
    for said in ("as described", "+10 %", "Bode's least", "saved controller as c.toml"):
        assert said in answer.out
    assert frictionloop("simulate", "c.toml", "--duration-s", "0.5").code == 0


def test_the_figure_of_margins_names_force_contact_and_speed():
    slider = fl.bench().evolve({"finger.slip_length_um": 0.0} | fl.RETUNED)
    figure = figure_sensitivity(slider, headroom(slider, 1.7), {0.0: 1.7})
    assert figure.get_suptitle() == "0.6 N, dry finger, slip length 0 um, 20 mm/s"


@pytest.mark.parametrize(
    ("setpoint", "levels", "said"),
    [
        ({"kind": "sine", "offset_n": 0.5, "amplitude_n": 0.15, "frequency_hz": 3.0}, (0.35, 0.65), "lowest"),
        ({"kind": "constant", "offset_n": 0.5}, (0.45, 0.55), "10% around a set-point that stays at 0.5 N"),
        ({"kind": "steps", "times_s": [0.0, 1.0], "levels_n": [0.4, 0.9]}, (0.4, 0.9), "highest"),
    ],
)
def test_the_step_is_between_the_forces_that_are_asked_for(setpoint, levels, said):
    system = fl.bench().evolve({"setpoint": setpoint, "disturbance": {"kind": "constant", "offset_n": 0.1}})
    found, where = stepped(system)
    assert found == pytest.approx(levels) and said in where
    run = step_run(system)
    assert (float(run.f_r.min()), float(run.f_r.max())) == pytest.approx(levels)


@pytest.mark.slow
def test_a_saved_controller_begins_with_where_it_holds(designed):
    answer, _, folder = designed
    said = [line for line in (folder / "c.toml").read_text().splitlines() if line.startswith("# ")]
    forces = [row["force_n"] for row in answer["margins"]]
    assert said[0].startswith(f"# Law {answer['law']} from frictionloop design controller.")
    assert said[1] == "# Strokes: slip length 0 to 11.5 um, 20 mm/s."
    assert said[2].startswith(f"# Forces: {min(forces):.3g} to {max(forces):.3g} N, a finger just landed and a moist")
    assert (
        said[3] == "# A moist finger is one after 10 s on the plate, or after contact upon contact of motion.contact_s."
    )
    assert said[4] == (
        "# Resonance of the sensor: Ms up to 1.7 as described, 2 with it +-5 % off, 2.6 with it +-10 % off."
    )
    assert (folder / "c.toml").read_text().startswith(said[0])


@pytest.mark.slow
def test_a_sensor_without_a_resonance_gets_pi(frictionloop):
    found = frictionloop(*CONTROLLER, "--sensor.kind", "lowpass", "--json").json()
    assert found["law"] == "pi"
    assert {row["resonance_off"] for row in found["margins"]} == {0.0}


def test_a_preset_is_the_bench_of_a_file_that_holds_it(frictionloop):
    Path("paper.toml").write_text('preset = "paper"\n')
    by_name = frictionloop(*CONTROLLER, "--preset", "paper", "--json").json()
    assert by_name == frictionloop(*CONTROLLER, "paper.toml", "--json").json()
    assert by_name["system"]["sensor"]["cutoff_hz"] == 1000.0


@pytest.mark.parametrize(
    ("tokens", "said"),
    [
        (("--law", "observr"), "law: 'observr' is unknown; did you mean limit_observer"),
        (("--sensitivity-peak", "1"), "sensitivity_peak = 1: must be above 1"),
        (("--resonance-error", "0.6"), "resonance_error = 0.6: must be from 0 to 0.25"),
        (("--setpoint.offset_n", "2"), "saturation is the limit"),
        (
            ("--sensor.resonance_hz", "2500", "--controller.model.resonance_hz", "2500"),
            "a notch must lie below half of controller.rate_hz, 2500 Hz",
        ),
        (("--controller.notch_hz", "3000", "--controller.kind", "notch_pi"), "notch_hz = 3000 Hz: must be below half"),
        (
            ("--controller.kind", "filtered_pi", "--controller.sections", "[[3.0, 0.0, 0.0, 0.0, 0.0]]"),
            "coefficient 3 must be from -2 to 2, which Q31",
        ),
        (("--law", "pi", "--sensitivity-peak", "1.001"), "ki must be above 6.28 1/s to lower anything felt"),
        (("--controller.kind", "tracker"), "take 'notch_pi' (frictionloop design controller)"),
        (("--law", "hinf", "--controller.delay_s", "0.05"), "controller.delay_s = 0.05 s: is 250 control periods"),
        (("no.toml",), "no.toml: cannot be read"),
        (("--slip-lengths-um", "0,b"), "slip_lengths_um = '0,b': must be the least"),
        (("--loads", "0.4,1,2"), "loads = '0.4,1,2': must be the least and the largest in N, such as 0.4,1.2, or one"),
        (("--preset", "feasible", "--loads", "0.4,1.2"), "loads_n: motion.kind = "),
        (("my.toml", "--preset", "bench"), "my.toml and --preset bench both name a system; give one"),
        (("--setpoint.kind", "nothing"), "setpoint.kind"),
    ],
)
def test_bad_input_is_one_line_and_leaves_nothing(frictionloop, tokens, said):
    answer = frictionloop(*CONTROLLER, "--out", "c.toml", "--plots", "figures", *tokens)
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    assert said in answer.err
    assert list(Path().iterdir()) == []


def test_a_saved_controller_is_never_replaced(frictionloop):
    Path("c.toml").write_text("# mine\n")
    answer = frictionloop(*CONTROLLER, "--out", "c.toml")
    assert answer.code == 2
    assert "delete it first, or choose another name" in answer.err
    assert Path("c.toml").read_text() == "# mine\n"


def test_a_synthesis_that_fails_leaves_nothing(frictionloop, monkeypatch):
    def fails(*_):
        raise fl.FrictionloopError("the H-infinity synthesis does not converge: no solution")

    monkeypatch.setitem(SYNTHESES, "hinf", fails)
    answer = frictionloop(*CONTROLLER, "--law", "hinf", "--out", "c.toml")
    assert (answer.code, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "does not converge" in answer.err
    assert list(Path().iterdir()) == []


def test_saturation_is_judged_by_the_friction_law():
    law = law_at(fl.bench())
    lowest = law.nominal_n * math.exp(-law.susceptibility_per_um2 * 2.5**2)
    with pytest.raises(fl.FrictionloopError, match=f"only {lowest:.3g} to 0.95 N"):
        design_controller(fl.bench().evolve({"setpoint.offset_n": 1.5}), "pi")


@pytest.mark.slow
def test_one_contact_is_designed_for_where_it_is_asked_for_and_the_rest_is_told(frictionloop):
    said = " ".join(frictionloop(*CONTROLLER, "--law", "pi", "--slip-lengths-um", "11.5").out.split())
    assert said.startswith(
        "HOLDS but elsewhere CLOSE TO UNSTABLE, when fully moist too; rows below. Where it holds: slip length 11.5 um"
    )
    assert "UNSTABLE slip length 11.5 um at 80 mm/s" in said and "slip length 0 um at 10, 20, 80 mm/s" in said
    assert (
        "`--slip-lengths-um 0,11.5` designs for these lengths. If fingers stroke so, `--speeds 20,80` designs for it;"
        in said
    )


@pytest.mark.slow
def test_a_range_of_loads_is_held_and_a_rate_matters_to_a_board_alone(frictionloop):
    asked = (*CONTROLLER, "--law", "pi", "--loads", "0.4,0.8", "--controller.rate_hz", "4000")
    answer = frictionloop(*asked)
    said = " ".join(answer.out.split())
    assert "slip length 0 to 11.5 um, 20 mm/s, pressed with 0.4 to 0.8 N; 0.5 to 0.7 N" in said
    assert answer.noted == []
    saved = frictionloop(*asked, "--out", "c.toml")
    (note,) = saved.noted
    assert "firmware controller.rate_hz = 4000 Hz: the project's firmware" in " ".join(saved.out.split())
    assert "for its board design with --controller.rate_hz 5000" in note
    (again,) = re.findall("^# Look again: frictionloop design check FILE (.*)", Path("c.toml").read_text(), re.M)
    assert again == "--loads 0.4,0.8"  # both contacts are looked at without a flag
    assert frictionloop("design", "check", "c.toml", *again.split()).out.split()[0] == "HOLDS"
    said = " ".join(frictionloop("design", "check", "c.toml").out.split())
    assert f"by the file `{again}` looks at what it was designed or checked for" in said


@pytest.mark.slow
def test_margins_that_both_contacts_cannot_have_say_that_one_was_not_asked_for(frictionloop):
    asked = (*CONTROLLER, "--law", "pi", "--sensitivity-peak", "1.03")
    answer = frictionloop(*asked, "--slip-lengths-um", "0,11.5")
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    assert "It was to hold from slip length 0 to 11.5 um; `--slip-lengths-um 11.5` asks for one" in answer.err


@pytest.mark.slow
def test_what_holds_on_one_contact_alone_is_designed_for_that_and_says_so_first(frictionloop):
    asked = (*CONTROLLER, "--law", "pi", "--sensitivity-peak", "1.05")
    said = " ".join(frictionloop(*asked).out.split())
    assert "slip length 11.5 um, 20 mm/s" in said.partition("one length")[0]
    assert "No controller of this law holds at every slip length, so this one is for one alone. " in said
    assert "no PI gains with Ms <= 1.05 get there" in said and "`--slip-lengths-um" not in said


@pytest.mark.slow
def test_a_limit_observer_holds_on_both_contacts_and_says_up_to_which_finger(frictionloop):
    answer = frictionloop(*CONTROLLER, "--law", "limit_observer")
    said = " ".join(answer.out.split())
    assert "these limits hold up to a finger 2 times as susceptible as controller.model has it" in said
    assert "UNSTABLE" not in said and "`--slip-lengths-um" not in said


def test_the_estimate_counts_the_errors_that_are_asked_for(frictionloop, monkeypatch):
    said = []

    @contextmanager
    def waiting(text, forecast=""):
        said.append(text + forecast)
        yield

    def stop(*_):
        raise fl.FrictionloopError("enough")

    monkeypatch.setattr(screen, "waiting", waiting)
    monkeypatch.setattr(synthesis, "design_controller", stop)
    for more in ((), ("--delay-error", "0.2"), ("--delay-error", "0.2", "--loads", "0.4,0.8")):
        assert frictionloop("design", "controller", *more).code != 0
    counts = [int(re.search(r"on up to (\d+) loops", text)[1]) for text in said if "loops" in text]
    # A share off either way is two more of each loop, and a range of loads is looked at three.
    assert counts[1:] == [3 * counts[0], 9 * counts[0]]


def test_the_flags_to_look_again_with_are_all_that_was_asked_for():
    lean = Lean(sensor_error=0.1, gain_error=0.2, ends=(("sensor.q", 15.0),))
    asked = Requirements(1.5, 0.1, (15.0, 60.0), lean, (11.5,), (0.4, 1.0))
    assert wanted_flags([], asked) == (
        " --speeds 15,60 --loads 0.4,1 --sensitivity-peak 1.5 --resonance-error 0.1 --sensor-error 0.1 --gain-error 0.2"
        " --corners CERTIFICATE"
    )
    assert wanted_flags([], Requirements()) == ""


def test_with_which_loads_fingers_are_looked_at_is_said_once():
    assert _loads_said([], Requirements(loads_n=(0.5, 0.5))) == "the fingers press with 0.5 N"
    assert _loads_said([], Requirements(loads_n=(0.35, 0.7))) == "the fingers press with 0.35 to 0.7 N"


@pytest.mark.slow  # three designs
def test_a_design_for_other_fingers_has_gains_that_hold_on_all_of_them(frictionloop, tmp_path):
    given, file = ("design", "controller", "--preset", "bench", "--law", "pi"), tmp_path / "gains.toml"
    alone = " ".join(frictionloop(*given).out.split())
    assert "% of 1000 bring a loop gain above" in alone
    assert "`--fingers 100` with this command lowers the gains until the limits" in alone
    answer = frictionloop(*given, "--fingers", "6", "--out", str(file), "--json")
    own = tmp_path / "gains.own-finger.toml"
    kept, pressed, unchecked = answer.noted
    loads = [each["motion.load_n"] for each in fl.fingers(6, 0)]
    assert pressed.startswith(f"the fingers press with {min(loads):.2g} to {max(loads):.2g} N, as people press by")
    assert kept == f"{own} has gains for the finger of the file, until those for all 6 are found"
    assert not own.exists()
    law = fl.read_toml(file).controller
    gains = f"--controller.kp {law.kp:.4g} --controller.ki {law.ki:.4g}"
    assert unchecked == f"gains for all 6 fingers, not checked yet: {gains}"
    told = json.loads(answer.out)
    many, people = told["fingers"]["before_lowering"], fl.fingers(6, 0)
    assert many["count"] == 6 and many["hold"] < 6
    assert told["fingers"]["gains_lowered_to"] == min(many["gain_factor"]) and not told["fingers"]["not_lowered"]
    found = check_fingers(fl.read_toml(file), people, Requirements(slip_lengths_um=(11.5, 0.0)), progress=False)
    assert found["holds"].all() and float(found["gain_factor"].min()) == pytest.approx(1.0, rel=2e-3)
    head = file.read_text(encoding="utf-8").partition("schema = ")[0]
    assert "on fingers: the limits hold on all 6 fingers of seed 0; slip length 0 to 11.5 um" in head
    assert "of other fingers 1 in 7 is to be expected beyond the limits" in head and "sweep FILE" not in head
    said = " ".join(frictionloop(*given, "--fingers", "6").out.split())
    assert said.startswith("HOLDS slip length 0 to 11.5 um, 20 mm/s; 0.5 to 0.7 N;") and "other people" not in said
    assert "design check FILE --fingers 100 --fingers-seed 1` looks at others" in said
    assert "the finger of the file with 0.5 N; where people are to press so, `--loads 0.35,0.7` in this command" in said
    assert f"Those hold on {many['hold']} of these fingers, and are unstable on {6 - sum(many['stable'])}" in said
    refused = frictionloop(*given, "--fingers-seed", "3")
    assert refused.code == 2 and "fingers_seed = 3: needs --fingers N" in refused.err


@pytest.mark.parametrize("command", ["controller", "check"])
def test_forces_out_of_reach_of_a_finger_that_always_slides_are_told(frictionloop, command):
    answer = frictionloop("design", command, "--preset", "paper")
    assert answer.code == 0 and "--fingers" not in answer.out
    said = " ".join(answer.out.split())
    assert "OUT OF REACH -0.8 N of a finger just landed: 0.0744 N is looked at" in said
    assert "motion.contact_s" not in said
