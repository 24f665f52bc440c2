"""Forces asked for that are out of reach: refused where none is left, and named where another stands for them."""

from __future__ import annotations

import re

import pytest

import frictionloop as fl
from frictionloop.analysis.linear import operating_band
from frictionloop.analysis.operating import missed, occlusions
from frictionloop.design import synthesis
from frictionloop.design.controller_findings import out_of_reach
from frictionloop.design.corners import corners
from frictionloop.design.requirements import Requirements, feedforward

BENCH = {
    "plate.max_amplitude_um": 2.0,
    "controller.model.max_amplitude_um": 2.0,
    "friction.nominal_n": 1.1,
    "sensor.resonance_hz": 170.0,
    "setpoint": fl.Sine(offset_n=0.5, amplitude_n=0.3),
}


def bench(amplitude_n: float) -> fl.System:
    return fl.bench().evolve(BENCH).evolve({"setpoint.amplitude_n": amplitude_n})


@pytest.mark.slow
def test_a_force_that_no_amplitude_leaves_counts_as_the_nearest_that_it_does():
    found = synthesis.synthesised(bench(0.3), "pi", Requirements())[0].corners
    dry = [each.loop.elements.force_n for each in found if each.loop.elements.occluded == 0.0]
    (beyond,) = missed(bench(0.3))
    assert (beyond.force_n, beyond.instead_n) == (pytest.approx(0.2), pytest.approx(min(dry)))


def test_where_none_can_be_had_the_design_is_refused_before_any_search(monkeypatch):
    monkeypatch.setitem(synthesis.SYNTHESES, "notch_pi", lambda *_: pytest.fail("it searched"))
    weak = bench(0.02).evolve({"setpoint.offset_n": 0.2})
    with pytest.raises(fl.FrictionloopError, match="in reach") as refused:
        synthesis.synthesised(weak, "notch_pi", Requirements())
    more_um, less_n = (
        float(each) for each in re.search(r"takes (\S+) um, .* below (\S+) N", str(refused.value)).groups()
    )
    for change in ({"plate.max_amplitude_um": 1.001 * more_um, "controller.model.max_amplitude_um": 1.001 * more_um},
                   {"friction.nominal_n": 0.995 * less_n}):  # fmt: skip
        assert missed(weak.evolve(change | {"setpoint.offset_n": 0.22, "setpoint.amplitude_n": 0.0})) == []


def test_the_force_evaluated_in_place_of_another_is_that_of_the_loops():
    system = bench(0.2)
    states = occlusions(system)
    (beyond,) = missed(system, states)
    evaluated = [loop.elements for loop in operating_band(system, occluded=states)]
    assert min(each.force_n for each in evaluated if each.occluded > 0) == pytest.approx(beyond.instead_n, rel=1e-12)


def test_a_force_out_of_reach_is_told_with_the_nearest_where_that_is_worst():
    """Over speeds the least force is that of the speed with most friction."""
    tilt = bench(0.2).evolve({"friction.speed_slope": -0.15, "controller.kind": "pi", "controller.ki": 5.0})
    over = Requirements(speeds_mm_s=(10.0, 60.0), slip_lengths_um=(11.5,)).grid(2, 1)
    state = occlusions(tilt)[-1]
    least_n = [missed(each, [state])[0].instead_n for each in over.systems(tilt)]
    (told,) = out_of_reach(corners(tilt, over))
    assert (told.code, told.value, told.where.occluded) == ("FORCE-REACH", pytest.approx(0.3), state)
    assert told.limit == pytest.approx(max(least_n)) and min(least_n) < max(least_n)
    fine = tilt.evolve({"setpoint.offset_n": 0.75, "setpoint.amplitude_n": 0.05})
    assert list(out_of_reach(corners(fine, over))) == []


def test_no_feed_forward_where_the_set_point_reaches_the_believed_friction():
    bench = fl.bench()
    assert feedforward(bench) == (True, ())
    forward, (why,) = feedforward(bench.evolve({"setpoint.offset_n": 0.9}))
    assert not forward and (why.code, why.value) == ("FORWARD-CLIPPED", 1.0)
    assert feedforward(bench.evolve({"setpoint.offset_n": 0.9, "controller.model.nominal_n": 1.3}))[0]
