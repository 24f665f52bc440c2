"""``frictionloop sweep --fingers``: a population on the bench, in numbers that Python gives too."""

from __future__ import annotations

import csv
import math
import re
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import served
from frictionloop.cli.population import METRICS, Population
from frictionloop.cli.population_reach import reach_of

N, SEED = 12, 5
POPULATION = (
    *("sweep", "--preset", "bench", "--duration-s", "0.5", "--score-from-s", "0.2"),
    *(word for path, gain in fl.RETUNED.items() for word in (f"--{path}", str(gain))),
    *("--fingers", N, "--fingers-seed", SEED),
)


def in_python():
    system = fl.bench().evolve(fl.RETUNED)
    return fl.sweep(system, fl.fingers(N, SEED), 0.5, metrics=METRICS, score_from_s=0.2)


def test_json_holds_the_same_numbers_as_python(frictionloop):
    answer, result = frictionloop(*POPULATION, "--json").json(), in_python()
    assert answer["dims"] == ["finger", "seed"]
    assert list(answer["metrics"]) == [*METRICS[:2], "open_loop_rms_error", *METRICS[2:]]
    for name in METRICS:
        np.testing.assert_array_equal(answer["metrics"][name], result[name])
        assert answer["population"][name]["median"] == np.median(result[name])
    rms = sorted(result.rms_error.values[:, 0])
    assert answer["population"]["rms_error"] == {"median": np.median(rms), "worst_decile": rms[10], "fingers": N}
    r2 = sorted(result.r2_identity.values[:, 0])
    assert answer["population"]["r2_identity"]["worst_decile"] == r2[1]  # 11 of 12 are as good or better
    able = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5)
    assert answer["capable"] == able.capable.values.tolist()
    assert answer["asked_n"] == [pytest.approx(0.5), pytest.approx(0.7)]
    moving = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5, load_moves=True)
    assert answer["served"] == answer["capable_load_moves"] == moving.capable.values.tolist()
    some = result.rms_error.values[moving.capable.values, 0]
    assert answer["population_served"]["rms_error"]["median"] == np.median(some)
    assert (answer["fingers_seed"], answer["runs"], answer["complete"]) == (SEED, N, True)


def test_summary(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    answer = frictionloop(*POPULATION)
    assert (answer.code, answer.err) == (0, "")
    able = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5)
    count = int(able.capable.sum())
    moving = fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5, load_moves=True)
    assert 0 < int(moving.capable.sum()) < count
    said, answered = " ".join(answer.out.split()), int(moving.capable.sum())
    assert f"{answered} of {N} fingers can be given the set-point, 0.5 to 0.7 N, in ordinary use: as the load" in said
    assert f"able steady load load moves in 0.5 s on the plate {count} {answered} under" in said
    low, high = int((~able.reaches_low).sum()), int((~able.reaches_high).sum())
    assert f"under a steady load in this run, {low} of {N} cannot get so low, {high} cannot get so high" in said
    assert f"of the {answered}: median worst decile" in said and f"the {answered} are those below" in said
    median = 1e3 * float(in_python().rms_error.median())
    assert re.search(rf"^rms_error +{median:.4g} mN ", answer.out, re.MULTILINE)
    assert f"{N} fingers of 0.5 s, {N} of {N} runs done" in answer.out
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 100


def test_it_says_which_values_of_the_bench_fingers_replace(frictionloop):
    loads = [each["motion.load_n"] for each in fl.fingers(N, SEED)]
    said = " ".join(frictionloop(*POPULATION, "--finger.mass_kg", "2e-4").out.split())
    assert f"replaces motion.load_n 0.5 N by its own ({min(loads):.3g} to {max(loads):.3g})" in said
    assert "motion: load_drift, tremor_hz" in said and "mass_kg" not in said.partition("Each finger")[2]
    told = frictionloop(*POPULATION, "--json").json()["replaced"]
    assert told == {
        path: getattr(getattr(fl.bench(), path.split(".")[0]), path.split(".")[1])
        for path in fl.fingers(1, 0)[0]
        if path != "motion.person"
    }


def test_files_hold_who_can_what(frictionloop):
    assert frictionloop(*POPULATION, "--csv", "f.csv", "--out", "f.h5").code == 0
    kept, able = fl.load("f.h5"), fl.capable(fl.fingers(N, SEED), 0.5, 0.7, contact_s=0.5)
    np.testing.assert_array_equal(kept.capable, able.capable)
    np.testing.assert_array_equal(kept.lowest_n, able.lowest_n)
    with open("f.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["capable"] for row in rows] == [str(each) for each in able.capable.values]
    nominal = [each["friction.nominal_n"] for each in fl.fingers(N, SEED)]
    assert [float(row["friction.nominal_n"]) for row in rows] == nominal
    before = Path("f.csv").read_bytes()
    resumed = frictionloop(*POPULATION, "--csv", "f.csv", "--out", "f.h5", "--resume")
    assert (resumed.code, Path("f.csv").read_bytes()) == (0, before)


@pytest.mark.slow
def test_one_finger_and_several_seeds(frictionloop):
    words = ("sweep", "--preset", "bench", "--duration-s", "0.5", "--fingers", "1", "--seeds", "2")
    answer = frictionloop(*words)
    assert "1 finger x 2 seeds of 0.5 s, 2 of 2 runs done" in answer.out
    found = frictionloop(*words, "--json").json()
    assert found["population"]["rms_error"]["median"] == pytest.approx(np.mean(found["metrics"]["rms_error"]))


@pytest.mark.slow
def test_a_population_of_a_loop_that_rings_is_told(frictionloop, monkeypatch):
    monkeypatch.setenv("COLUMNS", "100")
    words = ("sweep", "--preset", "bench", "--duration-s", "1", "--fingers", N)
    answer = frictionloop(*words)
    assert (answer.code, answer.err) == (0, "")
    assert re.search(
        r"^This loop rings: \d+% of the commands are clamped, the force does not",
        answer.out,
        re.MULTILINE,
    )
    assert "\nkp = 10, ki = 2: too much for this sensor, plate and delay.\n" in answer.out
    assert (
        "\nThey hold with Ms up to 2, dry and moist (occluded 100%), at the set-point's levels (0.5 to 0.7 N),"
        in answer.out
    )
    assert "slip length 11.5 um, 20 mm/s, sensor resonance 145 Hz" in " ".join(answer.out.split())
    assert "\nMs stays below 4 with the resonance 10% off, also on slip length 11.5 um at 10, 80 mm/s;" in answer.out
    assert "on slip length 0 um at 10, 20, 80 mm/s." in " ".join(answer.out.split())
    gains = re.search(r"^Gains that hold: (.*)$", answer.out, re.MULTILINE)[1].split()
    assert "Gains that hold" not in frictionloop(*words, *gains).out
    found = frictionloop(*words, "--json").json()["ringing"]
    assert (found["stable"], found["frequency_hz"]) == (False, None)
    assert fl.linearise(fl.bench().evolve(found["held"])).margins().stable
    assert max(len(line.rstrip()) for line in answer.out.splitlines()) <= 100


@pytest.mark.parametrize(
    "words",
    [
        [word for path, gain in fl.RETUNED.items() for word in (f"--{path}", gain)],
        ("--metrics", "rms_error"),
        ("--plate.max_amplitude_um", "0.06", "--controller.model.max_amplitude_um", "0.06"),
    ],
    ids=["gains that hold", "R2 not asked for", "out of reach"],
)
def test_nothing_is_said_of_ringing_otherwise(frictionloop, words):
    """Nearly without vibration no controller does better: the bound is as low as the median."""
    tokens = ("sweep", "--preset", "bench", "--duration-s", "1", "--fingers", N, *words)
    assert frictionloop(*tokens, "--json").json()["ringing"] is None
    assert "This loop" not in frictionloop(*tokens).out


def population(setpoint, duration_s=0.01, **more):
    system = fl.bench().evolve({"setpoint": setpoint, **more})
    people = fl.fingers(4, 0)
    result = fl.sweep(system, people, duration_s, metrics=["rms_error"])
    return Population(result, 1.0, True, system, people)


def test_worst_decile_of_each_kind_of_metric():
    found = population(fl.Constant(offset_n=0.6))
    for name, values, worst in (
        ("rms_error", [0.1, 0.4, 0.2, 0.3], 0.4),
        ("perceptual_index", [3.0, 2.0, 1.0, np.nan], 3.0),
        ("r2_identity", [0.1, 0.4, 0.2, 0.3], 0.1),
        ("slope", [1.1, 0.8, 1.0, 1.15], 0.8),
        ("rise_63_s", [np.nan] * 4, np.nan),
    ):
        found.result[name] = (("finger", "seed"), np.array(values)[:, None])
        spread = found.spread(name)
        assert spread["worst_decile"] == pytest.approx(worst, nan_ok=True)
        assert spread["fingers"] == np.sum(~np.isnan(values))


def test_a_constant_set_point_is_one_level():
    text = population(fl.Constant(offset_n=0.6)).summary(0.01)
    assert any("the set-point, 0.6 N, in ordinary use" in str(line) for line in text)


def test_the_finger_is_held_until_the_last_contact_of_the_run_ends():
    people = fl.fingers(30, 0)
    system = fl.bench().evolve({"motion.contact_s": 2.0, "motion.lifted_s": 0.5})
    band, reach = reach_of(system, people, 10.0)
    assert (reach.contact_s, reach.contacts) == (2.0, 4)
    np.testing.assert_array_equal(band.highest_n, fl.capable(people, contact_s=2.0, contacts=4).highest_n)
    assert (
        reach.in_the_end.sum()
        == fl.capable(people, 0.5, 0.7, contact_s=2.0, contacts=np.inf).capable.sum()
        < sum(reach.able)
    )
    once, stays = (reach_of(system.evolve({"motion.contact_s": each}), people, 10.0)[1] for each in (12.0, 0.0))
    for each in (once, stays):
        assert (each.contact_s, each.contacts) == (10.0, 1)
    # A run of a part of one contact: who lifts after it lands again, and is moister in the end.
    again = fl.capable(people, 0.5, 0.7, contact_s=12.0, contacts=np.inf)
    np.testing.assert_array_equal(once.in_the_end, again.capable)
    assert stays.in_the_end is None and 0 < again.capable.sum() < once.able.sum()
    assert once.able.tolist() == stays.able.tolist()
    _, weak = reach_of(system.evolve({"plate.max_amplitude_um": 1.0}), people, 10.0)
    assert weak.low.sum() < reach.low.sum()


def test_contact_upon_contact_is_told_of_in_the_end(frictionloop):
    lifts = ("--motion.contact_s", "2", "--fingers", "20", "--duration-s", "4")
    answer = frictionloop("sweep", "--preset", "bench", "--controller.kp", "0.06", "--controller.ki", "60", *lifts)
    people = fl.fingers(20, 0)
    count = int(fl.capable(people, 0.5, 0.7, contact_s=2.0, contacts=np.inf).capable.sum())
    moving = fl.capable(people, 0.5, 0.7, contact_s=2.0, contacts=np.inf, load_moves=True)
    said = " ".join(answer.out.split())
    assert re.search(r"in 2 contacts of 2 s on the plate \d+ \d+ after", said)
    assert f"after many more contacts {count} {moving.capable.sum():d} under a steady load" in said
    assert said.count(f"{moving.capable.sum():d} of 20 fingers can be given the set-point") == 1
    assert "for 95 % of the time, contact upon contact" in said
    assert "those of this run, of fingers dry at first; later ones: --duration-s 60 --score-from-s 40" in said


def test_the_error_in_open_loop_is_that_of_the_lookup_table_alone(frictionloop):
    """Beside the error of the loop, of the same fingers and seeds; none where the loop is open already."""
    found = frictionloop(*POPULATION, "--json").json()
    opened = fl.bench().evolve({"controller.kind": "lookup", "controller.form": "float"})
    alone = fl.sweep(opened, fl.fingers(N, SEED), 0.5, metrics=["rms_error"], score_from_s=0.2)
    np.testing.assert_array_equal(found["metrics"]["open_loop_rms_error"], alone.rms_error)
    worst = np.sort(alone.rms_error.values[:, 0])[10]
    assert found["population"]["open_loop_rms_error"]["worst_decile"] == worst
    for more in (("--controller.kind", "lookup"), ("--metrics", "r2_identity")):
        assert "open_loop" not in frictionloop(*POPULATION, *more).out


def test_its_figure_draws_both_errors_in_one_panel(frictionloop):
    assert frictionloop(*POPULATION, "--out", "f.h5").code == 0
    panels = fl.plot(fl.load("f.h5")).axes
    assert [panel.get_ylabel() for panel in panels] == [
        "r2_identity",
        "rms_error (mN)",
        "saturation_index",
        "perceptual_index",
    ]
    words = [text.get_text() for text in panels[1].get_legend().get_texts()]
    assert words[0].startswith("open loop, median ")


def test_values_of_the_system_that_no_finger_brings_count():
    brought = "friction.occlusion_s"
    people = [{path: value for path, value in each.items() if path != brought} for each in fl.fingers(5, 0)]
    quick, plain = (reach_of(fl.bench().evolve({"friction.occlusion_s": each}), people, 1.0)[0] for each in (2.0, 20.0))
    named = fl.capable([{"friction.occlusion_s": 2.0} | each for each in people], 0.5, 0.7, contact_s=1.0)
    assert quick.lowest_n.values.tolist() == named.lowest_n.values.tolist() != plain.lowest_n.values.tolist()


def test_drawn_friction_is_that_at_the_load_and_speed_of_the_drawing_whatever_the_files():
    people = fl.fingers(5, 0)
    other = fl.bench().evolve({"friction.reference_load_n": 0.25, "friction.reference_speed_mm_s": 60.0})
    there, plain = (reach_of(each, people, 1.0)[0] for each in (other, fl.bench()))
    assert there.highest_n.values.tolist() == plain.highest_n.values.tolist()
    errors = [fl.sweep(each, people, 1.0, metrics=["rms_error"]).rms_error.values for each in (other, fl.bench())]
    np.testing.assert_array_equal(*errors)


@pytest.mark.slow
def test_a_recorded_set_point_is_judged_by_its_lowest_and_highest_value(frictionloop):
    force_n = np.tile([0.3, 0.55, 0.8, 0.6], 250)
    np.savetxt("r.csv", force_n, header="force", comments="")
    words = ("--setpoint.kind", "recording", "--setpoint.path", "r.csv", "--setpoint.rate_hz", "1000")
    more = ("--setpoint.column", "force", "--setpoint.offset_n", "0.1", "--fingers-seed", SEED)
    flags = ("sweep", "--preset", "bench", "--duration-s", "0.5", "--fingers", N, *words, *more)
    able = fl.capable(fl.fingers(N, SEED), 0.4, 0.9, contact_s=0.5).capable.values
    assert 0 < able.sum() < N
    found = frictionloop(*flags, "--json").json()
    assert (found["asked_n"], found["capable"]) == ([pytest.approx(0.4), pytest.approx(0.9)], able.tolist())
    said = " ".join(frictionloop(*flags).out.split())
    assert "fingers can be given the set-point, 0.4 to 0.9 N, in ordinary use" in said
    assert f"in 0.5 s on the plate {able.sum()} " in said


def test_a_set_point_from_outside_is_not_judged():
    class Hum(fl.Signal):
        """A force from outside."""

        kind: str = "hum"

        def force_n(self, time_s):
            """Return 0.5 N."""
            return 0.5 + 0.0 * time_s

    system = fl.bench().model_copy(update={"setpoint": Hum()})
    assert 'setpoint.kind = "hum": its level is unknown' in reach_of(system, fl.fingers(3, 0), 0.5)[1]


def test_interrupted_population_says_what_is_done_and_how_to_go_on(frictionloop, monkeypatch):
    partial = in_python()
    for values in partial.data_vars.values():
        values[5:] = np.nan

    def sweep(*_, **__):
        raise fl.SweepInterrupted(partial)

    monkeypatch.setattr("frictionloop.loop.sweep.sweep", sweep)
    monkeypatch.setattr("frictionloop.cli.outcome.compiled", lambda *_: None)
    answer = frictionloop(*POPULATION, "--out", "f.h5")
    assert answer.code == 130
    assert "of 5 fingers" in answer.out
    assert answer.err.startswith(f"interrupted: 5 of {N} runs done, kept in f.h5\ncontinue with: ")
    assert int(np.isfinite(fl.load("f.h5").rms_error).sum()) == 5


def test_why_it_is_not_known_who_can_be_given_a_set_point_is_said(frictionloop, tmp_path):
    """Not that its levels are unknown, but what the system cannot have: a force beyond the sensor's range."""
    time_s = np.arange(300) / 100
    rows = np.c_[time_s, 2.0 + np.sin(9 * time_s)]
    np.savetxt("high.csv", rows, delimiter=",", header="time_s,force_n", comments="")
    signal = ("--setpoint.kind", "recording", "--setpoint.path", "high.csv", "--setpoint.column", "force_n")
    flags = ("--preset", "bench", *signal, "--duration-s", "1")
    said = frictionloop("sweep", *flags, "--fingers", "2").out
    assert "can be given the set-point is not known: sensor.range_n = 2.5 N" in " ".join(said.split())
    alone = " ".join(frictionloop("simulate", *flags).out.split())
    assert "The recorded setpoint reaches 3 N, and the sensor's range ends at sensor.range_n = 2.5 N." in alone


def test_fingers_unlike_that_of_the_file_are_told_first(frictionloop):
    """A friction that was set to that of a recorded finger is replaced by that of each finger."""
    Path("light.toml").write_text('schema = 1\npreset = "bench"\n[friction]\nnominal_n = 0.1\n')
    light = frictionloop("sweep", "light.toml", "--duration-s", "0.5", "--fingers", N).out
    assert "None of these fingers is like that of the file" in " ".join(light.split())
    assert light.index("None of these") < light.index("rms_error")
    assert "None of these fingers" not in frictionloop(*POPULATION).out


@pytest.mark.parametrize(("able", "total"), [(0, 30), (9, 30), (42, 100), (100, 100)])
def test_what_a_draw_says_of_all_fingers_is_wilsons_interval(able, total):
    """(p + z^2/2n -+ z sqrt(p(1 - p)/n + z^2/4n^2))/(1 + z^2/n) with z of 97.5 %."""
    z, p = 1.959963984540054, able / total
    middle, half = p + z * z / (2 * total), z * math.sqrt(p * (1 - p) / total + (z / (2 * total)) ** 2)
    low, high = (100 * (middle + sign * half) / (1 + z * z / total) for sign in (-1.0, 1.0))
    assert served._share(np.arange(total) < able, total) == f"{abs(low):.0f} to {high:.0f} %"
