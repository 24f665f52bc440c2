"""Opening and closing the loop in a run: the lookup's bits while it is open, no bump when it closes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq

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


# How late commands come by chance: read back from the plate's amplitude, which is exponential before and after.


PERIOD_S, PERIODS = 200e-6, 5000


def lateness_s(jitter_s: float, delay_s: float) -> np.ndarray:
    """Time from each sample at which the command in force changes, by the plate's closed form."""
    quick = fl.Sine(offset_n=0.5, amplitude_n=0.1, frequency_hz=1234.5)
    system = fl.paper().evolve(
        {"controller": fl.LookupController(delay_s=delay_s, jitter_s=jitter_s), "setpoint": quick}
    )
    run = fl.simulate(system, PERIODS * PERIOD_S, seed=7)
    a = run["a"].values
    command = np.sqrt(np.log(0.8 / run["u"].values) / 0.38)
    rate = 2 * math.pi * 100.0
    old, new = command[:-2], command[1:-1]
    # a2 = new + (old - new) e^-w(T - t) + (a1 - old) e^-wT, of which t is the only unknown.
    left = a[2:] - new - (a[1:-1] - old) * math.exp(-rate * PERIOD_S)
    clear = np.abs(old - new) > 0.1
    return PERIOD_S + np.log(left[clear] / (old - new)[clear]) / rate


@pytest.mark.parametrize("delay_s", [0.0, 60e-6])
def test_a_command_is_late_by_half_a_normal_of_the_jitter(delay_s):
    jitter_s = 12e-6
    late = lateness_s(jitter_s, delay_s) - delay_s
    count = late.size
    assert count > 1000
    # Of |z|: mean sqrt(2/pi), variance 1 - 2/pi, a quarter below 0.3186, half below 0.6745 (the quartiles of normals).
    wanted = math.sqrt(2 / math.pi), math.sqrt(1 - 2 / math.pi), 0.3186, 0.6745, 1.1503
    found = late.mean(), late.std(), *np.quantile(late, [0.25, 0.5, 0.75])
    # Four standard errors, the widest that of the upper quartile: sqrt(3/16)/density there, 0.4117. Within the substep
    # of 20 us in which it changes the plate sees the command's mean, which costs up to 0.2 us, 0.02 of the jitter.
    slack = 4 * max(0.603, math.sqrt(3 / 16) / 0.4117) / math.sqrt(count)
    np.testing.assert_allclose(np.array(found) / jitter_s, wanted, atol=slack + 0.02)


def test_without_jitter_a_command_is_late_by_its_delay():
    np.testing.assert_allclose(lateness_s(1e-12, 60e-6), 60e-6, atol=0.2e-6)


# The whole loop where it has a closed form: the first sample, and where it comes to rest.


QUIET = fl.feasible().evolve({"sensor.noise_rms_n": 0.0, "disturbance": fl.Constant(offset_n=0.1)})
FLOOR = 0.8 * math.exp(-0.38 * 6.25)
reachable_force = st.floats(0.25, 0.85)  # inside [FLOOR + 0.1, 0.9]
gain = st.floats(0.1, 10.0)


def at_rest(overrides, duration_s=1.0):
    """Return the last row, having checked that nothing moves any more."""
    run = fl.simulate(QUIET.evolve(overrides), duration_s)
    end = run.isel(time=slice(-100, None))
    for name in ("f_a", "f_m", "u"):
        # The slowest pole, (1 + kp) / ki <= 55 ms, has decayed to e^-18 = 1e-8 of a newton at most.
        assert np.ptp(end[name].values) < 1e-8
    return {name: float(run[name].values[-1]) for name in run.data_vars}


@settings(max_examples=30)
@given(reachable_force, gain, st.floats(200.0, 500.0), st.sampled_from([0.0, 100e-6, 250e-6]))
def test_with_an_integral_the_force_becomes_the_set_point(force, kp, ki, delay_s):
    kp = kp / 2 if delay_s else kp  # a delay costs phase
    last = at_rest(
        {
            "setpoint": fl.Constant(offset_n=force),
            "controller.kp": kp,
            "controller.ki": ki,
            "controller.delay_s": delay_s,
        }
    )
    assert last["f_m"] == pytest.approx(force, abs=1e-7)
    assert last["f_a"] == pytest.approx(force, abs=1e-7)
    assert last["u"] == pytest.approx(force - 0.1, abs=1e-7)
    assert 0.8 * math.exp(-0.38 * last["a"] ** 2) == pytest.approx(force - 0.1, abs=1e-7)
    assert not last["saturated"]


@settings(max_examples=30)
@given(st.floats(0.4, 0.7), st.floats(2.0, 10.0))
def test_without_an_integral_a_share_of_the_error_stays(force, kp):
    """u = kp (r - f) and f = u + d give f = (kp r + d) / (1 + kp), if u is within its clamp."""
    last = at_rest({"setpoint": fl.Constant(offset_n=force), "controller.kp": kp, "controller.ki": 0.0})
    exact = (kp * force + 0.1) / (1 + kp)
    assert FLOOR < kp * (force - exact) < 0.8
    assert last["f_a"] == pytest.approx(exact, abs=1e-10)
    assert last["f_m"] == pytest.approx(exact, abs=1e-10)


@settings(max_examples=30)
@given(st.floats(0.4, 0.7), st.floats(2.0, 5.0), st.floats(0.7, 1.1), st.floats(0.3, 0.5))
def test_a_wrong_model_shifts_the_rest(force, kp, believed_n, believed_tau):
    """f = g(a(u)) + d with a(u) by the model: one equation, solved by bisection."""
    last = at_rest(
        {
            "setpoint": fl.Constant(offset_n=force),
            "controller.kp": kp,
            "controller.ki": 0.0,
            "controller.model.nominal_n": believed_n,
            "controller.model.susceptibility_per_um2": believed_tau,
        }
    )

    def miss(f):
        u = min(max(kp * (force - f), believed_n * math.exp(-believed_tau * 6.25)), believed_n)
        a = min(math.sqrt(math.log(believed_n / u) / believed_tau), 2.5)
        return 0.8 * math.exp(-0.38 * a * a) + 0.1 - f

    assert last["f_a"] == pytest.approx(brentq(miss, 0.0, 2.0, xtol=1e-13), abs=1e-9)


@pytest.mark.parametrize(("force", "reached", "a"), [(5.0, 0.9, 0.0), (-5.0, FLOOR + 0.1, 2.5)])
def test_an_unreachable_set_point_ends_at_the_clamp(force, reached, a):
    last = at_rest({"setpoint": fl.Constant(offset_n=force), "controller.ki": 100.0})
    assert last["f_a"] == pytest.approx(reached, abs=1e-12)
    assert last["a"] == pytest.approx(a, abs=1e-12)
    assert last["saturated"]


def test_a_step_of_the_disturbance_is_removed():
    step = fl.Steps(times_s=(0.0, 0.5), levels_n=(0.1, 0.3))
    run = fl.simulate(
        QUIET.evolve({"disturbance": step, "setpoint": fl.Constant(offset_n=0.6), "controller.ki": 500.0}), 1.0
    )
    f_a = run["f_a"].values
    assert f_a[2500] == pytest.approx(f_a[2499] + 0.2, abs=1e-9)  # it lands on its sample, before any reaction
    assert f_a[-1] == pytest.approx(0.6, abs=1e-7)


def test_time_runs_from_0_in_control_periods():
    run = fl.simulate(QUIET, 0.01)
    np.testing.assert_array_equal(run["time"].values, np.arange(50) / 5000.0)


def test_the_command_waits_for_the_delay():
    """The amplitude is 0 until the first command is applied, then rises as 1 - e^(-wc t)."""
    system = QUIET.evolve({"controller.kp": 0.0, "controller.ki": 0.0, "controller.delay_s": 730e-6})
    run = fl.simulate(system, 0.01)
    t = run["time"].values
    exact = -2.5 * np.expm1(-2 * np.pi * 100 * np.maximum(t - 730e-6, 0.0))
    np.testing.assert_allclose(run["a"].values, exact, rtol=0, atol=1e-14)
    assert np.count_nonzero(run["a"].values == 0.0) == 4  # t = 0, 0.2, 0.4 and 0.6 ms


@pytest.mark.parametrize(
    ("disturbance", "first"),
    [
        (fl.Constant(offset_n=0.25), 0.25),
        (fl.Sine(offset_n=0.25, amplitude_n=0.1, frequency_hz=7.0), 0.25),
        (fl.Steps(times_s=(0.0, 0.1), levels_n=(0.25, 0.7)), 0.25),
    ],
)
def test_at_t_0_the_plate_rests_and_the_sensor_has_settled(disturbance, first):
    run = fl.simulate(fl.paper().evolve({"disturbance": disturbance, "controller.kp": 0.5}), 0.01).isel(time=0)
    assert float(run["a"]) == 0.0
    assert float(run["d"]) == first
    assert float(run["f_a"]) == pytest.approx(0.8 + first, abs=1e-15)
    assert float(run["f_m"]) == float(run["f_a"])
    assert float(run["f_r"]) == 0.6
    # The integral is 0, so v = kp e = 0.5 (0.6 - 1.05) lies below the clamp.
    assert float(run["u"]) == pytest.approx(FLOOR, rel=1e-14)
    assert bool(run["saturated"])
