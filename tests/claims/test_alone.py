"""Figures and claims alone: their numbers, and Fig. 5a on a bench that is not the paper's."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating import law_at, reach_n
from frictionloop.cli.figure_text import _scored, figure_text
from frictionloop.design.controller_check import check
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.quantities import FrictionloopError
from frictionloop.report import alone, changed, changed_runs, protocol
from frictionloop.report.device import CONTROLLERS, OPEN, RETUNED_GAINS, fit, tracking
from frictionloop.report.figure_numbers import NUMBERS
from frictionloop.report.figures import DRAWINGS, closed_loop
from frictionloop.report.figures.closed_loop import GIVEN, HERE, HOLDS
from frictionloop.report.people import the_finger
from frictionloop.report.stability import asked_for, stability

pytestmark = pytest.mark.slow  # the figures' runs


@pytest.fixture
def known(results, monkeypatch):
    """Take what other tests have computed."""
    monkeypatch.setattr(alone, "Results", lambda bar: results)


@pytest.mark.usefixtures("known")
def test_some_claims_and_figures_are_made_alone(tmp_path):
    found = alone.alone(tmp_path / "some", ["fig-1b", "resonance"])
    assert [claim.id for claim in found.claims] == ["resonance"]
    assert [figure.name for figure in found.figures] == ["fig-1b"]
    assert sorted(path.name for path in (tmp_path / "some").rglob("*.*")) == ["fig-1b.png", "fig-1b.svg"]


def test_a_name_that_is_neither_figure_nor_claim_is_one_line_with_near_ones(tmp_path):
    with pytest.raises(FrictionloopError, match=r"only = 'fig-5': is neither .* as fig-5[abc] or"):
        alone.alone(tmp_path, ["fig-5"])


@pytest.mark.usefixtures("known")
def test_the_numbers_of_a_figure_are_those_that_statements_are_judged_by(tmp_path, claims):
    judged = {claim.id: claim for claim in claims}
    made = alone.alone(tmp_path, ["fig-2a-reachable", "fig-2c-printed", "fig-5a", "fig-5a-printed", "fig-5b"]).figures
    numbers = {figure.name: figure.numbers for figure in made}
    r2 = judged["closed-loop-r2"].all_values
    assert numbers["fig-5a"][RETUNED_GAINS]["r2_regression"] == r2["re-tuned gains, regression"]
    assert numbers["fig-5a-printed"]["printed gains"]["r2_regression"] == r2["printed gains, regression"]
    thesis = judged["pi-reduces-variability"].told
    assert numbers["fig-5a"][OPEN]["spread_n"] == thesis["open_spread"]
    assert 1e3 * numbers["fig-5a"][RETUNED_GAINS]["error_n"] == thesis["left"]
    assert numbers["fig-5b"]["re-tuned gains, rising"]["from_10_to_90_ms"] == judged["rise-time"].told["mean_10_90"]
    run = fl.simulate(fl.paper())
    assert numbers["fig-2c-printed"]["kp 10, peak-to-peak"]["r2_identity"] == fl.r2_identity(run)
    assert numbers["fig-2a-reachable"]["the paper's"]["r2_bound"] == pytest.approx(1.0)


def test_every_figure_of_a_result_has_numbers(results):
    schemes, stored = {"fig-1a", "fig-1b", "fig-3"}, {"beyond-steps", "beyond-arrivals"}
    assert set(DRAWINGS) - set(NUMBERS) == schemes | stored
    assert all(row for numbers in NUMBERS.values() for row in numbers(results).values())


@pytest.mark.usefixtures("known")
def test_a_change_that_changes_nothing_gives_the_numbers_of_the_report(tmp_path):
    bench = fl.bench()
    same = {"sensor.resonance_hz": bench.sensor.resonance_hz, "controller.delay_s": bench.controller.delay_s}
    for name in changed_runs.SHOWN:
        (paper,), (here,) = (alone.alone(tmp_path, [name], each).figures for each in ({}, same))
        assert {row: here.numbers[row] for row in paper.numbers} == paper.numbers
        assert set(here.numbers) - set(paper.numbers) <= {HERE, HOLDS}
        assert here.unchanged == {row: here.numbers[row] for row in here.unchanged} and paper.unchanged == {}


def test_a_changed_bench_tells_both_pairs_of_gains_apart_and_says_what_was_changed(tmp_path):
    changes = {"sensor.resonance_hz": 200.0, "finger.slip_length_um": 0.0}
    found = alone.alone(tmp_path, ["fig-5a"], changes)
    (figure,) = found.figures
    assert not found.claims
    assert figure.file.name == "fig-5a-with-sensor.resonance_hz-200-finger.slip_length_um-0.svg"
    assert figure.file.exists() and figure.changed == changes
    given, here = figure.numbers[RETUNED_GAINS], figure.numbers[HERE]
    assert (given["kp"], given["ki"]) == tuple(fl.RETUNED.values())
    assert {"controller.kp": here["kp"], "controller.ki": here["ki"]} == fl.retune(fl.bench().evolve(changes)).overrides
    before = figure.unchanged[HERE]
    assert {"controller.kp": before["kp"], "controller.ki": before["ki"]} == fl.retune(protocol.the_bench()).overrides
    drawn, *_ = changed.drawn("fig-5a", changes, alone.Results()._bar)
    assert drawn.get_suptitle() == "Not the paper's bench: sensor.resonance_hz = 200, finger.slip_length_um = 0"
    said = [axes.texts[0].get_text() for axes in drawn.axes]
    for text, row in zip(said, figure.numbers.values(), strict=True):
        assert f"$R^2$ {row['r2_regression']:.3f}\n" in text and "mN rms" in text
    assert "$M_s$" not in said[0] and "unstable" not in said[0]
    assert all("$M_s$" in text or "unstable" in text for text in said[1:])


def test_each_of_several_changes_is_told_alone(tmp_path):
    """The numbers of the report's gains under one change are those of a figure with that change."""
    changes = {"sensor.resonance_hz": 200.0, "controller.delay_s": 3e-4}
    ((both,), (delay,)) = (
        alone.alone(tmp_path, ["fig-5a"], each).figures for each in (changes, {"controller.delay_s": 3e-4})
    )
    alone_ = ["sensor.resonance_hz = 200", "controller.delay_s = 3×10⁻⁴"]
    assert delay.alone == {} and list(both.alone) == ["nothing changed", *alone_, "all together"]
    row = both.alone["controller.delay_s = 3×10⁻⁴"]
    assert {key: row[key] for key in delay.numbers[RETUNED_GAINS]} == delay.numbers[RETUNED_GAINS]
    assert row["open_error_n"] == delay.numbers[OPEN]["error_n"]
    levels = [row[f"error_at_{at:g}_n"] for at in (0.4, 0.6, 0.8)]
    assert np.sqrt(np.mean(np.square(levels))) == pytest.approx(row["error_n"], rel=1e-3)
    assert both.numbers[RETUNED_GAINS]["error_n"] not in {both.alone[each]["error_n"] for each in alone_}
    for which, numbers in {"nothing changed": both.unchanged, "all together": both.numbers}.items():
        same = numbers[RETUNED_GAINS]
        assert {key: both.alone[which][key] for key in same} == same


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
    low_n, _ = reach_n(system, law_at(system, w))
    assert low_n > 0.3 < 0.4
    forces_n = [low_n, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]  # 0.3 N is out of reach then, the sine passes what is not
    peaks = [loop.margins().sensitivity_peak for loop in fl.operating_band(system, forces_n, (w,))]
    assert stability(system).sensitivity_peak_moist == pytest.approx(max(peaks), rel=1e-6)


def test_a_weaker_plate_leaves_forces_out_and_makes_no_loop_calmer():
    """At one force and just landed a linear loop does not know the largest amplitude."""
    finger = protocol.finger_system(the_finger())
    weak = {"plate.max_amplitude_um": 1.8, "controller.model.max_amplitude_um": 1.8}
    printed = finger.evolve(CONTROLLERS["printed gains"] | weak)
    assert stability(printed).sensitivity_peak == np.inf and stability(printed).stable_from_n is None
    tuned = finger.evolve(fl.RETUNED)
    low_n, _ = reach_n(tuned.evolve(weak), law_at(tuned, 0.0))
    assert 0.4 < low_n < 0.5
    there = [low_n, 0.5, 0.6, 0.7, 0.8, 0.9]
    peaks = [loop.margins().sensitivity_peak for loop in fl.operating_band(tuned, there, (0.0,))]
    assert stability(tuned.evolve(weak)).sensitivity_peak == pytest.approx(max(peaks), rel=1e-6)
    assert stability(tuned.evolve(weak)).stable_from_n == low_n


def test_a_heavier_finger_says_what_is_out_of_its_reach_and_the_error_by_level(tmp_path):
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"motion.load_n": 1.0}).figures
    said = " ".join(figure.told)
    there = protocol.finger_system(the_finger()).evolve({"motion.load_n": 1.0})
    low_n, _ = reach_n(there, law_at(there, protocol.occlusion_at_end(there)))
    assert low_n > 0.3  # what the sines ask for at least
    assert f"whatever the gains: forces below {low_n:.3g} N at the end of the last stroke, moister" in said
    assert "error by level, 0.4, 0.6, 0.8 N (mN): open loop " in said


def test_the_bench_unchanged_is_asked_for_the_same(tmp_path):
    sine = {"setpoint.offset_n": 0.8}
    (both,) = alone.alone(tmp_path, ["fig-5a"], sine | {"plate.q": 115.0}).figures
    (alone_,) = alone.alone(tmp_path, ["fig-5a"], sine).figures
    assert both.unchanged.keys() == {OPEN, RETUNED_GAINS, HERE, HOLDS}
    assert all(both.unchanged[row] == alone_.numbers[row] for row in (OPEN, RETUNED_GAINS, HERE))


def test_gains_of_ones_own_stand_beside_the_reports_on_the_papers_bench(tmp_path, results):
    gains = dict(zip(("controller.kp", "controller.ki"), fl.RETUNED.values(), strict=True))
    (figure,) = alone.alone(tmp_path, ["fig-5a"], gains).figures
    assert list(figure.numbers) == [OPEN, RETUNED_GAINS, GIVEN, HOLDS] and figure.unchanged == {}
    assert figure.numbers[GIVEN] == figure.numbers[RETUNED_GAINS] == NUMBERS["fig-5a"](results)[RETUNED_GAINS]
    assert figure.file.name == "fig-5a-with-controller.kp-0-controller.ki-111.svg"


@pytest.mark.parametrize(
    ("names", "changes", "said"),
    [
        (["fig-5b"], {"plate.q": 100.0}, r"only = 'fig-5b': .* fig-5a and fig-5a-printed alone"),
        (["fig-5a", "closed-loop-r2"], {"plate.q": 100.0}, "only = 'closed-loop-r2'"),
        ([], {"plate.q": 100.0}, r"plate.q: .* name fig-5a and fig-5a-printed with only"),
        (["fig-5a"], {"controller.kp": 1.0}, "controller.ki: is missing beside controller.kp; give both"),
        (["fig-5a-printed"], {"controller.kp": 1.0, "controller.ki": 1.0}, "gains of your own are for fig-5a"),
        (["fig-5a"], {"controller.kind": "notch_pi"}, "controller.kind: is set by the protocol"),
        (["fig-5a"], {"setpoint.kind": "constant"}, "setpoint.kind: is set by the protocol"),
        (["fig-5a"], {"setpoint.amplitude_n": "small"}, "setpoint.amplitude_n"),
        (["fig-5a"], {"setpoint.amplitude_n": 0.0}, "setpoint.amplitude_n = 0 N: must be above 0"),
        (["fig-5a"], {"motion.stroke_mm": 60.0}, "motion.stroke_mm: is set by the protocol"),
        (["fig-5a"], {"friction.kind": "gaussian"}, "friction.kind: is set by the protocol"),
        (["fig-5a"], {"plate.qu": 1.0}, "plate.qu"),
    ],
)
def test_what_has_no_meaning_on_a_changed_bench_is_refused(tmp_path, names, changes, said):
    with pytest.raises(FrictionloopError, match=said):
        alone.alone(tmp_path, names, changes)
    assert not list(tmp_path.iterdir())


def test_a_faster_finger_still_makes_one_long_stroke_at_a_time(tmp_path):
    """On a longer path: one that turned round would be scored on what follows the turn."""
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"motion.speed_mm_s": 80.0}).figures
    row = figure.numbers[RETUNED_GAINS]
    assert "scored" not in row and _scored(figure.numbers) == []
    long = {"motion.speed_mm_s": 80.0, "motion.stroke_mm": 960.0, "touch.load.length_mm": 960.0, **fl.RETUNED}
    base, errors = protocol.finger_system(the_finger()).evolve(long), []
    for i, level_n in enumerate(protocol.LEVELS_N):
        for j, stroke in enumerate(protocol.strokes(base)):
            asked = stroke.evolve({"setpoint": protocol.THE_SINES.at(level_n)})
            run = fl.simulate(asked, protocol.STROKE_S, protocol.seed_of(i, j))
            errors.append((run.f_a - run.f_r).values[run.time.values >= protocol.START_S - 1e-9])
    assert row["error_n"] == pytest.approx(np.sqrt(np.mean(np.square(errors))), rel=1e-3)
    (line,) = (each for each in figure.told if "one long one" in each)
    assert "960 mm" in line


def test_a_set_point_of_ones_own_is_one_sine_in_place_of_three(tmp_path, results):
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"setpoint.offset_n": 0.4}).figures
    one = results.tracked[RETUNED_GAINS].sel(level=[0.4])  # the same strokes, by their seeds
    assert figure.numbers[RETUNED_GAINS]["error_n"] == fit(one).rms_n
    assert figure.numbers[RETUNED_GAINS]["r2_regression"] == fit(one).regression
    assert figure.seeds == "0 to 4" and "one sine in place of the protocol's three" in figure.told[0]
    shown = " ".join(str(line).strip() for line in figure_text(figure))
    assert "at those of the forces asked for, 300 to 500 mN, unchanged 300 to 900 mN, that it can be given;" in shown


def test_a_slower_loop_says_what_its_delay_is_and_what_is_held_before(tmp_path):
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"controller.rate_hz": 2000.0}).figures
    said = " ".join(figure.told)
    assert "controller.delay_s = 0.0002: 0.45 ms with half a period of hold, 0.7 ms with that of the integral" in said
    assert "has controller.delay_s = 0.0005 at this rate" in said
    before, now = figure.checked_before.places[RETUNED_GAINS], figure.checked.places[RETUNED_GAINS]
    assert (
        f"hold at {now.held} of 6 slip lengths and speeds, unstable at {now.unstable} (unchanged: {before.held},"
        in (" ".join(str(line).strip() for line in figure_text(figure)))
    )


def test_the_check_of_a_changed_figure_is_of_the_finger_that_it_draws(tmp_path):
    gains = {"controller.kp": 0.006, "controller.ki": 45.0}
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"setpoint.offset_n": 0.4, **gains}).figures
    there = fl.read_toml(figure.bench)
    assert there.friction.nominal_n == the_finger()["friction.nominal_n"]
    assert (there.controller.kp, there.controller.ki) == (0.006, 45.0)
    assert (there.setpoint.offset_n, there.setpoint.amplitude_n) == (0.4, 0.1)
    moist = occlusion_after(there.friction, there.motion.contact_s, there.motion.lifted_s, len(protocol.LOADS))
    assert moist == pytest.approx(protocol.occlusion_at_end(there))
    by_hand = check(there.evolve(gains))
    found = figure.checked.places[GIVEN]
    assert found.held == sum(place.how == "within" for place in by_hand.places)
    assert found.unstable == sum(place.how == "unstable" for place in by_hand.places)
    shown = " ".join(str(line).strip() for line in figure_text(figure))
    assert "on this finger with its own load, slip length 0 and its own, at its speed" in shown
    assert f"design check {figure.bench} --controller.kp" in shown
    row = figure.numbers[HOLDS]
    assert (row["kp"], row["ki"]) == tuple(figure.checked.instead.values()) and row["kp"] == 0.0
    assert f"largest ki that holds at all of them: {row['ki']:.4g} 1/s leaves " in shown
    assert "--speeds 10,80" in shown and "--law" not in shown


def test_gains_that_hold_everywhere_have_a_panel_beside_those_that_do_not(tmp_path):
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"sensor.resonance_hz": 90.0}).figures
    assert list(figure.numbers) == [OPEN, RETUNED_GAINS, HERE, HOLDS]
    row = figure.numbers[HOLDS]
    gains = {"controller.kp": row["kp"], "controller.ki": row["ki"]}
    assert gains == figure.checked.instead
    assert check(asked_for({"sensor.resonance_hz": 90.0}).evolve(gains)).holds_everywhere
    base = protocol.finger_system(the_finger()).evolve({"sensor.resonance_hz": 90.0})
    assert row["error_n"] == fit(tracking(base, gains)).rms_n
    shown = " ".join(str(line).strip() for line in figure_text(figure))
    assert row["kp"] == figure.unchanged[HOLDS]["kp"] == 0.0  # one family of gains, which compare
    before = figure.unchanged[HOLDS]
    both = [f"{each['ki']:.4g} 1/s leaves {1e3 * each['error_n']:.3g} mN" for each in (row, before)]
    assert f"an integral alone with the largest ki that holds at all of them: {both[0]} (unchanged {both[1]})" in shown
    more = check(asked_for({"sensor.resonance_hz": 90.0}).evolve(gains | {"controller.ki": 1.01 * row["ki"]}))
    assert not more.holds_everywhere
    at = check(asked_for({"sensor.resonance_hz": 90.0}).evolve(dict(fl.RETUNED)))
    held = sum(place.how == "within" for place in at.places)
    errors = [f"{1e3 * rows[RETUNED_GAINS]['error_n']:.3g}" for rows in (figure.numbers, figure.unchanged)]
    assert f"{RETUNED_GAINS}: {errors[0]}, unchanged {errors[1]} mN of error" in shown
    assert f"hold at {held} of {len(at.places)} slip lengths and speeds" in shown


def test_a_noisier_sensor_says_what_it_makes_of_the_force_and_that_the_gains_stay(tmp_path):
    (figure,) = alone.alone(tmp_path, ["fig-5a"], {"sensor.noise_density_n_rthz": 4.6e-6}).figures
    said = " ".join(figure.told)
    assert "noise of the sensor in the force: " in said
    assert "The change does not alter them: they are those of the bench unchanged too" in said
    (slower,) = alone.alone(tmp_path, ["fig-5a"], {"plate.q": 460.0}).figures
    assert "does not alter them" not in " ".join(slower.told)
    assert "noise of the sensor" not in " ".join(slower.told)
