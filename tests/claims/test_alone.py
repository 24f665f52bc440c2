"""Figures and claims alone: their numbers, and Fig. 5a on a bench that is not the paper's."""

from __future__ import annotations

import pytest

import frictionloop as fl
from frictionloop.quantities import FrictionloopError
from frictionloop.report import alone, changed
from frictionloop.report.device import OPEN, RETUNED_GAINS
from frictionloop.report.figure_numbers import NUMBERS
from frictionloop.report.figures import DRAWINGS
from frictionloop.report.figures.closed_loop import HERE

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
    assert sorted(path.name for path in (tmp_path / "some").rglob("*.*")) == ["fig-1b.svg"]


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
    for name in changed.SHOWN:
        (paper,), (here,) = (alone.alone(tmp_path, [name], each).figures for each in ({}, same))
        assert {row: here.numbers[row] for row in paper.numbers} == paper.numbers
        assert set(here.numbers) - set(paper.numbers) <= {HERE}
        assert here.unchanged == here.numbers and paper.unchanged == {}


def test_a_changed_bench_tells_both_pairs_of_gains_apart_and_says_what_was_changed(tmp_path):
    changes = {"sensor.resonance_hz": 200.0, "finger.contact": "slider"}
    found = alone.alone(tmp_path, ["fig-5a"], changes)
    (figure,) = found.figures
    assert not found.claims
    assert figure.file.name == "fig-5a-with-sensor.resonance_hz-200-finger.contact-slider.svg"
    assert figure.file.exists() and figure.changed == changes
    given, here = figure.numbers[RETUNED_GAINS], figure.numbers[HERE]
    assert (given["kp"], given["ki"]) == tuple(fl.RETUNED.values())
    assert {"controller.kp": here["kp"], "controller.ki": here["ki"]} == fl.retune(fl.bench().evolve(changes)).overrides
    before = figure.unchanged[HERE]
    assert {"controller.kp": before["kp"], "controller.ki": before["ki"]} == fl.retune(fl.bench()).overrides
    drawn, *_ = changed.drawn("fig-5a", changes, alone.Results()._bar)
    assert drawn.get_suptitle() == "Not the paper's bench: sensor.resonance_hz = 200, finger.contact = slider"


@pytest.mark.parametrize(
    ("names", "changes", "said"),
    [
        (["fig-5b"], {"plate.q": 100.0}, r"only = 'fig-5b': .* fig-5a and fig-5a-printed alone"),
        (["fig-5a", "closed-loop-r2"], {"plate.q": 100.0}, "only = 'closed-loop-r2'"),
        ([], {"plate.q": 100.0}, r"plate.q: .* name fig-5a and fig-5a-printed with only"),
        (["fig-5a"], {"controller.kp": 1.0}, "controller.kp: is set by the protocol"),
        (["fig-5a"], {"setpoint.kind": "constant"}, "setpoint.kind: is set by the protocol"),
        (["fig-5a"], {"friction.kind": "gaussian"}, "friction.kind: is set by the protocol"),
        (["fig-5a"], {"plate.qu": 1.0}, "plate.qu"),
    ],
)
def test_what_has_no_meaning_on_a_changed_bench_is_refused(tmp_path, names, changes, said):
    with pytest.raises(FrictionloopError, match=said):
        alone.alone(tmp_path, names, changes)
    assert not list(tmp_path.iterdir())
