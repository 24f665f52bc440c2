"""The report of sessions: what it holds, what is told of dispersion, and how a value settles."""

import shutil

import numpy as np
import pandas
import pytest
from scipy.stats import chi2, norm, ttest_1samp, weibull_min

import frictionloop as fl
from frictionloop.experiments import Protocol, read_protocol, run, session_export
from frictionloop.experiments.psychometric import fit, probability
from frictionloop.experiments.study_summary import convergence, fits, funnel, groups, pooled
from frictionloop.quantities import FrictionloopError

PLAN = Protocol(
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    stop={"trials": 6},
)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    run(PLAN, folder / "P01", "P01")
    return folder


def rows(n_people, threshold, spread, plan, seed=0, wander=0.0):
    """Return trials of participants with known functions, over levels of both signs."""
    rng, found = np.random.default_rng(seed), []
    for person in range(n_people):
        own = threshold + wander * rng.normal()
        level = rng.permutation(np.repeat(plan.method.levels, 12))
        right = rng.random(level.size) < probability(level, own, spread, 0.03, 0.03)
        found.append(pandas.DataFrame({
            "participant": f"P{person:02d}", "condition": "closed", "phase": "main", "counted": 1, "valid": 1,
            "again": 0, "reason": "", "requested": level, "delivered": level, "result": right.astype(float),
        }))  # fmt: skip
    return pandas.concat(found, ignore_index=True)


@pytest.mark.slow
def test_a_report_is_one_call_and_one_page_with_its_tables(data, tmp_path):
    found = fl.experiments.report(data)
    fl.experiments.write_page(found, tmp_path / "study.html")
    assert found.about == "1 session, simulated"
    assert (found.groups["participants"] + found.groups["without"]).tolist() == [1, 1]
    assert found.reaches["when"].tolist() == ["before", "after"]
    page = (tmp_path / "study.html").read_text()
    for heading in ("Convergence", "All participants together", "Fingers", "What became of the trials"):
        assert f"<h2>{heading}</h2>" in page
    assert pandas.read_csv(tmp_path / "study-reaches.tsv", sep="\t").shape == (2, 6)
    assert len(pandas.read_csv(tmp_path / "study-pooled.tsv", sep="\t")) == 2
    fl.plot(found, tmp_path / "study.svg")
    assert "</svg>" in (tmp_path / "study.svg").read_text()


def test_sessions_of_two_protocols_are_not_reported_together(data):
    run(PLAN.evolve({"name": "other"}), data / "P02", "P02", trials=1)
    with pytest.raises(FrictionloopError, match="has another protocol"):
        fl.experiments.report(data)


def test_two_sessions_of_one_participant_are_not_taken_for_one(data, tmp_path):
    both = tmp_path / "both"
    for name in ("P01", "again"):
        shutil.copytree(data / "P01", both / name)
    for write in (fl.experiments.report, lambda path: session_export.bids(path, tmp_path / "bids")):
        with pytest.raises(FrictionloopError, match=r"again: is of participant P01, as is .*P01"):
            write(both)
    assert not (tmp_path / "bids").exists()


def test_what_was_answered_in_catch_trials_is_told():
    plan = read_protocol("jnd-friction-constant")
    trials = rows(1, 0.01, 0.03, plan).head(6).assign(phase="catch", correct=[1.0, 1.0, 0.0, np.nan, 1.0, 1.0])
    trials.loc[5, "valid"] = 0
    told = funnel(trials).set_index("what")["trials"]
    assert told[[f"catch, {what}" for what in ("right", "wrong", "neither")]].tolist() == [3, 1, 2]


def test_all_participants_together_have_four_parameters_and_their_differences_are_told():
    plan = read_protocol("jnd-friction-constant")
    alike, apart = (rows(8, 0.01, 0.03, plan, wander=wander) for wander in (0.0, 0.06))
    one = pooled(plan, alike).iloc[0]
    assert one["threshold"] == pytest.approx(0.01, abs=0.006)
    assert one["spread"] == pytest.approx(0.03, rel=0.2)
    assert (one["guess"], one["lapse"]) == pytest.approx((0.03, 0.03), abs=0.03)
    assert one["dispersion"] < one["dispersion_limit"]
    two = pooled(plan, apart).iloc[0]
    assert two["spread"] > 1.2 * one["spread"]


@pytest.mark.parametrize("spread", [0.5, 2.0])
def test_a_weibull_function_is_that_of_scipy(spread):
    level = np.array([-0.1, 0.0, 0.1, 0.2, 0.3, 0.8])
    law = weibull_min(1 / spread, scale=0.2 / np.log(2) ** spread)
    assert probability(level, 0.2, spread, 0.1, 0.05, "weibull") == pytest.approx(0.1 + 0.85 * law.cdf(level))


def test_the_dispersion_is_pearsons_chi_square_a_degree_of_freedom():
    level, right = np.linspace(0.0, 0.7, 8), np.array([21, 17, 24, 30, 34, 40, 40, 40])
    found = fit(np.repeat(level, 40), np.concatenate([np.arange(40) < n for n in right]).astype(float))
    share = 0.5 + (0.5 - found.lapse) * norm.cdf((level - found.threshold) / found.spread)
    observed, expected = np.array([right, 40 - right]), 40 * np.array([share, 1 - share])
    assert found.dispersion == pytest.approx(np.sum((observed - expected) ** 2 / expected) / 6)
    assert found.dispersion_limit == pytest.approx(chi2.isf(0.025, 6) / 6)


def test_the_interval_of_a_group_is_that_of_the_t_test():
    values = [0.1, 0.13, 0.08, 0.2]
    found = groups(pandas.DataFrame({"condition": "closed", "level": "requested", "value": values})).iloc[0]
    expected = ttest_1samp(values, 0.0).confidence_interval(0.95)
    assert (found["low"], found["high"]) == pytest.approx((expected.low, expected.high))


def test_a_value_settles_at_that_of_the_fit():
    plan = read_protocol("jnd-friction-constant")
    trials = rows(1, 0.01, 0.05, plan, seed=3)
    found = convergence(plan, trials["requested"], trials["result"])
    half = (found["high"] - found["low"]).to_numpy()
    assert len(found) == len(trials)
    assert half[-1] < 0.5 * half[9]
    fitted = fits(plan, trials).iloc[0]
    assert found["value"].iloc[-1] == pytest.approx(fitted["value"], rel=0.2)
    assert convergence(plan, [0.1, 0.1], [1, 0]).empty
