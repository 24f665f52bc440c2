"""The population of fingers: its distributions, that a finger stays itself, and what it can be made to feel."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import kstest, lognorm, loguniform, spearmanr, uniform
from scipy.stats import norm as normal

import frictionloop as fl
from frictionloop.identification import people
from frictionloop.parameters.motion import Strokes
from frictionloop.parameters.plant import FingerFriction, Skin
from frictionloop.parameters.population import Population
from frictionloop.physics.fingers import DRAWN_AT, SLOTS, UNIFORM, Fingers, fingers
from frictionloop.physics.occlusion import occlusion_after, occlusion_at
from frictionloop.physics.reach import capable, finger_reach
from frictionloop.report.system_comparison import sliding_trials

MANY = fingers(4000, 1)
DISTRIBUTIONS = {
    "friction.nominal_n": uniform(0.5, 0.9),
    "friction.load_exponent": uniform(0.67, 0.33),
    "friction.speed_slope": uniform(-0.15, 0.3),
    "motion.load_drift": uniform(0.1, 0.1),
    "motion.tremor_hz": uniform(8.0, 4.0),
    "friction.occlusion_ratio": loguniform(1.0, 5.0),
    "friction.roughness_rms": loguniform(0.02, 0.10),
    "finger.damping_n_s_m": loguniform(0.5, 2.0),
    "motion.tremor_um": loguniform(30.0, 120.0),
    "motion.tremor_n": loguniform(0.015, 0.060),
    "friction.susceptibility_per_um2": lognorm(0.35, scale=0.38),
    "finger.stiffness_n_m": lognorm(0.35, scale=1000.0),
    "motion.load_n": lognorm(0.25, scale=0.55),
    "friction.occlusion_s": uniform(7.0, 13.0),
    "finger.slip_length_um": lognorm(math.log(1.5), scale=11.5),
}
"""What docs/finger.md says of a finger, that of tau as it would be dry."""
MOIST_LOSS = 0.3
"""Largest share of tau that moisture takes, there too."""
PLAIN = {"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}
LEAST_P = 1e-3 / len(DISTRIBUTIONS)
"""One in a thousand for all tests of distributions together."""


def column(path):
    return np.array([finger[path] for finger in MANY])


@pytest.mark.parametrize("path", DISTRIBUTIONS)
def test_each_parameter_has_its_distribution(path):
    values = column(path)
    if path == "friction.susceptibility_per_um2":  # as it would be dry
        values = values * (1 - column("friction.moist_loss")) / (1 - MOIST_LOSS)
    assert kstest(values, DISTRIBUTIONS[path].cdf).pvalue > LEAST_P


def test_medians_and_spreads_are_as_researched():
    """A mean of n logarithms is off by sd/sqrt(n), their standard deviation by sd/sqrt(2 n)."""
    for path, law in DISTRIBUTIONS.items():
        if law.dist.name == "lognorm" and "susceptibility" not in path:
            (spread,), logarithms = law.args, np.log(column(path) / law.kwds["scale"])
            assert abs(logarithms.mean()) < 4 * spread / math.sqrt(len(MANY)), path
            assert logarithms.std() == pytest.approx(spread, rel=4 / math.sqrt(2 * len(MANY))), path


def test_parameters_are_independent():
    paths = [*(path for path in DISTRIBUTIONS if "susceptibility" not in path), "friction.moist_loss"]
    ranks = np.asarray(spearmanr(np.array([column(path) for path in paths]), axis=1).statistic)
    others = ranks[np.triu_indices_from(ranks, 1)]
    assert np.max(np.abs(others)) < 5 / math.sqrt(len(MANY))


def test_moisture_takes_up_to_thirty_percent():
    loss = column("friction.moist_loss")
    assert loss.min() >= 0 and loss.max() <= MOIST_LOSS
    # Moist or not at landing, occlusion brings all to the same share of what they would be dry.
    left_at_landing = (1 - MOIST_LOSS) / (1 - loss)
    assert kstest((1 - left_at_landing) / MOIST_LOSS, uniform.cdf).pvalue > 1e-3


@given(st.integers(1, 60), st.integers(1, 60), st.integers(0, 2**64 - 1))
@settings(max_examples=20, deadline=None)
def test_a_finger_is_the_same_in_any_population(n, m, seed):
    small, large = sorted((n, m))
    assert fingers(large, seed)[:small] == fingers(small, seed)


def test_a_population_names_its_dimension_and_seeds_differ():
    assert isinstance(MANY, Fingers)
    assert MANY.dim == "finger"
    assert fingers(26, 0) == fingers(26, 0)
    assert fingers(26, 0) != fingers(26, 1)
    assert len({finger["friction.nominal_n"] for finger in MANY}) == len(MANY)
    drawn = len(DISTRIBUTIONS) + 1
    assert drawn <= SLOTS
    assert len(MANY[0]) == drawn + 1 + len(DRAWN_AT)
    assert [finger["motion.person"] for finger in MANY] == list(range(len(MANY)))


def test_every_finger_is_a_valid_one():
    blocks = {"friction": FingerFriction, "finger": Skin, "motion": Strokes}
    for finger in MANY[:200]:
        for name, block in blocks.items():
            own = {path.split(".")[1]: value for path, value in finger.items() if path.startswith(name)}
            assert all(getattr(block(**own), leaf) == value for leaf, value in own.items())


@given(st.floats(0.3, 2), st.floats(0.1, 1), st.floats(0.1, 2), st.floats(0.5, 1))
def test_reach_at_landing_is_equation_1(f0, tau, load, exponent):
    finger = {"friction.nominal_n": f0, "friction.susceptibility_per_um2": tau, "motion.load_n": load}
    low, high = finger_reach(finger | {"friction.load_exponent": exponent})
    exact = f0 * (load / 0.5) ** exponent
    assert high == pytest.approx(exact, rel=1e-13)
    assert low == pytest.approx(exact * math.exp(-tau * 6.25), rel=1e-13)


@given(st.floats(0.1, 5), st.floats(0, 0.5), st.floats(0, 100), st.floats(0, 4))
def test_reach_over_a_contact_is_the_worst_of_its_moments(ratio, loss, contact_s, a_max):
    finger = {"friction.occlusion_ratio": ratio, "friction.moist_loss": loss, "friction.nominal_n": 1.0}
    low, high = finger_reach(finger, a_max, contact_s)
    w = -np.expm1(-np.linspace(0, contact_s, 2001) / 20.0)
    factor = 1 + (ratio - 1) * w
    lowest = factor * np.exp(-0.38 * a_max**2 * (1 - loss * w))
    assert high == pytest.approx(factor.min(), rel=1e-12)
    assert low >= lowest.max() * (1 - 1e-12)
    # On a grid the peak is missed by at most half its curvature times half a step squared: below 1e-5 here.
    assert low == pytest.approx(lowest.max(), rel=1e-5)


def test_who_can_feel_what():
    population = Fingers(
        [
            PLAIN | {"friction.nominal_n": 1.0},  # to 1.0 and down to 0.093
            PLAIN | {"friction.nominal_n": 0.8},  # not up to 0.9
            PLAIN | {"friction.nominal_n": 1.0, "friction.susceptibility_per_um2": 0.19},  # down to 0.305
        ]
    )
    found = capable(population)
    assert found["capable"].values.tolist() == [True, False, False]
    assert found["reaches_low"].values.tolist() == [True, True, False]
    assert found["reaches_high"].values.tolist() == [True, False, True]
    np.testing.assert_allclose(found["lowest_n"], [math.exp(-2.375), 0.8 * math.exp(-2.375), math.exp(-1.1875)])
    assert found["lowest_n"].attrs["units"] == "N"
    assert found.sizes == {"finger": 3}


def test_many_cannot_and_longer_contact_makes_it_no_easier():
    short, long = capable(MANY[:500]), capable(MANY[:500], contact_s=10.0)
    assert 0.2 < float(short["capable"].mean()) < 0.8
    assert not np.any(long["capable"] & ~short["capable"])
    weaker = capable(MANY[:500], max_amplitude_um=1.25)
    assert not np.any(weaker["capable"] & ~short["capable"])


def test_contact_upon_contact_ends_where_a_finger_dries_as_much_as_it_grows_moist():
    friction, w = FingerFriction(), 0.0
    for contact in range(1, 40):
        moist = 1.0 - (1.0 - w) * math.exp(-2.0 / friction.occlusion_s)
        assert occlusion_after(friction, 2.0, 0.5, contact) == pytest.approx(moist, rel=1e-12)
        w = moist * math.exp(-0.5 / friction.drying_s)
    end = occlusion_after(friction, 2.0, 0.5, math.inf)
    assert 1.0 - (1.0 - end * math.exp(-0.5 / friction.drying_s)) * math.exp(-2.0 / friction.occlusion_s) == (
        pytest.approx(end, rel=1e-12)
    )
    # A contact that ends as moist as many do asks for the same.
    alike = [each | {"friction.occlusion_s": friction.occlusion_s} for each in MANY[:200]]
    once = capable(alike, contact_s=-friction.occlusion_s * math.log1p(-end))
    many = capable([each | {"motion.lifted_s": 0.5} for each in alike], contact_s=2.0, contacts=math.inf)
    np.testing.assert_allclose(many["lowest_n"], once["lowest_n"], rtol=1e-12)
    assert 0 < many["capable"].sum() < capable(MANY[:200], contact_s=2.0)["capable"].sum()


def test_loads_are_even_between_two_and_leave_the_rest_of_a_finger():
    plain, asked = fingers(400, 3), fingers(400, 3, loads_n=(0.4, 1.2))
    loads = np.array([each["motion.load_n"] for each in asked])
    assert kstest((loads - 0.4) / 0.8, "uniform").pvalue > 0.01
    assert np.argsort(loads).tolist() == np.argsort([each["motion.load_n"] for each in plain]).tolist()
    rest = [{path: value for path, value in each.items() if path != "motion.load_n"} for each in (*plain, *asked)]
    assert rest[:400] == rest[400:]
    assert asked[:7] == fingers(7, 3, loads_n=(0.4, 1.2))


def test_a_load_that_moves_takes_from_both_ends_what_it_is_off_its_mean_for_a_twentieth_of_the_time():
    """Friction goes with the load to the power n; drift of 0.1 and tremor of 30 mN at 0.5 N are 58 mN together."""
    finger = {"friction.load_exponent": 0.8, "motion.load_n": 0.5, "motion.load_drift": 0.1, "motion.tremor_n": 0.03}
    still, moving = (capable([finger], load_moves=each).isel(finger=0) for each in (False, True))
    off = float(normal.ppf(0.95)) * math.hypot(0.05, 0.03) / 0.5
    assert float(moving["highest_n"] / still["highest_n"]) == pytest.approx((1 - off) ** 0.8, rel=1e-3)
    assert float(moving["lowest_n"] / still["lowest_n"]) == pytest.approx((1 + off) ** 0.8, rel=1e-3)
    quiet = {**finger, "motion.load_drift": 0.0, "motion.tremor_n": 0.0}
    assert capable([quiet], load_moves=True)["highest_n"].equals(still["highest_n"].expand_dims("finger"))


def test_one_force_may_be_asked_for():
    one, both = capable(MANY, 0.5, 0.5), capable(MANY, 0.45, 0.55)
    np.testing.assert_array_equal(one.capable, (one.lowest_n <= 0.5) & (one.highest_n >= 0.5))
    assert int(both.capable.sum()) < int(one.capable.sum()) < len(MANY)


@pytest.mark.parametrize(("contact_s", "lifted_s"), [(0.0, 1.0), (2.0, 0.5), (30.0, 2.0)])
def test_a_run_of_contacts_leaves_the_moisture_of_the_last_one(contact_s, lifted_s):
    """Against steps of the two rates: dw/dt = (1 - w)/occlusion_s on the plate, -w/drying_s in the air."""
    friction, step_s, w, touched = FingerFriction(), 1e-3, 0.0, 0.0
    for k in range(8_000):
        cycle = (k * step_s) % (contact_s + lifted_s)
        if not contact_s or cycle < contact_s - 0.5 * step_s:
            w = touched = w + step_s * (1.0 - w) / friction.occlusion_s
        else:
            w -= step_s * w / friction.drying_s
        if k in (300, 1999, 2200, 7_999):
            there = occlusion_at(friction, contact_s, lifted_s, (k + 1) * step_s)
            assert there == pytest.approx(touched, rel=2e-3)


LOW_N, HIGH_N = UNIFORM["friction.nominal_n"]


def test_a_trial_is_equation_1():
    trials = sliding_trials(4)
    g = trials["f0"] * np.exp(-trials["tau"] * trials["a"] ** 2)
    assert trials["f"].values == pytest.approx((g + trials["d"]).transpose("trial", "sample").values, abs=1e-12)


@given(st.integers(1, 40), st.integers(0, 2**32))
@settings(max_examples=25)
def test_friction_is_never_negative(n, seed):
    trials = sliding_trials(n, seed)
    assert float(trials["f"].min()) >= 0
    assert float(trials["f0"].min()) >= LOW_N and float(trials["f0"].max()) <= HIGH_N
    assert float(trials["tau"].min()) > 0


def test_the_carrier_is_modulated_once_a_second_from_0_to_2_5_um():
    trials = sliding_trials(1)
    assert float(trials["a"].min()) == 0 and float(trials["a"].max()) == pytest.approx(2.5)
    assert trials["a"].values[:200] == pytest.approx(trials["a"].values[200:], abs=1e-12)


def test_the_same_seed_gives_the_same_bits_and_more_trials_change_none():
    few, many = sliding_trials(3, seed=5), sliding_trials(26, seed=5)
    assert np.array_equal(few["f"], many["f"][:3])
    assert not np.array_equal(few["f"], sliding_trials(3, seed=6)["f"])


def test_a_large_population_has_the_spread_it_was_given():
    trials = sliding_trials(4000)
    assert float(trials["f0"].mean()) == pytest.approx((LOW_N + HIGH_N) / 2, abs=0.02)
    assert float(np.log(trials["tau"]).std()) == pytest.approx(0.35, abs=0.02)
    assert float(np.log(trials["tau"]).mean()) == pytest.approx(np.log(0.38), abs=0.02)


def test_each_trial_falls_clearly_and_trials_disagree():
    trials = sliding_trials(26)
    within = [np.corrcoef(trials["a"], force)[0, 1] for force in trials["f"].values]
    pooled = np.corrcoef(np.tile(trials["a"], 26), trials["f"].values.ravel())[0, 1]
    assert np.median(within) < -0.9 < pooled


F0, TAU = "friction.nominal_n", "friction.susceptibility_per_um2"
S = np.array([[0.09, -0.04], [-0.04, 0.12]])


def crowd(fingers=12, takes=3, seed=0, within=(0.1, 0.2)):
    rng = np.random.default_rng(seed)
    truth = rng.multivariate_normal(np.log([0.9, 0.35]), S, fingers)
    return {
        f"finger {k}": [
            {F0: (mean[0] + within[0] * rng.normal(), 0.05), TAU: (mean[1] + within[1] * rng.normal(), 0.05)}
            for _ in range(takes)
        ]
        for k, mean in enumerate(truth)
    }, truth


def test_a_balanced_crowd_has_the_closed_form():
    """Equal numbers: the restricted likelihood gives the difference of mean squares where that is a covariance."""
    measured, _ = crowd()
    found = people(measured)
    x = np.array([[[entry[path][0] for path in (F0, TAU)] for entry in entries] for entries in measured.values()])
    means = x.mean(axis=1)
    inside = sum((each - each.mean(axis=0)).T @ (each - each.mean(axis=0)) for each in x) / (12 * 2)
    between = np.cov(means.T) - inside / 3
    assert [each.spread for each in found.population.value] == pytest.approx(np.sqrt(np.diag(between)), rel=2e-3)
    r = between[0, 1] / np.sqrt(between[0, 0] * between[1, 1])
    assert found.population.correlation[0][1] == pytest.approx(r, abs=2e-3)
    assert np.log([each.median for each in found.population.value]) == pytest.approx(means.mean(axis=0), abs=1e-4)
    pulled = means.mean(axis=0) + (means - means.mean(axis=0)) @ (between @ np.linalg.inv(between + inside / 3)).T
    np.testing.assert_allclose(found.pooled, pulled, atol=2e-3)
    np.testing.assert_allclose(found.within, np.sqrt(np.diag(inside)))


def test_pooled_fingers_are_nearer_to_the_truth():
    better = 0
    for seed in range(20):
        measured, truth = crowd(8, 1, seed, within=(0.3, 0.3))
        noisy = {k: [{F0: (e[F0][0], 0.3), TAU: (e[TAU][0], 0.3)} for e in v] for k, v in measured.items()}
        found = people(noisy)
        better += np.sum((found.pooled - truth) ** 2) < np.sum((found.raw - truth) ** 2)
    assert better >= 16


def test_spreads_and_medians_hold_the_truth():
    hits = np.zeros(2)
    for seed in range(60):
        found = people(crowd(12, 2, seed)[0])
        ends = found.medians[0].interval(0.9), found.spreads[0].interval(0.9)
        hits += [ends[0].low < 0.9 < ends[0].high, ends[1].low < 0.3 < ends[1].high]
    # 54 of 60 are expected; fewer than 46 come by chance once in a thousand.
    assert hits[0] >= 46 and hits[1] >= 46


def test_fingers_of_a_measured_population():
    population = people(crowd(40, 3)[0]).population
    drawn = fl.fingers(3000, 1, population=population)
    logs = np.log([[each[F0], each[TAU]] for each in drawn])
    np.testing.assert_allclose(np.exp(np.median(logs, axis=0)), [v.median for v in population.value], rtol=0.03)
    np.testing.assert_allclose(logs.std(axis=0), [v.spread for v in population.value], rtol=0.05)
    assert np.corrcoef(logs.T)[0, 1] == pytest.approx(population.correlation[0][1], abs=0.05)
    assumed = fl.fingers(5, 1)
    for one, other in zip(assumed, drawn, strict=False):
        kept = one.keys() - {F0, TAU, *DRAWN_AT}
        assert {k: one[k] for k in kept} == {k: other[k] for k in kept}
        assert not DRAWN_AT.keys() & other.keys() and DRAWN_AT.items() <= one.items()
    fl.bench().evolve(drawn[0])


def test_a_population_as_a_file(tmp_path):
    path = tmp_path / "people.toml"
    path.write_text('fingers = 4\n[[value]]\npath = "friction.nominal_n"\nmedian = 1.2\nspread = 0.0\n')
    assert {each[F0] for each in fl.fingers(3, 0, population=path)} == {1.2}
    assert fl.fingers(3, 0, population={"value": [{"path": F0, "median": 1.2, "spread": 0.0}]})[2][F0] == 1.2


def test_few_fingers():
    measured, _ = crowd(3)
    (few,) = people(measured).findings
    assert (few.value, few.limit, few.more["what"]) == (3, 5, "correlations")
    assert people(measured).population.matrix().tolist() == [[1, 0], [0, 1]]
    with pytest.raises(fl.FrictionloopError, match="must be at least 3"):
        people(dict(list(measured.items())[:2]))
    with pytest.raises(ValueError, match="must all differ"):
        Population.model_validate({"value": [{"path": F0, "median": 1, "spread": 0}] * 2})
