"""Figures and claims alone: their numbers, and Fig. 5a on a bench that is not the paper's."""

from __future__ import annotations

import json

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating import reach_at
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.quantities import FrictionloopError
from frictionloop.report import protocol, reproduction
from frictionloop.report.changed_figure import SHOWN, errors_by_level
from frictionloop.report.device import CONTROLLERS, OPEN, PRINTED, RETUNED_GAINS, fit, tracking
from frictionloop.report.figure_numbers import NUMBERS
from frictionloop.report.figures import DRAWINGS, closed_loop
from frictionloop.report.figures.closed_loop import GIVEN, HERE, HOLDS
from frictionloop.report.people import the_finger
from frictionloop.report.stability import asked_for, places_of, stability

HEAVY = {"sensor.resonance_hz": 200.0, "motion.load_n": 1.0}


@pytest.fixture
def known(results, monkeypatch):
    """Take what other tests have computed."""
    monkeypatch.setattr(reproduction, "Results", lambda bar: results)


@pytest.fixture(scope="session")
def heavy(tmp_path_factory):
    """Fig. 5a with a stiffer sensor under a heavier finger."""
    return fl.reproduce(tmp_path_factory.mktemp("heavy"), ["fig-5a"], HEAVY)


@pytest.fixture(scope="session")
def given(tmp_path_factory):
    """Fig. 5a with the re-tuned gains given as one's own, asked for one sine on the paper's bench."""
    gains = dict(zip(("controller.kp", "controller.ki"), fl.RETUNED.values(), strict=True))
    return fl.reproduce(tmp_path_factory.mktemp("given"), ["fig-5a"], {"setpoint.offset_n": 0.4, **gains})


@pytest.mark.usefixtures("known")
def test_some_claims_and_figures_are_made_alone(tmp_path):
    found = fl.reproduce(tmp_path / "some", ["fig-1b", "resonance"])
    assert [claim.id for claim in found.claims] == ["resonance"]
    assert [figure.name for figure in found.figures] == ["fig-1b"]
    assert sorted(path.name for path in (tmp_path / "some").rglob("*.*")) == ["fig-1b.png", "fig-1b.svg"]
    assert json.loads(found.to_json())["claims"][0]["id"] == "resonance"


def test_a_name_that_is_neither_figure_nor_claim_is_one_line_with_near_ones(tmp_path):
    with pytest.raises(FrictionloopError, match=r"only = 'fig-5': is neither .* fig-5[abc]"):
        fl.reproduce(tmp_path, ["fig-5"])


@pytest.mark.slow
@pytest.mark.usefixtures("known")
def test_the_numbers_of_a_figure_are_those_that_statements_are_judged_by(tmp_path, claims):
    judged = {claim.id: claim for claim in claims}
    made = fl.reproduce(tmp_path, ["fig-2a-reachable", "fig-2c-printed", "fig-5a", "fig-5a-printed", "fig-5b"]).figures
    numbers = {figure.name: figure.numbers for figure in made}
    r2 = judged["closed-loop-r2"].all_values
    assert numbers["fig-5a"][RETUNED_GAINS]["r2_regression"] == r2["re-tuned gains, regression"]
    assert numbers["fig-5a-printed"][PRINTED]["r2_regression"] == r2["printed gains, regression"]
    thesis = judged["pi-reduces-variability"].told
    assert numbers["fig-5a"][OPEN]["spread_n"] == thesis["open_spread"]
    assert 1e3 * numbers["fig-5a"][RETUNED_GAINS]["error_n"] == thesis["left"]
    assert numbers["fig-5b"]["re-tuned gains, rising"]["from_10_to_90_ms"] == judged["rise-time"].told["mean_10_90"]
    run = fl.simulate(fl.paper())
    assert numbers["fig-2c-printed"]["kp 10, peak-to-peak"]["r2_identity"] == fl.r2_identity(run)
    assert numbers["fig-2a-reachable"]["the paper's"]["r2_bound"] == pytest.approx(1.0)


@pytest.mark.slow
def test_every_figure_of_a_result_has_numbers(results):
    schemes, stored = {"fig-1a", "fig-1b", "fig-3"}, {"beyond-steps", "beyond-arrivals"}
    assert set(DRAWINGS) - set(NUMBERS) == schemes | stored
    assert all(row for numbers in NUMBERS.values() for row in numbers(results).values())


@pytest.mark.slow
@pytest.mark.usefixtures("known")
def test_a_change_that_changes_nothing_gives_the_numbers_of_the_report(tmp_path):
    same = {"sensor.resonance_hz": fl.bench().sensor.resonance_hz}
    for name in SHOWN:
        (paper,), (here,) = (fl.reproduce(tmp_path, [name], each).figures for each in ({}, same))
        assert {row: here.numbers[row] for row in paper.numbers} == paper.numbers
        assert set(here.numbers) - set(paper.numbers) <= {HERE, HOLDS}
        assert here.changed.unchanged == here.numbers and paper.changed is None


@pytest.mark.slow
def test_a_changed_bench_has_both_pairs_of_gains_beside_those_unchanged(heavy):
    (figure,) = heavy.figures
    assert not heavy.claims and figure.changes == HEAVY
    assert figure.file.name == "fig-5a-with-sensor.resonance_hz-200-motion.load_n-1.svg" and figure.file.exists()
    assert list(figure.numbers) == [OPEN, RETUNED_GAINS, HERE, HOLDS]
    for numbers, bench in ((figure.numbers, fl.bench().evolve(HEAVY)), (figure.changed.unchanged, fl.bench())):
        given, here = numbers[RETUNED_GAINS], numbers[HERE]
        assert (given["kp"], given["ki"]) == tuple(fl.RETUNED.values())
        tuned = fl.retune(bench.evolve({"finger.slip_length_um": 30.0})).overrides
        assert {"controller.kp": here["kp"], "controller.ki": here["ki"]} == tuned
    assert figure.changed.replaced == {
        "sensor.resonance_hz": (200.0, 145.0), "motion.load_n": (1.0, the_finger()["motion.load_n"]),
    }  # fmt: skip
    assert figure.to_dict()["cite"].endswith(f"{figure.command} · seeds 0 to 14")


@pytest.mark.slow
def test_what_is_out_of_reach_of_the_finger_is_a_finding(heavy):
    there = fl.read_toml(heavy.figures[0].bench)
    low_n, _ = reach_at(there, protocol.occlusion_at_end(there))
    (found,) = (each for each in heavy.findings if each.code == "FORCE-REACH")
    assert (found.value, found.where.occluded > 0.5) == (pytest.approx(0.3), True)
    assert found.limit == pytest.approx(low_n, rel=0.02) and low_n > 0.3


@pytest.mark.slow
def test_the_check_is_of_the_finger_that_the_figure_draws(heavy, given):
    (figure,) = heavy.figures
    there = asked_for({**HEAVY, **fl.RETUNED})
    by_hand = fl.design.check(there)
    assert places_of(figure.changed.checks[RETUNED_GAINS]) == places_of(by_hand)
    row = figure.numbers[HOLDS]
    assert row["kp"] == figure.changed.unchanged[HOLDS]["kp"] == 0.0  # one family of gains, which compare
    assert row["ki"] == by_hand.would_hold["controller.ki"] == fl.read_toml(figure.bench).controller.ki
    assert fl.design.check(there.evolve({"controller.ki": row["ki"]})).holds_everywhere
    assert not fl.design.check(there.evolve({"controller.ki": 1.01 * row["ki"]})).holds_everywhere
    base = protocol.finger_system(the_finger()).evolve(HEAVY)
    runs = tracking(base, {"controller.kp": 0.0, "controller.ki": row["ki"]})
    assert row["error_n"] == fit(runs).rms_n
    assert figure.changed.levels[HOLDS] == errors_by_level(runs)
    alone = fl.read_toml(given.figures[0].bench)
    assert alone.friction.nominal_n == the_finger()["friction.nominal_n"]
    assert (alone.setpoint.offset_n, alone.setpoint.amplitude_n) == (0.4, 0.1)
    assert (alone.controller.kp, alone.controller.ki) == tuple(fl.RETUNED.values())
    moist = occlusion_after(alone.friction, alone.motion.contact_s, alone.motion.lifted_s, len(protocol.LOADS))
    assert moist == pytest.approx(protocol.occlusion_at_end(alone))


@pytest.mark.slow
def test_gains_of_ones_own_and_one_sine_stand_beside_the_reports(given):
    (figure,) = given.figures
    assert {OPEN, RETUNED_GAINS, GIVEN} <= set(figure.numbers) and figure.seeds == "0 to 4"
    assert figure.numbers[GIVEN] == figure.numbers[RETUNED_GAINS]
    one = tracking(protocol.finger_system(the_finger()), fl.RETUNED, protocol.Sines((0.4,)))
    assert figure.numbers[GIVEN]["error_n"] == fit(one).rms_n
    assert figure.numbers[GIVEN]["r2_regression"] == fit(one).regression


@pytest.mark.slow
def test_a_panel_says_its_scores_and_where_its_gains_hold(heavy):
    figure = heavy.figures[0]
    drawn = figure.changed.figure
    assert drawn.get_suptitle() == "Not the paper's bench: sensor.resonance_hz = 200, motion.load_n = 1"
    said = [axes.texts[0].get_text() for axes in drawn.axes]
    for text, row in zip(said, figure.numbers.values(), strict=True):
        assert f"$R^2$ {row['r2_regression']:.3f}\n" in text and "mN rms" in text
    assert "$M_s$" not in said[0] and "unstable" not in said[0]
    assert all("$M_s$" in text or "unstable" in text for text in said[1:])


@pytest.mark.parametrize(
    ("peak", "moist", "from_n", "said"),
    [
        (2.75, 4.14, 0.3, "$M_s$ 2.75, when moist 4.14"),
        (2.75, np.nan, 0.3, "$M_s$ 2.75"),
        (2.75, np.inf, 0.3, "$M_s$ 2.75\nunstable when moist"),
        (np.inf, np.inf, None, "unstable"),
        (np.inf, 5.0, 0.5, "unstable below 0.5 N"),
        (None, None, None, ""),
    ],
)
def test_a_panel_says_how_stable_its_loop_is(peak, moist, from_n, said):
    row = {"sensitivity_peak": peak, "sensitivity_peak_moist": moist, "stable_from_n": from_n}
    assert closed_loop._stable(row) == said


def test_a_moist_finger_is_looked_at_where_it_can_be_given_the_force():
    system = protocol.finger_system(the_finger()).evolve(fl.RETUNED)
    w = protocol.occlusion_at_end(system)
    dry = protocol.occlusion_at_starts(system)[-1]
    assert 1.0 - w == pytest.approx((1.0 - dry) * np.exp(-protocol.STROKE_S / system.friction.occlusion_s))
    low_n, _ = reach_at(system, w)
    assert low_n > 0.3 < 0.4
    forces_n = [low_n, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]  # 0.3 N is out of reach then, the sine passes what is not
    peaks = [loop.margins().sensitivity_peak for loop in fl.operating_band(system, forces_n, (w,))]
    assert stability(system).sensitivity_peak_moist == pytest.approx(max(peaks), rel=1e-6)


def test_a_weaker_plate_leaves_forces_out_and_makes_no_loop_calmer():
    """At one force and just landed a linear loop does not know the largest amplitude."""
    finger = protocol.finger_system(the_finger())
    weak = {"plate.max_amplitude_um": 1.8, "controller.model.max_amplitude_um": 1.8}
    printed = finger.evolve(CONTROLLERS[PRINTED] | weak)
    assert stability(printed).sensitivity_peak == np.inf and stability(printed).stable_from_n is None
    tuned = finger.evolve(fl.RETUNED)
    low_n, _ = reach_at(tuned.evolve(weak), 0.0)
    assert 0.4 < low_n < 0.5
    there = [low_n, 0.5, 0.6, 0.7, 0.8, 0.9]
    peaks = [loop.margins().sensitivity_peak for loop in fl.operating_band(tuned, there, (0.0,))]
    assert stability(tuned.evolve(weak)).sensitivity_peak == pytest.approx(max(peaks), rel=1e-6)
    assert stability(tuned.evolve(weak)).stable_from_n == low_n


@pytest.mark.parametrize(
    ("names", "changes", "said"),
    [
        (["fig-5b"], {"plate.q": 100.0}, r"only = 'fig-5b': must be fig-5a or fig-5a-printed"),
        (["fig-5a", "closed-loop-r2"], {"plate.q": 100.0}, "only = 'closed-loop-r2'"),
        ([], {"plate.q": 100.0}, r"only = '': must be fig-5a or fig-5a-printed where plate.q is changed"),
        (["fig-5a"], {"controller.kp": 1.0}, "controller.ki: is missing beside controller.kp"),
        (["fig-5a-printed"], {"controller.kp": 1.0, "controller.ki": 1.0}, "controller.kp: goes with fig-5a"),
        (["fig-5a"], {"controller.kind": "notch_pi"}, "controller.kind: is set by the protocol"),
        (["fig-5a"], {"setpoint.kind": "constant"}, "setpoint.kind: is set by the protocol"),
        (["fig-5a"], {"setpoint.amplitude_n": "small"}, "setpoint.amplitude_n"),
        (["fig-5a"], {"setpoint.amplitude_n": 0.0}, "setpoint.amplitude_n = 0 N: must be above 0"),
        (["fig-5a"], {"motion.stroke_mm": 60.0}, "motion.stroke_mm: is set by the protocol"),
        (["fig-5a"], {"plate.qu": 1.0}, "plate.qu"),
    ],
)
def test_what_has_no_meaning_on_a_changed_bench_is_refused(tmp_path, names, changes, said):
    with pytest.raises(FrictionloopError, match=said):
        fl.reproduce(tmp_path, names, changes)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0, 80.0])
def test_no_stroke_of_a_changed_speed_reaches_the_end_of_its_path(speed):
    """A finger that turned round within a stroke would be scored on what follows the turn."""
    changes = protocol.with_path({"motion.speed_mm_s": speed})
    system = protocol.finger_system(protocol.population()[0]).evolve(changes)
    run = fl.simulate(system, protocol.STROKE_S)
    assert run.scored.values[run.time.values >= protocol.START_S].all()
    assert (changes == {"motion.speed_mm_s": speed}) == (speed <= 20.0)
