"""Figures and claims alone: their numbers, and the bench and finger of Fig. 5a in a file."""

from __future__ import annotations

import json

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating_point import reach_at
from frictionloop.physics.occlusion import occlusion_after
from frictionloop.quantities import FrictionloopError
from frictionloop.report import closed_loop, paper_protocol, reproduction
from frictionloop.report.gain_stability import asked_for, places_of, stability
from frictionloop.report.other_fingers import the_finger
from frictionloop.report.paper_figures import FIGURES
from frictionloop.report.paper_protocol import CONTROLLERS, OPEN, PRINTED, RETUNED_GAINS


@pytest.fixture
def known(results, monkeypatch):
    """Take what other tests have computed."""
    monkeypatch.setattr(reproduction, "Results", lambda bar: results)


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
    assert numbers["fig-5a"][RETUNED_GAINS]["r2_regression"] == r2["re-tuned gains, regression, pooled"]
    assert numbers["fig-5a-printed"][PRINTED]["r2_regression"] == r2["printed gains, regression, pooled"]
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
    assert {name for name, each in FIGURES.items() if not each.numbers(results)} == schemes | stored
    assert all(row for each in FIGURES.values() for row in each.numbers(results).values())


@pytest.mark.slow
@pytest.mark.usefixtures("known")
def test_bench_and_finger_of_fig_5a_are_a_file_that_other_verbs_take(tmp_path):
    (figure,) = fl.reproduce(tmp_path, ["fig-5a"]).figures
    there = fl.read_toml(figure.bench)
    assert there.friction.nominal_n == the_finger()["friction.nominal_n"]
    assert (there.setpoint.offset_n, there.setpoint.amplitude_n) == (0.6, 0.3)
    assert (there.controller.kp, there.controller.ki) == tuple(fl.RETUNED.values())
    moist = occlusion_after(there.friction, there.motion.contact_s, there.motion.lifted_s, len(paper_protocol.LOADS))
    assert moist == pytest.approx(paper_protocol.occlusion_at_end(there))
    by_hand, here = fl.design.check(asked_for(fl.RETUNED)), fl.design.check(there)
    assert places_of(here) == places_of(by_hand) and places_of(here)["within"] < places_of(here).total()
    assert fl.design.check(there.evolve({"controller.kp": 0.0, **by_hand.would_hold})).holds_everywhere
    heavy = fl.design.check(there.evolve({"motion.load_n": 1.0}))
    (found,) = (each for each in heavy.findings if each.code == "FORCE-REACH")
    assert (found.value, found.where.occluded > 0.5) == (pytest.approx(0.3), True)


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
    system = paper_protocol.finger_system(the_finger()).evolve(fl.RETUNED)
    w = paper_protocol.occlusion_at_end(system)
    dry = paper_protocol.occlusion_at_starts(system)[-1]
    assert 1.0 - w == pytest.approx((1.0 - dry) * np.exp(-paper_protocol.STROKE_S / system.friction.occlusion_s))
    low_n, _ = reach_at(system, w)
    assert low_n > 0.3 < 0.4
    forces_n = [low_n, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9]  # 0.3 N is out of reach then, the sine passes what is not
    peaks = [loop.margins().sensitivity_peak for loop in fl.operating_band(system, forces_n, (w,))]
    assert stability(system).sensitivity_peak_moist == pytest.approx(max(peaks), rel=1e-6)


def test_a_weaker_plate_leaves_forces_out_and_makes_no_loop_calmer():
    """At one force and just landed a linear loop does not know the largest amplitude."""
    finger = paper_protocol.finger_system(the_finger())
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
