"""The tracker on the bench where it is hard: landings, reversals, other susceptibilities, 150 mm/s, both contacts."""

from __future__ import annotations

from operator import attrgetter

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.comparison.protocol import STEPPED, setpoint_of
from frictionloop.design.learnt import learnt_in_run

TRACKER = {"controller.kind": "tracker"}
OPEN = {"controller.kind": "lookup"}
LANDS = {"motion.contact_s": 2.0}
LONG = {"motion.stroke_mm": 240.0}
LEAPS = LONG | {"motion.speed_mm_s": 80.0, "setpoint": setpoint_of(STEPPED, 6.0)}
CASES = {
    "landings": (LANDS | LONG, 1.0),
    "reversals": ({}, 1.0),
    "half the susceptibility": (LONG, 0.5),
    "twice the susceptibility": (LONG, 2.0),
    "40 mm/s": (LONG | {"motion.speed_mm_s": 40.0}, 1.0),
    "55 mm/s": (LONG | {"motion.speed_mm_s": 55.0}, 1.0),
    "72 mm/s": (LONG | {"motion.speed_mm_s": 72.0}, 1.0),
    "150 mm/s": (LONG | {"motion.speed_mm_s": 150.0}, 1.0),
    "leaps": (LEAPS, 1.0),
    "leaps with half the susceptibility": (LEAPS, 0.5),
    "leaps with twice the susceptibility": (LEAPS, 2.0),
}
RATE_HZ, SCORE_S = 5000, 1.0
LINES = {100.0: 0.5, 250.0: 0.1}
"""Most that 20 Hz may hold of the variance, by the frequency above which; white noise leaves them 0.8 %.

Neither strokes, finger nor set-point have a line above 100 Hz, so one there is of the loop's making. A limit cycle
holds nearly all, in every run; at the resonance, where a stable loop amplifies most, it begins at half, beyond 250 Hz
at a tenth. Of one run the strongest 20 Hz are partly chance: one finger's hold 6 to 11 % from seed to seed. So the
variance of several runs together has to keep to this, that of one to a quarter more.
"""
SEEDS, ALONE = range(3), 1.25


def people(factor):
    paths = "friction.susceptibility_per_um2"
    changed = [{**each, paths: factor * each[paths]} for each in fl.fingers(240, 23)]
    able = fl.capable(changed, contact_s=10.0)["capable"].values
    return [each for each, yes in zip(changed, able, strict=True) if yes][:8]


def line_share(errors, above_hz):
    """Share of the variance of some runs that the strongest 20 Hz above ``above_hz`` hold."""
    errors = np.atleast_2d(errors)
    power = np.abs(np.fft.rfft((errors - errors.mean(1, keepdims=True)) * np.hanning(errors.shape[1]))) ** 2
    hz = np.fft.rfftfreq(errors.shape[1], 1 / RATE_HZ)
    wide = round(20.0 / (hz[1] - hz[0]))
    sums = np.convolve(np.where(hz > above_hz, power.sum(0), 0.0), np.ones(wide), "valid")
    return float(sums.max() / power.sum())


def left(system, finger):
    """Residual rms of each run in N, and the scored error, 0 elsewhere."""
    found = []
    for seed in SEEDS:
        run = fl.simulate(system.evolve(finger), duration_s=6.0, seed=seed)
        keep = run["scored"].values & (run["time"].values > SCORE_S)
        error = (run["f_a"] - run["f_r"]).values
        found.append((np.sqrt(np.mean(error[keep] ** 2)), np.where(keep, error, 0.0)[round(SCORE_S * RATE_HZ) :]))
    residuals, errors = zip(*found, strict=True)
    return np.array(residuals), np.array(errors)


def test_a_line_is_found_by_its_share_of_the_variance():
    """A sine of 300 Hz with a fifth of the variance, in white noise; in one of two runs, with a ninth of both."""
    time_s = np.arange(5 * RATE_HZ) / RATE_HZ
    noise = np.random.default_rng(1).normal(0.0, 1.0, time_s.size)
    rings = noise + np.sqrt(2 * 0.25) * np.sin(2 * np.pi * 300.0 * time_s)
    assert [line_share(noise, above_hz) for above_hz in LINES] == pytest.approx([0.0, 0.0], abs=0.02)
    assert [line_share(rings, above_hz) for above_hz in LINES] == pytest.approx([0.2, 0.2], abs=0.02)
    assert line_share([noise, rings], 250.0) == pytest.approx(1 / 9, abs=0.02)


RINGS = pytest.mark.xfail(strict=True, reason="experimental: after quick set-point steps some fingers ring")
LEAVES = pytest.mark.xfail(strict=True, reason="experimental: a finger keeps 0.55 of its residual, without a line")


def longer(first):
    """Return the mark of a test that takes long: the first of a kind is run in continuous integration."""
    return [pytest.mark.slow if first else pytest.mark.soak]


def rings(contact, case):
    """Return whether fingers are known to ring."""
    return contact == "slider" and case.startswith("leaps with")


@pytest.mark.parametrize(
    ("contact", "case"),
    [
        pytest.param(contact, case, marks=[*longer(case == "leaps"), *[RINGS] * rings(contact, case)])
        for contact in ("dahl", "slider")
        for case in CASES
    ],
)
def test_no_limit_cycle(contact, case):
    """Each finger: less rms than with the lookup alone, which cannot ring, and no line of the loop's making."""
    changes, factor = CASES[case]
    bench = fl.bench().evolve({"finger.contact": contact, **changes})
    found = [(*left(bench.evolve(TRACKER), each), left(bench.evolve(OPEN), each)[0]) for each in people(factor)]
    assert len(found) >= 4
    for residuals_n, errors_n, open_n in found:
        assert np.all(residuals_n < open_n)
        for above_hz, most in LINES.items():
            assert line_share(errors_n, above_hz) < most
            assert all(line_share(error_n, above_hz) < ALONE * most for error_n in errors_n)


DISTURBS = (
    "friction.roughness_rms", "motion.tremor_n", "motion.tremor_um", "motion.load_drift", "sensor.noise_density_n_rthz",
)  # fmt: skip
QUIET, KEPT = 0.03, 0.5
"""A loop that cycles keeps its size where all that disturbs it has 3 %; one that does not leaves 3 % and what the steps
of the reading, sines and turns leave. Half is between the two, nearer to neither."""
STICKS = {"friction.static_ratio": 1.4}
STROKES = {
    "long": (LONG, (20.0, 25.0, 30.0, 40.0, 55.0, 72.0, 80.0, 110.0)),
    "long and quick": (LONG, (150.0,)),
    "reversals": ({}, (20.0, 25.0, 30.0, 40.0, 55.0, 72.0, 80.0)),
    "slow reversals": ({"motion.reversal_s": 1.0}, (20.0, 30.0, 40.0)),
}
"""At 150 mm/s strokes of 60 mm are all turns, which leave more than the disturbance does."""


def kept(system):
    """Share of the residual rms that is left with little disturbance, and the strongest 20 Hz beyond 250 Hz of it."""
    calm = system.evolve({path: QUIET * attrgetter(path)(system) for path in DISTURBS})
    runs = [fl.simulate(each, duration_s=6.0, seed=0) for each in (system, calm)]
    scored = runs[0]["scored"].values & (runs[0]["time"].values > SCORE_S)
    errors = [np.where(scored, run["f_a"] - run["f_r"], 0.0)[round(SCORE_S * RATE_HZ) :] for run in runs]
    return np.std(errors[1]) / np.std(errors[0]), line_share(errors[0], 250.0)


@pytest.mark.parametrize("contact", ["dahl", "slider"])
@pytest.mark.parametrize(
    ("factor", "stroke"),
    [
        pytest.param(factor, stroke, marks=[*longer(of == (1.0, "long")), *[LEAVES] * (of == (1.0, "long and quick"))])
        for factor in (0.5, 1.0, 2.0)
        for stroke in STROKES
        for of in [(factor, stroke)]
    ],
)
def test_what_is_left_comes_from_what_disturbs(contact, factor, stroke):
    """All that is asked to be stable: no residual of the loop's own making, and no line of a fifth in one run."""
    changes, speeds_mm_s = STROKES[stroke]
    for speed_mm_s in speeds_mm_s:
        bench = fl.bench().evolve({"finger.contact": contact, "motion.speed_mm_s": speed_mm_s, **changes, **TRACKER})
        for finger in people(factor):
            share, line = kept(bench.evolve(finger))
            assert share < KEPT and line < 0.2


@pytest.mark.slow
@pytest.mark.parametrize(
    ("contact", "speed_mm_s"), [("dahl", 20.0), ("dahl", 80.0), ("slider", 40.0), ("slider", 80.0)]
)
def test_fingers_that_stick_are_freed(contact, speed_mm_s):
    """Not on a rigid slider at 20 mm/s, where they stick and slip under every law (docs/which-law.md)."""
    bench = fl.bench().evolve({"finger.contact": contact, "motion.speed_mm_s": speed_mm_s, **STICKS, **TRACKER})
    assert all(kept(bench.evolve(finger))[0] < KEPT for finger in people(1.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    "law",
    [{"controller.kp": 10.0, "controller.ki": 2.0}, TRACKER | {"controller.model.resonance_hz": 174.0}],
    ids=["printed gains", "told 20 % too much"],
)
def test_a_loop_that_cycles_keeps_its_size(law):
    """What the two tests above would see: half of the fingers at least."""
    bench = fl.bench().evolve(LONG | law)
    assert np.median([kept(bench.evolve(finger))[0] for finger in people(1.0)]) > KEPT


@pytest.mark.parametrize("speed_mm_s", [5.0, 10.0, 20.0])
def test_slow_strokes_tell_the_contacts_apart(speed_mm_s):
    """From 20 um/N, between them: 50 um/N are never taken for a slider's 0, nor 0 for a bristle."""
    slow = fl.bench().evolve(TRACKER | LONG | {"motion.speed_mm_s": speed_mm_s, "setpoint": fl.Constant(offset_n=0.6)})
    for contact, least, most in (("dahl", 30.0, 80.0), ("slider", 0.0, 3.0)):
        for seed in range(2):
            own = learnt_in_run(slow.evolve({"finger.contact": contact}), 6.0, seed).controller
            assert least <= own.compliance_um_per_n <= most


@pytest.mark.parametrize("over", [1.0, 1.75])
def test_a_moist_finger_whose_susceptibility_is_believed_too_large_is_held(over):
    """3.4 N without vibration and 0.6 N wanted: held to 5 mN on the mean; believed, it is one of 12 N."""
    amplitude_um = 2.0
    tau = np.log(3.4 / 0.6) / amplitude_um**2
    moist = {"friction.nominal_n": 3.4, "friction.occlusion_ratio": 1.0, "friction.susceptibility_per_um2": tau}
    believed = {
        "controller.compliance_um_per_n": 50.0, "controller.compliance_learning": 0.0,
        "controller.susceptibility_learning": 0.0, "controller.model.susceptibility_per_um2": over * tau,
    }  # fmt: skip
    held = {"motion.speed_mm_s": 80.0, "setpoint": fl.Constant(offset_n=0.6)}
    run = fl.simulate(fl.bench().evolve(TRACKER | LONG | moist | believed | held), duration_s=2.5, seed=0)
    error_n = (run["f_a"] - run["f_r"]).values[run["time"].values > 0.5]
    assert abs(error_n.mean()) < 5e-3
