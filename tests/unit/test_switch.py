"""Opening and closing the loop in a run: the lookup's bits while it is open, no bump when it closes."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.control.lookup import inverse_step, overdrive_gains, overdrive_step

CLOSES_S, DURATION_S = 0.5, 0.8
CLOSES, RATE_HZ, RAMP = 2500, 5000.0, 512
OPEN = {"controller.open_until_s": CLOSES_S}
BENCH = fl.bench().evolve({"motion.stroke_mm": 240.0, "setpoint.frequency_hz": 5.0})
MOVING = {"controller.feedforward": True, "controller.overdrive": True}
LAWS = {
    "pi": fl.RETUNED,
    "notch_pi": {"controller.kind": "notch_pi"},
    "notch_pi, ahead": {"controller.kind": "notch_pi"} | MOVING,
    "limit_observer": {"controller.kind": "limit_observer"},
}


def lookup(system):
    """The same bench with the lookup alone, overdriven if its law is."""
    overdriven = getattr(system.controller, "overdrive", False)
    return system.evolve({"controller.kind": "lookup", "controller.overdrive": overdriven})


def same(one, other):
    return all(np.array_equal(one[name].to_numpy(), other[name].to_numpy(), equal_nan=True) for name in one.data_vars)


@pytest.mark.parametrize("law", LAWS)
def test_open_is_the_lookup_bit_for_bit(law):
    system = BENCH.evolve(LAWS[law])
    first = {"time": slice(0, CLOSES)}
    opened = fl.simulate(system.evolve(OPEN), DURATION_S, seed=2)
    assert same(opened.isel(first), fl.simulate(lookup(system), DURATION_S, seed=2).isel(first))
    assert not np.array_equal(opened.u[CLOSES:], fl.simulate(lookup(system), DURATION_S, seed=2).u[CLOSES:])


def test_so_it_is_with_lost_ticks_a_table_and_what_is_out_of_reach():
    system = BENCH.evolve(
        fl.RETUNED
        | {"controller.lost_ticks": 0.3, "controller.jitter_s": 20e-6, "controller.model.table_size": 64}
        | {"setpoint.offset_n": 0.9, "setpoint.amplitude_n": 0.2}
    )
    first = {"time": slice(0, CLOSES)}
    opened = fl.simulate(system.evolve(OPEN), DURATION_S).isel(first)
    assert same(opened, fl.simulate(lookup(system), DURATION_S).isel(first))
    assert 0.1 < opened.saturated.mean() < 0.9


def replayed(system, setpoints):
    """u of a law that runs a Stepper, opened and closed by hand as docs/firmware-states.md says."""
    controller, model, plant = system.controller, system.controller.model, fl.Stepper(system, seed=2)
    law = law_of(controller)
    numbers, state = law.gains_for(controller), law.start_for(controller)
    believed, gains, found = 0.0, overdrive_gains(controller), []
    of_table = math.log2(model.nominal_n), math.log(2.0) / model.susceptibility_per_um2
    for k, r in enumerate(setpoints):
        since = k - CLOSES
        asked = min(max(r, model.floor_n), model.nominal_n)
        low, high = (asked, asked) if since < 0 else (model.floor_n, model.nominal_n)
        if 0 <= since < RAMP:
            low += (asked - low) * (RAMP - since) / RAMP
        if since == 0 and controller.kind in ("pi", "notch_pi"):
            state = state._replace(integral=asked - r if getattr(controller, "feedforward", False) else asked)
        state, command = law.step(state, plant.measured, r, numbers._replace(low=low, high=high), 1.0 / RATE_HZ)
        believed, amplitude = overdrive_step(believed, inverse_step(command.u, *of_table), gains)
        found.append(command.u)
        plant.tick(amplitude)
    return np.array(found)


@pytest.mark.slow
@pytest.mark.parametrize("law", LAWS)
def test_closing_is_what_the_law_does_by_itself_from_a_state_that_followed(law):
    """Beyond that there is no jump. Half a second open and the whole ramp, by the law's step alone."""
    system = BENCH.evolve(LAWS[law])
    run = fl.simulate(system.evolve(OPEN), DURATION_S, seed=2)
    assert replayed(system, run.f_r.to_numpy().tolist()) == pytest.approx(run.u.to_numpy(), abs=1e-7)


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("friction", [0.6, 1.4])
def test_the_amplitude_begins_with_at_most_what_the_set_point_asks_for(law, friction):
    system = BENCH.evolve(LAWS[law] | {"friction.nominal_n": friction})
    run = fl.simulate(system.evolve(OPEN), DURATION_S, seed=2)
    asked = np.clip(run.f_r, system.controller.model.floor_n, system.controller.model.nominal_n).to_numpy()
    low = system.controller.model.floor_n
    line = asked[CLOSES:] - (asked[CLOSES:] - low) * np.minimum(np.arange(len(run.time) - CLOSES) / RAMP, 1.0)
    assert np.all(run.u.to_numpy()[CLOSES:] >= line - 1e-12)


def test_a_loop_that_is_right_goes_on_as_if_nothing_were():
    """Friction as believed, no noise, a constant set-point: there is nothing for the law to do when it closes."""
    plain = fl.feasible().evolve(
        {
            "setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant(offset_n=0.0),
            "sensor.noise_rms_n": 0.0, "controller.open_until_s": CLOSES_S,
        }
    )  # fmt: skip
    for law in ({}, {"controller.kind": "notch_pi"}):
        run = fl.simulate(plain.evolve(law), DURATION_S)
        # A nanonewton and a femtometre: there is rounding between lookup and friction law, times kp.
        assert run.u.to_numpy() == pytest.approx(0.5, abs=1e-9)
        assert run.a[CLOSES:].to_numpy() == pytest.approx(run.a[CLOSES].item(), abs=1e-9)


def test_lanes_of_a_sweep_have_the_bits_of_a_run_alone():
    ends, system = [0.0, 0.1, 0.25], BENCH.evolve(LAWS["limit_observer"])
    grid = fl.sweep(system, {"controller.open_until_s": ends}, DURATION_S, seeds=2, n_jobs=1, progress=False)
    for k, end in enumerate(ends):
        run = fl.simulate(system.evolve({"controller.open_until_s": end}), DURATION_S, seed=1)
        assert grid.rms_error.to_numpy()[k, 1] == pytest.approx(fl.rms_error(run), rel=1e-12)
    assert len(np.unique(grid.rms_error)) == 6
