"""A population of fingers: empirical Bayes against its closed form, and fl.fingers drawn from it."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.identification import people
from frictionloop.parameters.population import Population
from frictionloop.physics.fingers import DRAWN_AT

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


@pytest.mark.parametrize(
    ("tree", "says"),
    [
        ({"value": [{"path": "sensor.q", "median": 1.0, "spread": 0.1}]}, "path = 'sensor.q'"),
        ({"value": [{"path": "friction.speed_slope", "median": 1.0, "spread": 0.1}]}, "path = 'friction.speed_slope'"),
        ({"value": [{"path": F0, "median": -1.0, "spread": 0.1}]}, "median"),
        ({"value": [{"path": F0, "median": 1.0, "spread": 0.1}], "correlation": [[1.0, 0.2]]}, "= (1, 2): must be (1,"),
        (
            {
                "value": [{"path": F0, "median": 1.0, "spread": 0.1}, {"path": TAU, "median": 1.0, "spread": 0.1}],
                "correlation": [[1.0, 1.4], [1.4, 1.0]],
            },
            "correlation: ",
        ),
        ("nowhere.toml", "cannot be read"),
    ],
)
def test_what_a_population_refuses(tree, says):
    with pytest.raises(fl.FrictionloopError) as failure:
        fl.fingers(2, 0, population=tree)
    assert says in str(failure.value) and "\n" not in str(failure.value)


def test_few_fingers():
    measured, _ = crowd(3)
    (few,) = people(measured).findings
    assert (few.value, few.limit, few.more["what"]) == (3, 5, "correlations")
    assert people(measured).population.matrix().tolist() == [[1, 0], [0, 1]]
    with pytest.raises(fl.FrictionloopError, match="must be at least 3"):
        people(dict(list(measured.items())[:2]))
    with pytest.raises(ValueError, match="must all differ"):
        Population.model_validate({"value": [{"path": F0, "median": 1, "spread": 0}] * 2})
