"""Studies with simulated participants: what is put in comes out, and every bundled protocol runs."""

import itertools

import h5py
import numpy as np
import pandas
import psignifit
import pytest
from scipy.stats import norm, ttest_rel

import frictionloop as fl
from frictionloop.experiments import Protocol, read_protocol, read_trials, session_export
from frictionloop.experiments.levels_within_reach import needed
from frictionloop.experiments.planning import check
from frictionloop.experiments.protocol import bundled, to_toml
from frictionloop.experiments.psychometric import JND_Z, fit, probability
from frictionloop.experiments.resumable_session import run
from frictionloop.experiments.simulated_participant import Observer
from frictionloop.experiments.study_run import STUDY, outside, simulate_trials, study_of, study_system, unfitted
from frictionloop.experiments.study_summary import contrasts, fits, funnel, groups
from frictionloop.experiments.trial_records import measures, number_of, scored
from frictionloop.experiments.trial_sequence import TrialOrder, latin_square
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.shapes import Grating
from frictionloop.report.psychophysics_page import page


def short(name, trials=4):
    """Return a bundled protocol cut down to a few short trials."""
    plan = read_protocol(name)
    changes = {"stop.trials": trials, "timeline.stroke.length_mm": 10.0, "blocks.practice": 0}
    if plan.method.kind == "constant":
        changes |= {"method.repeats": 1, "method.levels": plan.method.levels[::3]}
    if plan.method.kind == "adjustment":
        changes |= {"method.settings": 2, "method.step": 0.1}
    if plan.method.kind == "psi":
        changes |= {"method.thresholds": 12, "method.spreads": 4, "method.levels": 8}
    return plan.evolve(changes)


def test_the_gains_of_the_study_hold_on_the_finger_that_it_asks():
    assert study_system().controller.kind == "notch_pi"
    peaks = [fl.linearise(study_system(), force_n=force_n).sensitivity_peak() for force_n in (0.5, 0.6, 0.7)]
    assert max(peaks) <= 1.5 * 1.001  # the rule of fl.retune_notch


@pytest.mark.slow
def test_the_gains_of_the_study_are_found_again():
    found = fl.retune_notch(fl.bench()).overrides
    assert {name: found[name] for name in STUDY if name != "controller.kind"} == pytest.approx(
        {name: value for name, value in STUDY.items() if name != "controller.kind"}, rel=2e-3
    )


@pytest.mark.parametrize("name", bundled())
def test_a_bundled_protocol_survives_its_file_and_passes_its_check(name, tmp_path):
    plan = read_protocol(name)
    path = tmp_path / "copy.toml"
    path.write_text(to_toml(plan))
    assert Protocol.from_tree(read_tree(path)) == plan
    text = path.read_text()
    assert "# masking_db =  # Masking noise" in text or plan.masking_db is not None
    assert "accepts latin, given, random" in text
    found = check(plan, study_system())
    assert found.trials[0] > 0
    assert found.share_in_reach > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("name", bundled())
def test_every_bundled_protocol_runs_and_is_reported(name):
    plan = short(name, 6)
    trials = simulate_trials(plan, participants=2)
    assert trials["counted"].sum() > 0
    found = fits(plan, trials)
    assert len(found) == 2 * 2 * len(plan.conditions)
    told = funnel(trials)
    for condition in plan.conditions:
        own = told[told["condition"] == condition.name].set_index("what")["trials"]
        assert own["presented"] == own.drop("presented").sum()
    assert "</html>" in page(study_of(plan, trials, "two"))


@pytest.mark.slow
@pytest.mark.parametrize("name", bundled())
def test_every_bundled_protocol_runs_on_a_device_on_its_own_clock(name, tmp_path):
    path = run(short(name, 2), tmp_path / "P01", "P01", address="sim:", trials=2).folder
    trials = pandas.read_csv(path / "trials.tsv", sep="\t")
    assert (np.diff(trials["onset_s"]) > 0).all()
    raw = fl.load(path / trials["raw"][0])
    assert raw.attrs["board"]


def test_a_level_that_the_finger_cannot_be_given_is_not_told_as_delivered():
    plan = short("jnd-friction-constant").evolve({"stimulus.standard": 0.42, "method.levels": [-0.1, 0.1]})
    finger = {"friction.nominal_n": 0.7, "friction.susceptibility_per_um2": 0.1}  # 0.45 N and more
    trials = simulate_trials(plan, population=[finger], progress=False).set_index("requested")
    assert trials["delivered"][-0.1] == pytest.approx(0.0, abs=0.02)
    assert 0.02 < trials["delivered"][0.1] < 0.09


@pytest.mark.parametrize(("field", "asked"), [("offset_n", 1.1), ("amplitude_n", 0.5)])
def test_a_grating_out_of_reach_is_told_as_what_the_finger_got(field, asked):
    finger = {"friction.nominal_n": 0.7, "friction.susceptibility_per_um2": 0.1, "controller.kind": "lookup"}
    effect = Grating(offset_n=0.55, amplitude_n=0.05, spacing_mm=4.0).model_copy(update={field: asked})
    system = fl.bench().evolve(finger).model_copy(update={"setpoint": EffectSource(effect=effect)})
    run = fl.simulate(system, 1.0, seed=1)
    plan = Protocol(stimulus={"effect": effect, "field": field, "standard": asked})
    x, f = (run[name].values[run["scored"].values] for name in ("position", "f_a"))
    wave = np.stack([np.ones(x.size), np.sin(2 * np.pi * x / 4e-3)], axis=1)
    mean, amplitude = np.linalg.lstsq(wave, f)[0]
    assert measures(run, plan, asked).level == pytest.approx(mean if field == "offset_n" else amplitude, rel=0.01)


def test_a_study_is_the_same_whoever_takes_part_beside():
    plan = short("jnd-friction-staircase", 3)
    one, two = simulate_trials(plan, participants=1, seed=4), simulate_trials(plan, participants=2, seed=4)
    pandas.testing.assert_frame_equal(one, two[two["participant"] == "P01"].reset_index(drop=True))


def test_a_fit_is_that_of_psignifit():
    rng = np.random.default_rng(0)
    level = np.repeat(np.linspace(0.02, 0.2, 7), 40)
    result = (rng.random(level.size) < probability(level, 0.08, 0.04, 0.5, 0.02)).astype(float)
    ours = fit(level, result)
    data = [[x, result[level == x].sum(), (level == x).sum()] for x in np.unique(level)]
    theirs = psignifit.psignifit(np.array(data), experiment_type="2AFC", sigmoid="norm", fixed_parameters={"eta": 1e-6})
    assert ours.threshold == pytest.approx(theirs.parameter_estimate["threshold"], rel=0.05)
    low, high = theirs.confidence_intervals["threshold"]["0.95"]
    assert (ours.threshold_low, ours.threshold_high) == pytest.approx((low, high), abs=0.012)


def test_the_95_percent_interval_holds_the_threshold_95_times_in_100():
    rng, held, apart = np.random.default_rng(1), 0, []
    level = np.repeat(np.linspace(0.03, 0.25, 6), 10)
    for _ in range(300):
        a, b = rng.uniform(0.07, 0.18), rng.uniform(0.02, 0.08)
        result = (rng.random(level.size) < probability(level, a, b, 0.5, 0.02)).astype(float)
        found = fit(level, result, low=0.0, ends=(0.03, 0.25))
        held += found.threshold_low <= a <= found.threshold_high
        apart.append(found.threshold / a - 1.0)
    assert 0.92 <= held / 300 <= 0.98
    assert abs(np.mean(apart)) < 0.05


def test_a_jnd_of_constant_stimuli_is_neither_small_nor_large():
    rng, plan, jnd, found = np.random.default_rng(3), read_protocol("jnd-friction-constant"), 0.04, []
    level = np.repeat(plan.method.levels, plan.method.repeats)
    for _ in range(40):
        result = (rng.random(level.size) < 0.01 + 0.98 * norm.cdf(norm.ppf(0.75) * level / jnd)).astype(float)
        found.append(JND_Z * np.array(fit(level, result, None)[3:6]))
    value, low, high = np.transpose(found)
    assert np.median(value) == pytest.approx(jnd, rel=0.15)
    assert np.mean((low <= jnd) & (jnd <= high)) >= 0.9


@pytest.mark.parametrize(("name", "press"), [("study-friction", "1"), ("jnd-friction-constant", "2")])
def test_of_a_robot_that_presses_one_key_nothing_is_found_among_the_levels(name, press):
    plan, rows = read_protocol(name), []
    for code in ("P01", "P02", "P03"):
        order = TrialOrder(plan, code)
        while (trial := order.next()) is not None:
            _, result = scored(plan, trial.level, trial.comparison, press)
            rows.append({
                "participant": code, "condition": trial.condition.name, "phase": trial.phase, "counted": 1, "again": 0,
                "requested": trial.level, "delivered": trial.level, "result": result, "onset_s": 0.0, "offset_s": 1.0,
            })  # fmt: skip
            order.tell(rows[-1])
    found = fits(plan, pandas.DataFrame(rows), ("requested",))
    low, high = plan.method.extremes()
    assert not found["value"].between(low, high).any()
    codes = {each.code: each.value for each in (*unfitted(found, "one"), *outside(plan, found))}
    assert sum(codes.values()) == len(found)
    assert codes["STUDY-UNFITTED"] > codes.get("STUDY-OUTSIDE", 0)


def test_a_difference_of_conditions_is_paired_and_has_its_unit():
    plan = read_protocol("study-friction")
    closed, open_ = np.array([0.05, 0.08, 0.03]), np.array([0.07, 0.09, 0.08])
    table = pandas.DataFrame({
        "participant": ["P1", "P2", "P3", "P3", "P2", "P1"], "condition": ["closed"] * 3 + ["open"] * 3,
        "level": "requested", "value": [*closed, *open_[::-1]],
    })  # fmt: skip
    (row,) = contrasts(plan, table).to_dict("records")
    expected = ttest_rel(open_, closed).confidence_interval(0.95)
    assert (row["condition"], row["unit"], row["participants"]) == ("open - closed", "N", 3)
    assert (row["low"], row["high"]) == pytest.approx((expected.low, expected.high))
    assert contrasts(read_protocol("jnd-friction-staircase"), table).empty


def test_overdispersed_answers_are_told():
    rng = np.random.default_rng(2)
    level = np.repeat(np.linspace(0.0, 0.25, 6), 60)
    p = np.repeat(probability(np.linspace(0.0, 0.25, 6), 0.1, 0.05), 60)
    plain = fit(level, (rng.random(level.size) < p).astype(float)).dispersion
    shifted = np.clip(p + np.repeat([0.2, -0.2, 0.2, -0.2, 0.2, -0.2], 60), 0.01, 0.99)
    assert plain < 3.0
    assert fit(level, (rng.random(level.size) < shifted).astype(float)).dispersion > 5.0


@pytest.mark.slow
def test_simulated_participants_have_the_threshold_that_they_were_given():
    observer = Observer(weber=0.11, lapse=0.0)
    plan = read_protocol("jnd-friction-constant").evolve({"blocks.practice": 0, "method.repeats": 20})
    found = groups(fits(plan, simulate_trials(plan, participants=8, observer=observer)))
    mean = found[found["level"] == "delivered"]["mean"].iloc[0]
    # Two intervals of spread w F / (sqrt 2 z) and the skin's threshold of 25 mN or so in each.
    expected = 0.6745 * np.hypot(0.11 * 0.4 / 0.6745, np.sqrt(2) * 0.025)
    assert mean == pytest.approx(expected, rel=0.2)


@pytest.mark.parametrize("n", [2, 3, 4, 5, 6])
def test_a_latin_square_has_each_after_each_equally_often(n):
    rows = latin_square(n)
    pairs = [(a, b) for row in rows for a, b in itertools.pairwise(row)]
    assert all(sorted(row) == list(range(n)) for row in rows)
    assert {pairs.count(pair) for pair in pairs} == {len(rows) // n}


def test_conditions_are_counterbalanced_by_the_number_in_the_code():
    plan = read_protocol("study-friction")
    first = [TrialOrder(plan, f"P{k:02d}").conditions[0].name for k in range(1, 5)]
    assert first == ["closed", "open"] * 2


def test_needed_forces_are_those_of_the_levels():
    assert needed(read_protocol("jnd-friction-staircase"))[:2] == pytest.approx((0.35, 0.55))
    assert needed(read_protocol("detection-threshold"))[:2] == pytest.approx((0.28, 0.52), abs=1e-3)


def test_a_number_of_trials_ends_any_method_and_constant_stimuli_end_without():
    plan = read_protocol("jnd-friction-constant").evolve({"blocks.practice": 0})
    assert check(plan, study_system()).trials == (84, 84)
    assert check(plan.evolve({"stop.trials": 10}), study_system()).trials == (10, 10)
    with pytest.raises(FrictionloopError, match="stop is missing: trials, reversals, width or time_s"):
        Protocol(method={"kind": "psi"}, stop={})


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"level_unit": "mm"}, "level_unit = 'mm': must be N, as level_n"),
        ({"question": " "}, "question = ' ': must be what is asked"),
        ({"method.start": [0.5]}, r"start = \[0.5\]: must be within 0.005 to 0.2"),
        ({"stimulus.standard": 3.0}, "forces = 3 to 3.2 N: in reach of none of 200 fingers"),
        ({"method": {"kind": "psi", "low": 0.2, "high": 0.1}}, "high = 0.1: must be above low, 0.2"),
        (
            {"task": "yes_no", "attribute": "pattern", "level_unit": "mm", "stimulus.field": "height_mm",
             "stimulus.adds": False, "stimulus.effect": {"kind": "ridge"}, "method": {"kind": "psi", "low": -0.1}},
            "height_mm = -0.1: must be 0 or more",
        ),
        ({"task": "magnitude", "stimulus.standard": None, "method": {"kind": "constant", "levels": [0.0, 0.3]}},
         "level_n = 0: must be above 0 for task 'magnitude'"),
    ],
)  # fmt: skip
def test_what_cannot_be_right_of_a_protocol_is_refused(changes, said):
    with pytest.raises(FrictionloopError, match=said):
        check(read_protocol("jnd-friction-staircase").evolve(changes))


def test_a_level_has_the_unit_of_its_field():
    effect = {"kind": "grating", "offset_n": 0.4, "amplitude_n": 0.08}
    plan = Protocol(stimulus={"field": "spacing_mm", "standard": 2.0, "effect": effect})
    assert plan.level_unit == "mm"


@pytest.mark.parametrize(
    ("task", "answer", "said"),
    [
        ("magnitude", "nan", "above 0"),
        ("magnitude", "0", "above 0"),
        ("magnitude", "much", "above 0"),
        ("tracking", "inf", "from 0 to 100"),
        ("tracking", "-1", "from 0 to 100"),
    ],
)
def test_an_answer_that_is_no_number_of_the_task_is_refused(task, answer, said):
    assert number_of(task, "12.5") == 12.5
    with pytest.raises(FrictionloopError, match=f"must be a number {said}"):
        number_of(task, answer)


def test_answers_that_are_all_alike_have_no_threshold_and_one_beside_all_levels_is_told():
    level = np.linspace(0.0, 0.2, 20)
    with pytest.raises(FrictionloopError, match="20 answers, all alike"):
        fit(level, np.ones(20), None)
    assert fit(level, (level > 0.001).astype(float), None).at_edge
    assert not fit(level, (level > 0.1).astype(float), None).at_edge


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return run(short("jnd-friction-staircase", 2), tmp_path_factory.mktemp("e") / "P01", "P01").folder


def test_an_export_is_read_back_by_other_programs(session, tmp_path):
    beh = read_trials(session)
    session_export.csv(session, tmp_path / "p.csv")
    table = pandas.read_csv(tmp_path / "p.csv")
    assert (table["intensity"] == beh["requested"]).all()
    session_export.hdf5(session, tmp_path / "p.h5")
    with h5py.File(tmp_path / "p.h5") as file:
        assert file["sub-P01/trials/requested"][:].tolist() == beh["requested"].tolist()
        assert file["sub-P01/raw/00001/f_a"].shape == (2, 2500)
