"""What a study needs: shares by closed form, and short studies as the beginning of long ones."""

import numpy as np
import pandas
import pytest
from scipy.stats import nct, norm, t

from frictionloop.experiments import read_protocol
from frictionloop.experiments.planning import POOLS, first_trials, power, shares
from frictionloop.experiments.study_run import simulate_trials
from frictionloop.quantities import FrictionloopError

SHORT = read_protocol("study-friction").evolve(
    {"timeline.stroke.length_mm": 10.0, "method.thresholds": 12, "method.spreads": 4, "method.levels": 8}
)


def of_the_t_test(effect, n):
    """Return the power of a two-sided t-test of n normal differences with this mean over their standard deviation."""
    limit = t.ppf(0.975, n - 1)
    return nct.sf(limit, n - 1, effect * np.sqrt(n)) + nct.cdf(-limit, n - 1, effect * np.sqrt(n))


@pytest.mark.parametrize(("effect", "n"), [(0.5, 20), (0.3, 40), (1.0, 8)])
def test_of_a_large_pool_the_share_is_that_of_the_noncentral_t(effect, n):
    pool = effect + norm.ppf((np.arange(4000) + 0.5) / 4000)
    share, low, high = shares(pool, n, 4000, 0)
    assert share == pytest.approx(of_the_t_test(effect, n), abs=0.025)
    assert low < share < high


def test_the_interval_holds_the_true_power_of_small_pools():
    rng, true = np.random.default_rng(0), of_the_t_test(0.5, 24)
    found = [shares(rng.normal(0.5, 1.0, 48), 24, 100, k)[1:] for k in range(40)]
    assert sum(low <= true <= high for low, high in found) >= 31  # 0.1 % of 40 that hold in 95 % and 5 % of bias
    assert POOLS >= 100


def test_participants_who_are_all_alike_show_nothing():
    assert shares(np.full(10, 0.3), 5, 50, 0) == (0.0, 0.0, 0.0)


def test_a_short_study_is_the_beginning_of_a_long_one():
    short, long = (simulate_trials(SHORT.evolve({"stop.trials": n}), participants=2, progress=False) for n in (5, 7))
    first = {code: some["condition"].iloc[0] for code, some in short.groupby("participant")}
    cut = first_trials(long, 5)
    for code, condition in first.items():
        one, two = (each[(each["participant"] == code) & (each["condition"] == condition)] for each in (short, cut))
        pandas.testing.assert_frame_equal(one.reset_index(drop=True), two.reset_index(drop=True))
    for wrong in (4, 8):
        with pytest.raises(FrictionloopError, match=f"trials = {wrong}: must be 5 to 7"):
            first_trials(long, wrong)


@pytest.mark.slow
def test_power_grows_with_the_effect_and_has_a_row_for_each_number():
    plan = SHORT.evolve({"stop.trials": 15})
    small, large = (power(plan, effect, [4, 16], trials=[8, 15], pool=6, studies=100) for effect in (0.1, 2.0))
    assert len(small.shares) == 2 * 2 * 2
    of = [
        found.shares.set_index(["condition", "trials", "participants"])["power"]["closed", 15, 16]
        for found in (small, large)
    ]
    assert of[0] < of[1]
    assert (small.shares["low"] <= small.shares["high"]).all()
    table = small.table()
    assert list(zip(table["trials"], table.index, strict=True)) == [("8", 4), ("8", 16), ("15", 4), ("15", 16)]
    assert list(table.columns) == ["trials", "closed", "closed 95 %", "open", "open 95 %"]
