"""Synthetic sliding trials: equation (1) per trial, bounded disturbance, one trial independent of the others."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.physics.fingers import UNIFORM
from frictionloop.report.systems import sliding_trials

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
