"""A run of the bench has the same bits alone and in a tile of other fingers, in any lane, chunks or Stepper."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.lookup import inverse_step
from frictionloop.loop import simulate as simulate_module
from frictionloop.loop.companion_runs import TURNS
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.kernel.traces import BENCH_TRACES
from frictionloop.loop.parallel_runs import simulate_all
from frictionloop.loop.simulate import run_tile

PERIODS = 333  # not a whole number of blocks of 32
DURATION_S = PERIODS / 5000.0
# Landings, lift-offs and reversals in every run.
BUSY = fl.bench().evolve(
    {"motion.stroke_mm": 0.6, "motion.reversal_s": 0.01, "motion.contact_s": 0.04, "motion.landing_s": 0.01,
     "motion.lifted_s": 0.01, "motion.unscored_n": 0.05, "controller.kp": 1.0,
     "touch.load.developed_mm": 0.1}
)  # fmt: skip
KINDS = {
    "bristle": {},
    "longer and no delay": {"finger.slip_length_um": 30.0, "controller.delay_s": 0.0},
    "slider and a delay within the period": {"finger.slip_length_um": 0.0, "controller.delay_s": 330e-6},
    "rigid": {"finger.kind": "rigid"},
    "jitter and lost ticks": {"controller.jitter_s": 30e-6, "controller.lost_ticks": 0.1},
    "steps": {"setpoint": fl.Steps(times_s=(0.0, 0.01, 0.03), levels_n=(0.3, 0.6, 0.4))},
    "noise": {"disturbance": fl.ColouredNoise(offset_n=0.1, rms_n=0.03), "controller.model.table_size": 64},
    "the sensor of Section 2": {"sensor.kind": "lowpass", "sensor.noise_rms_n": 1e-3},
}


def people(kind, count=LANES):
    base = BUSY.evolve(KINDS[kind])
    if kind == "rigid":
        return [base.evolve({"motion.person": i, "friction.nominal_n": 0.5 + 0.02 * i}) for i in range(count)]
    return [base.evolve(finger) for finger in fl.fingers(count, seed=6)]


def alone(system, seed, periods=PERIODS):
    run = fl.simulate(system, periods / 5000.0, seed)
    return np.array([run[name].values for name in BENCH_TRACES])


def together(systems, seeds):
    traces = np.empty((len(BENCH_TRACES), PERIODS, LANES))
    run_tile(lower(systems, seeds, traces=traces.reshape(-1)), PERIODS)
    return np.moveaxis(traces, 2, 0)[: len(systems)]


@pytest.mark.parametrize("kind", KINDS)
def test_every_finger_of_a_tile_is_the_finger_alone(kind):
    systems = people(kind)
    for seeds in (list(range(LANES)), [9] * LANES):
        for lane, got in enumerate(together(systems, seeds)):
            np.testing.assert_array_equal(got, alone(systems[lane], seeds[lane]), err_msg=f"lane {lane}")


@pytest.mark.parametrize("kind", KINDS)
def test_neither_lane_nor_company_nor_chunks_matter(kind, monkeypatch):
    systems, seeds = people(kind, 5), [3, 3, 2**40, 0, 2**64 - 1]
    first, order = together(systems, seeds), [4, 2, 0, 1, 3]
    again = together([systems[i] for i in order], [seeds[i] for i in order])
    np.testing.assert_array_equal(again, first[order])
    for chunk in (32, 96):
        monkeypatch.setattr(simulate_module, "CHUNK", chunk)
        np.testing.assert_array_equal(alone(systems[0], 3), first[0])


@pytest.mark.parametrize("contact", ["regular", "irregular"])
def test_lanes_may_differ_in_delay_and_jitter(contact):
    systems = [
        BUSY.evolve({"controller.delay_s": 1e-6 * delay, "controller.jitter_s": jitter})
        for delay, jitter in zip((0, 50, 200, 330, 900), (0, 20e-6, 0, 1e-3, 0), strict=True)
    ]
    systems = [s.evolve({"controller.jitter_s": 0.0}) for s in systems] if contact == "regular" else systems
    for got, one in zip(together(systems, [5] * 5), systems, strict=True):
        np.testing.assert_array_equal(got, alone(one, 5))


def replay(system, seed, motion, periods=PERIODS):
    run, model = fl.simulate(system, periods / 5000.0, seed), system.controller.model
    constants = (np.log2(model.nominal_n), math.log(2.0) / model.susceptibility_per_um2)
    loop = fl.Stepper(system, seed)
    told = [(loop.measured.force, loop.amplitude_um, loop.force_n)]
    path = run[["position", "speed", "load"]].to_array().values.T
    for k, u in enumerate(run["u"].values[:-1]):
        given = fl.Movement(*(float(x) for x in path[k + 1])) if motion else None
        measured = loop.tick(inverse_step(u, *constants), given)
        told.append((measured.force, loop.amplitude_um, loop.force_n))
    f_m, a, f_a = np.array(told).T
    np.testing.assert_array_equal(f_m, run["f_m"].values)
    np.testing.assert_array_equal(a, run["a"].values)
    return f_a, run


@pytest.mark.parametrize("seed", [0, 2**63])
@pytest.mark.parametrize("kind", [kind for kind in KINDS if kind != "noise"])  # which has a table
def test_a_runs_commands_give_a_runs_measurements(kind, seed):
    f_a, run = replay(BUSY.evolve(KINDS[kind]), seed, motion=False)
    np.testing.assert_array_equal(f_a, run["f_a"].values)


@pytest.mark.parametrize("kind", ["bristle", "slider and a delay within the period", "rigid"])
def test_and_so_do_they_for_a_finger_that_is_moved_from_outside(kind):
    f_a, run = replay(BUSY.evolve(KINDS[kind]), 4, motion=True)
    # Around a reversal tremor turns the speed apart from the stroke, and with it the sign of f_a: not that of f_m.
    np.testing.assert_array_equal(np.abs(f_a), np.abs(run["f_a"].values))
    f_a, run = replay(BUSY.evolve(KINDS[kind]).evolve({"motion.tremor_um": 0.0}), 4, motion=True)
    np.testing.assert_array_equal(f_a, run["f_a"].values)


@pytest.mark.parametrize("given", [{50}, set(range(40, 90)), set(range(0, 200, 3))], ids=["once", "a while", "often"])
def test_a_finger_that_is_let_go_moves_by_itself_again(given):
    """Where the caller moves it as it would have moved, nothing changes, then or later."""
    system = BUSY.evolve({"motion.tremor_um": 0.0})
    by_itself, moved = fl.Stepper(system, 3), fl.Stepper(system, 3)
    path = fl.simulate(system, DURATION_S, 3)[["position", "speed", "load"]].to_array().values.T
    for k in range(PERIODS - 1):
        motion = fl.Movement(*path[k + 1].tolist()) if k in given else None
        assert moved.tick(1.0 + 0.004 * k, motion) == by_itself.tick(1.0 + 0.004 * k)
        assert moved.force_n == by_itself.force_n


STEPPED = fl.bench().evolve(
    {**fl.RETUNED, "setpoint": fl.Steps(times_s=tuple(0.2 * k for k in range(10)), levels_n=(0.4, 0.7) * 5),
     "motion.stroke_mm": 12.0, "motion.contact_s": 1.2, "motion.lifted_s": 0.1, "motion.start": 0.1}
)  # fmt: skip


def test_sums_and_traces_give_the_same_numbers():
    fingers, metrics = [{"motion.person": p, "finger.slip_length_um": 11.5} for p in range(4)], list(fl.METRICS)
    sums = fl.sweep(STEPPED, fingers, 2.0, seeds=[7, 8], metrics=metrics)
    counted = 0
    for p, finger in enumerate(fingers):
        for seed in (7, 8):
            run = fl.simulate(STEPPED.evolve(finger), 2.0, seed)
            assert 0.3 < run["scored"].values.mean() < 0.95
            steps = fl.step_times(run)
            counted += len(steps)
            up, down = ([s for s in steps if (s.to_n > s.from_n) == rises] for rises in (True, False))
            kept = run["scored"].values.astype(bool)
            f_a, f_r = run["f_a"].values[kept], run["f_r"].values[kept]
            traces = {name: getattr(fl, name)(run) for name in metrics if hasattr(fl, name)} | {
                "slope": fl.regression(run).slope,
                **{name: fl.metrics(run)[name] for name in ("disturbance_left", *TURNS)},
                "mean_force": f_a.mean(),
                "mean_setpoint": f_r.mean(),
                "setpoint_spread": f_r.std(),
                "scored_periods": kept.sum(),
                "rise_63_s": np.mean([s.to_63_s for s in up]) if up else np.nan,
                "rise_10_90_s": np.mean([s.rise_s for s in up]) if up else np.nan,
                "fall_63_s": np.mean([s.to_63_s for s in down]) if down else np.nan,
                "fall_10_90_s": np.mean([s.rise_s for s in down]) if down else np.nan,
            }
            for name in metrics:
                got = float(sums[name].sel(point=p, seed=seed))
                assert got == pytest.approx(traces[name], rel=1e-9, abs=1e-9, nan_ok=True), name
    assert counted >= 16


def test_metrics_do_not_depend_on_tiles_or_workers():
    fingers, options = fl.fingers(40, seed=2), {"duration_s": 0.5, "seeds": [4, 1], "metrics": list(fl.METRICS)}
    system = STEPPED.evolve({"motion.stroke_mm": 6.0})
    many = fl.sweep(system, fingers, n_jobs=1, **options)
    assert fl.sweep(system, fingers, n_jobs=2, **options).identical(many)
    for k in (0, 17, 39):
        one = fl.sweep(system, [fingers[k]], **options)
        for name in fl.METRICS:
            np.testing.assert_array_equal(one[name].values[0], many[name].values[k], err_msg=name)


def test_runs_made_together_are_the_runs_alone():
    other = fl.bench().evolve({"sensor.kind": "lowpass"})  # of another structure, and too few to share a tile
    jobs = [(system, seed) for seed, system in enumerate(people("bristle", 4))]
    jobs.insert(2, (other, 7))
    found = simulate_all(jobs, DURATION_S, ("f_a", "saturated"), 0.02)
    assert len(found) == len(jobs)
    for (system, seed), run in zip(jobs, found, strict=True):
        single = fl.simulate(system, DURATION_S, seed)[["f_a", "saturated"]].isel(time=slice(100, None))
        assert run.identical(single)
