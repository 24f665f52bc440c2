"""Methods that choose levels: where they settle, what they are told, and the same numbers as other packages."""

import math

import numpy as np
import pytest
import questplus
import SweetSpot
from scipy.stats import beta, norm

from frictionloop.experiments import Adjustment, ConstantStimuli, Interleaved, Psi, Quest, Staircase, Walk
from frictionloop.experiments.psychometric import probability
from frictionloop.quantities import FrictionloopError


def answered(handler, threshold, spread, seed=0, guess=0.5, lapse=0.0):
    """Run a handler to its end with answers of a psychometric function."""
    rng = np.random.default_rng(seed)
    for level in handler:
        handler.add_response(rng.random() < float(probability(level, threshold, spread, guess, lapse)))
    return handler


@pytest.mark.parametrize(
    ("unit", "steps", "levels"),
    [
        ("N", (0.1, 0.05), (1.0, 1.0, 0.9, 0.9, 0.8, 0.85, 0.85, 0.8)),
        ("ratio", (2.0,), (1.0, 1.0, 0.5, 0.5, 0.25, 0.5, 0.5, 0.25)),
        ("dB", (20.0, 10.0), (1.0, 1.0, 0.1, 0.1, 0.01, 0.01 * 10**0.5, 0.01 * 10**0.5, 0.01)),
    ],
)
def test_a_staircase_takes_the_steps_of_its_rule(unit, steps, levels):
    staircase = Staircase(1.0, steps, unit, reversals=None, trials=7)
    found = [staircase.level]
    for right in (1, 1, 1, 1, 0, 1, 1):
        staircase.add_response(right)
        found.append(staircase.level)
    assert found == pytest.approx(list(levels))


@pytest.mark.parametrize(("down", "weight", "target"), [(1, 3.0, 0.75), (2, 1.0, 0.7071), (3, 1.0, 0.7937)])
def test_a_staircase_settles_at_its_target(down, weight, target):
    staircase = Staircase(0.6, (0.02,), "N", down=down, weight=weight, reversals=None, trials=6000)
    answered(staircase, 0.3, 0.15)
    assert staircase.target == pytest.approx(target, abs=1e-4)
    asked = np.array([each.asked for each in staircase.told[1000:]])
    assert probability(asked, 0.3, 0.15).mean() == pytest.approx(target, abs=0.02)


def test_a_weighted_staircase_goes_as_that_of_sweetspot():
    ours = Staircase(1.0, (0.1,), "N", down=1, weight=3.0, reversals=20)
    theirs = SweetSpot.WUD(start=1.0, hitEffect=-0.1, target=0.75, reversals=20)
    rng = np.random.default_rng(3)
    for level in ours:
        assert level == pytest.approx(theirs.PendingValue())
        right = int(rng.random() < 0.75)
        ours.add_response(right)
        theirs.Observe(right)
    assert theirs.Finished()


def test_psi_chooses_the_levels_of_questplus():
    levels, threshold, spread = np.linspace(0.0, 1.0, 21), np.linspace(0.1, 0.9, 17), np.geomspace(0.05, 0.4, 7)
    ours = Psi(levels, threshold, spread, (0.02,), trials=30, interest="both")
    theirs = questplus.QuestPlus(
        stim_domain={"intensity": levels},
        param_domain={"mean": threshold, "sd": spread, "lower_asymptote": [0.5], "lapse_rate": [0.02]},
        outcome_domain={"response": ["yes", "no"]},
        func="norm_cdf",
        stim_scale="linear",
    )
    rng = np.random.default_rng(0)
    for level in ours:
        assert level == pytest.approx(theirs.next_stim["intensity"])
        right = bool(rng.random() < float(probability(level, 0.45, 0.12)))
        ours.add_response(right)
        theirs.update(stim={"intensity": level}, outcome={"response": "yes" if right else "no"})
    assert ours.posterior.sum(axis=(1, 2)) @ threshold == pytest.approx(theirs.param_estimate["mean"])


def test_psi_marginal_has_the_posterior_and_the_entropies_of_sweetspot():
    levels, threshold, spread = np.linspace(-2.0, 2.0, 15), np.linspace(-1.5, 1.5, 13), np.geomspace(0.3, 2.0, 5)
    lapse = (0.0, 0.05)
    ours = Psi(levels, threshold, spread, lapse, trials=20, shape="logistic")
    pf = SweetSpot.PsychometricFunction(shape=SweetSpot.Logistic(0.5), gamma=0.5)
    pf.Set(alpha=threshold, beta=-np.log(math.sqrt(2.0 * math.pi) * spread), lambda_=np.array(lapse))
    theirs = SweetSpot.PsiMarginal(pf, levels)
    rng = np.random.default_rng(1)
    for level in ours:
        best = theirs.expectedEntropy.ravel()
        ranks = np.argsort(ours.expected_entropy())
        assert best[ranks[0]] == pytest.approx(best.min(), rel=1e-9)
        right = int(rng.random() < 0.7)
        delivered = level + 0.1  # both are told what was delivered
        ours.add_response(right, delivered)
        theirs.Observe(right, x=delivered)
    marginal = np.ravel(pf.Distribution(pf.LogPosterior(), params="alpha"))
    assert ours.posterior.sum(axis=(1, 2)) == pytest.approx(marginal / marginal.sum(), rel=1e-9)


@pytest.mark.parametrize(
    ("handler", "wrong"),
    [(Staircase(1.0), 2), (Psi([0.1, 0.2], [0.1, 0.2], [0.1]), 0.5), (Quest(0.0, 1.0, 0.1), -1),
     (Interleaved({"one": Staircase(1.0)}), 2), (Adjustment(0.0, 1.0, 0.1), 2)],
)  # fmt: skip
def test_a_response_that_a_method_does_not_know_is_refused(handler, wrong):
    with pytest.raises(FrictionloopError, match=f"result = {wrong}: must be (-1, )?0, 1"):
        handler.add_response(wrong)
    handler.add_response(True)
    with pytest.raises(FrictionloopError, match=r"start = 3: must be 0 to 1"):
        Staircase(3.0, least=0.0, most=1.0)


def test_a_posterior_uses_the_delivered_level_and_a_staircase_the_one_asked_for():
    grids = np.linspace(0.0, 1.0, 21), np.linspace(0.1, 0.9, 17), (0.1,)
    psi = Psi(*grids, lapse=(0.0,), trials=5)
    psi.add_response(1, 0.32)
    expected = probability(0.32, grids[1], 0.1)
    assert psi.posterior[:, 0, 0] == pytest.approx(expected / expected.sum())
    told = Psi(*grids, lapse=(0.0,), trials=5, low=0.0).posterior[:, 0, 0]
    law = beta(1, 6).pdf(norm.cdf(-grids[1] / 0.1))  # of F where nothing is there
    assert told / told[-1] == pytest.approx(law / law[-1], rel=0.01)
    first, second = Staircase(1.0), Staircase(1.0)
    for _ in range(2):
        first.add_response(1)
        second.add_response(1, 0.2)
    assert first.level == second.level
    assert second.told[0].delivered == 0.2


@pytest.mark.parametrize("spread", [0.05, 0.2])
def test_quest_has_the_posterior_of_a_logistic_that_is_as_steep_in_the_middle_as_the_normal(spread):
    quest, rng = Quest(0.0, 1.0, spread, 0.5, 0.02, trials=40), np.random.default_rng(0)
    threshold = np.linspace(0.0, 1.0, 201)
    posterior = np.ones(201)
    for _ in range(15):
        z = (quest.level - threshold) / (spread * math.sqrt(math.pi / 8))
        right = 0.5 + 0.48 / (1 + np.exp(-z))
        answer = rng.random() < 0.7
        posterior *= right if answer else 1 - right
        quest.add_response(answer)
    assert quest.estimate() == pytest.approx(threshold @ posterior / posterior.sum(), rel=1e-9)


def test_psi_ends_when_the_threshold_is_known_well_enough():
    psi = Psi(np.linspace(0, 1, 21), np.linspace(0, 1, 41), np.geomspace(0.05, 0.3, 5), trials=None, width=0.2)
    answered(psi, 0.4, 0.1)
    low, high = psi.interval()
    assert high - low <= 0.2
    assert 5 < len(psi.told) < 200


def test_constant_stimuli_ask_for_each_level_equally_often_in_each_round():
    handler = answered(ConstantStimuli((1.0, 2.0, 3.0), 4, seed=2), 2.0, 0.5)
    asked = np.array([each.asked for each in handler.told]).reshape(4, 3)
    assert (np.sort(asked, axis=1) == [1.0, 2.0, 3.0]).all()
    assert (asked != asked[0]).any()


def test_interleaved_tracks_are_all_run_and_keep_apart():
    def made():
        return Interleaved({"high": Staircase(1.0, reversals=6), "low": Staircase(0.1, reversals=6)}, seed=1)

    first, second = answered(made(), 0.4, 0.1), answered(made(), 0.4, 0.1)
    assert [each.track for each in first.told] == [each.track for each in second.told]
    assert {each.track for each in first.told[:8]} == {"high", "low"}
    assert all(len(track.turned) == 6 for track in first.tracks.values())


def test_an_adjustment_ends_where_it_feels_alike():
    handler = Adjustment(-1.0, 1.0, 0.1, settings=4, seed=0)
    for level in handler:
        handler.add_response(0 if abs(level - 0.2) <= 0.06 else math.copysign(1, 0.2 - level))
    assert len(handler.set) == 4
    assert handler.set == pytest.approx([0.2] * 4, abs=0.061)


def test_a_walk_stays_between_its_ends():
    levels = [each.asked for each in answered(Walk(0.3, 0.6, 0.2, 500, seed=0), 0.4, 0.1).told]
    assert min(levels) >= 0.3
    assert max(levels) <= 0.6
    assert np.ptp(levels) > 0.25
