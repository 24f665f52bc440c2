"""What no run of a bench may ever do, searched for over fingers, sensors, motions and controllers."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl

PERIODS = 250


@st.composite
def benches(draw, rate_hz=None):
    rate_hz = rate_hz or draw(st.sampled_from([2000.0, 5000.0, 20000.0]))
    span = PERIODS / rate_hz
    speed, turn = draw(st.floats(1.0, 400.0)), draw(st.floats(0.05, 2.0)) * span
    # Strokes short enough for several reversals in a run, or longer than it.
    stroke = speed * max(0.626 * turn, draw(st.floats(0.05, 3.0)) * span)
    landing = draw(st.floats(0.01, 0.3)) * span
    contact = draw(st.sampled_from([0.0, 2.0, 5.0])) * landing
    finger = fl.Skin(
        stiffness_n_m=draw(st.floats(200, 5000)), damping_n_s_m=draw(st.floats(0, 3)),
        mass_kg=draw(st.floats(3e-5, 1e-3)), slip_length_um=draw(st.one_of(st.just(0.0), st.floats(1, 100))),
    )  # fmt: skip
    source = st.sampled_from([
        fl.Constant(offset_n=0.4), fl.Sine(offset_n=0.5, amplitude_n=0.4, frequency_hz=50.0),
        fl.Steps(times_s=(0.0, span / 3, span / 2), levels_n=(0.3, 0.8, -0.2)), fl.ColouredNoise(rms_n=0.2),
    ])  # fmt: skip
    return fl.bench().evolve(
        {
            "setpoint": draw(source), "disturbance": draw(source),
            "finger": draw(st.sampled_from([finger, fl.RigidFinger()])),
            "friction.nominal_n": draw(st.floats(0.1, 3)), "friction.load_exponent": draw(st.floats(0, 2)),
            "friction.speed_slope": draw(st.floats(-1, 1)), "friction.occlusion_ratio": draw(st.floats(0.1, 20)),
            "friction.occlusion_s": draw(st.floats(1e-3, 20)), "friction.moist_loss": draw(st.floats(0, 0.99)),
            "friction.roughness_rms": draw(st.floats(0, 0.3)), "friction.roughness_longest_mm": draw(st.floats(1, 300)),
            "plate.q": draw(st.floats(20, 1e4)), "sensor.q": draw(st.floats(0.3, 100)),
            "sensor.resonance_hz": draw(st.floats(5, 5000)), "sensor.cutoff_hz": draw(st.floats(10, 1e4)),
            "sensor.adc_bits": draw(st.integers(2, 32)), "sensor.noise_density_n_rthz": draw(st.floats(0, 1e-3)),
            "motion.speed_mm_s": speed, "motion.stroke_mm": min(stroke, 255.0), "motion.reversal_s": min(
                turn, min(stroke, 255.0) / (0.625 * speed)), "motion.start": draw(st.floats(0, 1)),
            "motion.load_n": draw(st.floats(0.05, 3)), "motion.load_drift": draw(st.floats(0, 0.49)),
            "motion.tremor_um": draw(st.floats(0, 200)), "motion.tremor_n": draw(st.floats(0, 0.5)),
            "motion.landing_s": landing, "motion.contact_s": contact,
            "motion.lifted_s": draw(st.floats(0.02, 0.5)) * span,
            "touch.load.developed_mm": 0.4 * min(stroke, 255.0) * draw(st.floats(0, 1)),
            "touch.position.noise_um": draw(st.floats(0, 100)), "touch.load.noise_n": draw(st.floats(0, 0.05)),
            "controller.kp": draw(st.sampled_from([0.0, 0.06, 1.0, 10.0, 1e5])),
            "controller.ki": draw(st.sampled_from([0.0, 2.0, 130.0, 1e7])), "controller.rate_hz": rate_hz,
            "controller.delay_s": draw(st.sampled_from([0.0, 0.4, 1.0, 1.65, 7.3])) / rate_hz,
            "controller.jitter_s": draw(st.sampled_from([0.0, 0.1, 2.0])) / rate_hz,
            "controller.model.table_size": draw(st.sampled_from([0, 50])),
        }
    )  # fmt: skip


def most_friction(system, limit):
    """What the contact allows of the force: the limit; with a length, which at rest keeps what it holds, any so far."""
    return np.maximum.accumulate(limit) if getattr(system.finger, "slip_length_um", 0.0) else limit


@pytest.mark.slow
@settings(max_examples=250)
@given(benches(), st.integers(0, 2**64 - 1))
def test_every_run_stays_where_physics_and_the_controller_allow(system, seed):
    run = fl.simulate(system, PERIODS / system.controller.rate_hz, seed)
    for name in run.data_vars:
        assert np.all(np.isfinite(run[name].values)), name
    f_a, a, d, limit, load = (run[name].values for name in ("f_a", "a", "d", "limit", "load"))
    top = system.plate.max_amplitude_um
    assert np.all((a >= 0) & (a <= top * (1 + PERIODS * 10 * 2.0**-52)))
    assert np.all(limit >= 0) and np.all(load >= 0)
    assert np.all((run["floor"].values >= 0) & (run["floor"].values <= limit))
    assert np.all(np.abs(f_a - d) <= most_friction(system, limit) * (1 + 1e-9) + 1e-12)
    assert np.all(np.abs(run["f_m"].values) <= system.sensor.range_n)
    lifted = load == 0
    assert np.all(limit[lifted] == 0)
    # Its last substep may still have touched: from the next sample on the force is 0.
    gone = lifted & np.append(lifted[:1], lifted[:-1])
    assert np.all(f_a[gone] == d[gone])
    check_controller(system, run)


def check_controller(system, run):
    """The PI law beside the recorded one; without a sliding finger its integral is held and is what it commands."""
    c, integral = system.controller, 0.0
    low, high = c.model.floor_n, c.model.nominal_n
    errors, u = (run["f_r"] - run["f_m"]).values, run["u"].values
    assert np.all((u >= low) & (u <= high))
    largest = 0.0
    for k, (error, slides) in enumerate(zip(errors.tolist(), run["sliding"].values.tolist(), strict=True)):
        e = error if slides else 0.0
        v = c.kp * e + integral
        largest = max(largest, abs(c.kp * e), abs(integral), abs(c.ki * e / c.rate_hz))
        slack = 1e-11 * (largest + 1e-3) * (k + 1)
        assert abs(u[k] - min(max(v, low), high)) <= slack
        if min(abs(v - low), abs(v - high)) > slack:
            assert run["saturated"].values[k] == (v < low or v > high)
        if not slides and k:
            assert abs(u[k] - min(max(integral, low), high)) <= slack
        clamped = run["saturated"].values[k]
        if not (clamped and (e > 0 if u[k] == high else e < 0)):
            integral += c.ki / c.rate_hz * e


@settings(max_examples=25)
@given(benches(5000.0), st.integers(0, 1000))
def test_a_run_is_the_beginning_of_a_longer_one(system, seed):
    short, long = (fl.simulate(system, n / 5000.0, seed) for n in (PERIODS // 2 + 1, PERIODS))
    for name in short.data_vars:
        np.testing.assert_array_equal(short[name].values, long[name].values[: short.sizes["time"]])


def test_a_lifted_finger_leaves_the_controller_as_it_was():
    system = fl.bench().evolve({**fl.RETUNED, "motion.contact_s": 0.4, "motion.lifted_s": 0.3, "motion.start": 0.1,
                                "disturbance.offset_n": 0.0})  # fmt: skip
    run = fl.simulate(system, 1.2, seed=2)
    load, u, sliding = run["load"].values, run["u"].values, run["sliding"].values
    air = np.flatnonzero((load == 0) & (run["time"].values > 0.1))
    first, last = air[0], air[np.flatnonzero(np.diff(air, append=10**9) > 1)[0]]
    assert last - first > 1490
    assert np.all(run["f_a"].values[first + 1 : last + 1] == 0)
    assert not sliding[first + 1 : last + 1].any()
    # Held to the last bit, so nothing has wound up; and taken up from there with one step of the law.
    assert np.unique(u[first + 1 : last + 1]).size == 1
    landed = last + 1 + np.argmax(sliding[last + 1 :])
    assert np.unique(u[first + 1 : landed]).size == 1
    error = run["f_r"].values[landed] - run["f_m"].values[landed]
    assert abs(u[landed] - u[last]) <= system.controller.kp * abs(error) + 1e-12
    assert math.isfinite(u[landed])


def test_a_finger_that_lifts_winds_the_controller_up_no_more_than_until_it_is_let_go():
    calm = {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "friction.roughness_rms": 0.0,
            "friction.occlusion_ratio": 1.0, "motion.stroke_mm": 200.0, "motion.start": 0.05}  # fmt: skip
    lifts = {"motion.contact_s": 1.3, "motion.lifted_s": 0.4, "setpoint": fl.Constant(offset_n=0.6)}
    system = fl.bench().evolve({**fl.RETUNED, **calm, **lifts})

    def wound_n(system):
        run = fl.simulate(system, 1.6)
        u, lifted = run["u"].values, np.flatnonzero((run["load"].values == 0) & (run["time"].values > 1))[0]
        leaves = lifted - round(system.motion.landing_s * system.controller.rate_hz)
        return u[lifted + 100] - u[leaves - 5]

    # Load as 3 y^2 - 2 y^3 from y = 1 down, friction as its power 0.9: ki times what is missing until the share is met.
    y = np.linspace(1, 0, 100_001)
    left = 3 * y**2 - 2 * y**3
    gone = left >= system.touch.load.touch_share
    missing_ns = 0.6 * np.sum(1 - left[gone] ** system.friction.load_exponent) * system.motion.landing_s / y.size
    assert 0.0 < wound_n(system) <= system.controller.ki * missing_ns
    # A finger that counts as touching down to 20 mN lets it wind up several times as far.
    assert wound_n(system.evolve({"touch.load.touch_share": 0.0})) > 2 * system.controller.ki * missing_ns
