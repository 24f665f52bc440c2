"""The bench where it has a closed form: suspension, a tip that sticks, skin, noise, converter, motion, occlusion."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import signal

import frictionloop as fl
from frictionloop.physics.motion import load_plan, load_step, stroke_plan, stroke_step

QUIET = {
    "sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32, "touch.position.noise_um": 0.0,
    "touch.load.noise_n": 0.0, "motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0,
    "friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0,
}  # fmt: skip
# Nothing that vibration could lower: the force on the sensor is known.
DEAF = {"friction.susceptibility_per_um2": 1e-12, "controller.kp": 0.0, "controller.ki": 0.0}
SLIDING = fl.bench().evolve(QUIET).evolve(
    {"friction": fl.Friction(nominal_n=0.5), "finger": fl.RigidFinger(), "motion": fl.Sliding(), **DEAF}
)  # fmt: skip
MID = fl.bench().evolve({**QUIET, "motion.start": 0.1})


@pytest.mark.parametrize("q", [0.6, 20.0])
def test_the_suspension_answers_a_step_as_its_transfer_function(q):
    step = fl.Steps(times_s=(0.0, 0.01), levels_n=(0.1, 0.3))
    run = fl.simulate(SLIDING.evolve({"sensor.q": q, "disturbance": step}), 0.2)
    w, wc = 2 * math.pi * 145.0, 2 * math.pi * 1000.0
    system = signal.TransferFunction([w * w * wc], np.polymul([1, w / q, w * w], [1, wc]))
    t = run["time"].values[50:] - 0.01
    _, exact = signal.step(system, T=t)
    np.testing.assert_allclose(run["f_m"].values[:50], 0.6, rtol=0, atol=1e-8)
    # Half a step of the converter is 3e-10 N.
    np.testing.assert_allclose(run["f_m"].values[50:], 0.6 + 0.2 * exact, rtol=0, atol=2e-9)
    np.testing.assert_allclose(run["f_a"].values[50:], 0.8, rtol=0, atol=1e-10)


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_a_tip_that_sticks_is_a_spring(length_um):
    """F = k s0/(k + s0) x from rest, s0 = Fc/z, plus c (s0/(k + s0))^2 v of the damper, far below Fc = 0.95 N."""
    system = MID.evolve({**DEAF, "finger.slip_length_um": length_um, "motion.speed_mm_s": 1.0, "motion.stroke_mm": 4.0,
                         "motion.reversal_s": 0.04, "motion.start": 0.0})  # fmt: skip
    run = fl.simulate(system, 0.1)
    way = run["position"].values - run["position"].values[0]
    soft = 1e3 * 1e-6 * length_um / 0.95
    share = 1.0 / (1.0 + soft)
    exact = 1e3 * share * way + 1.0 * share**2 * run["speed"].values
    # The first order in F/Fc: z' = v (1 - F/Fc); inertia and a longer memory are far less.
    slip = np.cumsum(exact / 0.95 * run["speed"].values) / 5000.0
    late = run["time"].values > 0.03
    np.testing.assert_allclose(run["f_a"].values[late], (exact - 1e3 * share**2 * soft * slip)[late], rtol=0.02)
    assert run["f_a"].values[-1] > 0.06


def test_rising_friction_waits_for_the_skin():
    """A tip caught by a risen limit is pulled by the bone: F = c v at once, and then no faster than k v."""
    for length_um in (11.5, 0.0):
        loop = fl.Stepper(MID.evolve({"finger.slip_length_um": length_um, "motion.start": 0.2}))
        for _ in range(250):
            loop.tick(2.5)
        low, force = loop.force_n, []
        while loop.force_n < 0.8 and len(force) < 1000:
            loop.tick(0.0)
            force.append(loop.force_n)
        rate = 1e3 * 0.02
        least_s = (0.8 - low - 1.0 * 0.02) / rate
        assert least_s <= len(force) / 5000.0
        # Without a length it rises at that rate once the plate has died away (1.6 ms); else it creeps near the limit.
        if length_um == 0.0:
            slopes = np.diff(force)[25:] * 5000.0
            np.testing.assert_allclose(slopes[: len(slopes) // 2], rate, rtol=0.02)
            assert len(force) / 5000.0 < least_s + 3e-3


@pytest.mark.parametrize("finger", [{}, {"finger.slip_length_um": 0.0}, {"finger": fl.RigidFinger()}], ids=str)
@pytest.mark.parametrize("force", [0.3, 0.6, 0.85])
def test_integral_control_ends_at_the_set_point(force, finger):
    # A resonance of Q 20 needs the low-pass of the contact: without it these gains ring.
    overrides = {**fl.RETUNED, **finger, "disturbance.offset_n": 0.05, "sensor.q": 2.0}
    system = MID.evolve({**overrides, "setpoint": fl.Constant(offset_n=force)})
    end = fl.simulate(system, 1.5).isel(time=slice(-100, None))
    np.testing.assert_allclose(end["f_a"].values, force, rtol=0, atol=1e-5)
    np.testing.assert_allclose(end["f_m"].values, force, rtol=0, atol=1e-5)
    assert not end["saturated"].any()


@pytest.mark.parametrize("cutoff_hz", [300.0, 1000.0])
def test_noise_is_as_strong_as_its_density_says(cutoff_hz):
    system = SLIDING.evolve({"sensor.cutoff_hz": cutoff_hz, "sensor.noise_density_n_rthz": 2.3e-6})
    noise = fl.simulate(system, 20.0, seed=4)["f_m"].values[100:] - 0.5
    assert 2.3e-6 * math.sqrt(math.pi / 2 * cutoff_hz) == pytest.approx(system.sensor.noise_rms_n)
    decay = math.exp(-2 * math.pi * cutoff_hz / 5000)
    # Standard deviation of a variance estimated from samples with correlation decay^|k|.
    spread = math.sqrt(2 / noise.size * (1 + decay**2) / (1 - decay**2))
    assert np.var(noise) == pytest.approx(system.sensor.noise_rms_n**2, rel=4 * spread)
    assert np.corrcoef(noise[1:], noise[:-1])[0, 1] == pytest.approx(decay, abs=4 / math.sqrt(noise.size))


def test_the_converter_tells_whole_steps_within_its_range():
    system = SLIDING.evolve({"disturbance": fl.Sine(offset_n=1.0, amplitude_n=1.9, frequency_hz=3.0)})
    fine, coarse = (fl.simulate(system.evolve({"sensor.adc_bits": bits}), 0.5)["f_m"].values for bits in (32, 8))
    whole = 2 * 2.5 / 2**8
    np.testing.assert_allclose(coarse / whole, np.round(coarse / whole), rtol=0, atol=1e-9)
    inside = np.abs(fine) < 2.5 - whole
    assert np.all(np.abs(coarse - fine)[inside] <= whole / 2 * (1 + 1e-6))
    assert coarse.max() == pytest.approx(2.5 - whole, rel=1e-12)
    assert fine.max() == pytest.approx(2.5, rel=1e-6)


@pytest.mark.parametrize("contact_s", [0.0, 0.3])
def test_position_speed_and_load_are_those_of_the_plan(contact_s):
    system = fl.bench().evolve(
        {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.contact_s": contact_s, "motion.lifted_s": 0.1,
         "motion.stroke_mm": 4.0, "motion.start": 0.3}
    )  # fmt: skip
    run, m = fl.simulate(system, 1.0, seed=8), system.motion
    plan, load = stroke_plan(m), load_plan(m, 8)
    exact = np.array([(*stroke_step(t, plan), load_step(t, 0.0, load)) for t in run["time"].values]).T
    for name, values in zip(("position", "speed", "load"), exact, strict=True):
        np.testing.assert_allclose(run[name].values, values, rtol=0, atol=1e-12, err_msg=name)
    # Scored: pressed, and farther from an end than 2 mm, which a stroke of 4 mm nowhere is.
    assert not run["scored"].values[np.abs(run["position"].values) > 1e-4].any()
    assert run["load"].values.min() == (0.0 if contact_s else pytest.approx(run["load"].values.min()))


def test_a_finger_of_the_bench_trembles_as_those_that_were_measured():
    """30 um along the stroke, 30 mN of load and a peak at 10 Hz that is 4 Hz wide (docs/finger.md)."""
    still, duration_s = {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0}, 60.0
    trembling, steady = (fl.simulate(fl.bench().evolve(each), duration_s, seed=2) for each in ({}, still))
    for name, rms in (("position", 30e-6), ("load", 0.03)):
        tremor = (trembling[name] - steady[name]).values
        # A band b wide has pi b T independent values of its variance; 5 deviations.
        assert np.std(tremor) == pytest.approx(rms, rel=5 * math.sqrt(0.5 / (math.pi * 4.0 * duration_s)))
        f, power = signal.welch(tremor, 5000.0, nperseg=10_000)
        inside = np.abs(f - 10.0) <= 4.0
        # (f^2 - f_p^2)^2 + b^2 (f_p^2 + b^2/4) is 1/|x|^2: what it leaves between 6 and 14 Hz, by the trapezium.
        exact = 1.0 / ((f**2 - 100.0) ** 2 + 16.0 * 104.0)
        assert power[inside].sum() / power.sum() == pytest.approx(exact[inside].sum() / exact.sum(), abs=0.05)


def test_scored_is_pressed_and_away_from_the_ends():
    run = fl.simulate(fl.bench().evolve({**QUIET, "motion.contact_s": 3.0, "motion.speed_mm_s": 80.0}), 4.0)
    x, load = run["position"].values, run["load"].values
    np.testing.assert_array_equal(run["scored"].values, (np.abs(x) <= 0.030 - 0.002) & (load >= 0.5 * 0.5))
    assert 0.1 < run["scored"].values.mean() < 0.9


def test_occlusion_grows_in_contact_and_dries_in_the_air():
    system = MID.evolve(
        {"friction.occlusion_ratio": 3.0, "friction.occlusion_s": 0.4, "friction.drying_s": 0.2,
         "friction.load_exponent": 0.0, "motion.contact_s": 0.5, "motion.lifted_s": 0.3, **fl.RETUNED}
    )  # fmt: skip
    run = fl.simulate(system, 1.2)
    t, limit, load = (run[name].values for name in ("time", "limit", "load"))
    w = np.where(t < 0.5, -np.expm1(-t / 0.4), 0.0)
    left = -math.expm1(-0.5 / 0.4)
    w = np.where((t >= 0.5) & (t < 0.8), left * np.exp(-(t - 0.5) / 0.2), w)
    dried = left * math.exp(-0.3 / 0.2)
    w = np.where(t >= 0.8, 1 - (1 - dried) * np.exp(-(t - 0.8) / 0.4), w)
    # The state goes on by what the load is at the end of a period: landing and lift-off are told to one period.
    tolerance = 0.95 * 2 * 2 * 200e-6 / 0.2
    np.testing.assert_allclose(limit, np.where(load > 0, 0.95 * (1 + 2 * w), 0.0), rtol=0, atol=tolerance)


def test_friction_follows_load_and_speed():
    system = fl.bench().evolve({**QUIET, "motion.load_drift": 0.2, "motion.load_drift_s": 0.5, "motion.start": 0.02,
                                "friction.speed_slope": -0.12, "friction.load_exponent": 0.8})  # fmt: skip
    run = fl.simulate(system, 1.0)
    v2 = run["speed"].values ** 2
    exact = 0.95 * (run["load"].values / 0.5) ** 0.8 * ((v2 + 1e-6) / (4e-4 + 1e-6)) ** -0.06
    np.testing.assert_allclose(run["limit"].values, exact, rtol=1e-12)
    np.testing.assert_allclose(run["floor"].values, exact * math.exp(-0.38 * 6.25), rtol=1e-12)
