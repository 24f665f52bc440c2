"""A run has the same bits alone, in a tile of others, in any lane, with any company, in any chunks, on any threads."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop import simulate as simulate_module
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.kernel.traces import TRACES
from frictionloop.loop.simulate import run_tile
from frictionloop.quantities.counter_noise import normals

PERIODS = 333  # not a whole number of blocks of 32
DURATION_S = PERIODS / 5000.0
BASE = fl.paper().evolve({"setpoint.sweep_s": 0.1, "sensor.noise_rms_n": 1e-3})
KINDS = {
    "sweep and sine": {},
    "constants": {"setpoint": fl.Constant(offset_n=0.5), "disturbance": fl.Constant(offset_n=0.1)},
    "steps": {
        "setpoint": fl.Steps(times_s=(0.0, 0.01), levels_n=(0.3, 0.6)),
        "disturbance": fl.Steps(times_s=(0.0, 0.02), levels_n=(0.2, 0.1)),
    },
    "coloured noise": {
        "setpoint": fl.ColouredNoise(offset_n=0.6, rms_n=0.1),
        "disturbance": fl.ColouredNoise(offset_n=0.2, rms_n=0.1, exponent=2.0),
    },
    "a table": {"controller.model.table_size": 40},
    "a delay within the period": {"controller.delay_s": 70e-6},
    "whole delays": {"controller.delay_s": 400e-6},
    "a fast plate": {"plate.cutoff_hz": 900.0},
}


def varied(kind, count):
    """Return systems of one structure in which every lane differs in everything a lane may differ in."""
    random = np.random.default_rng(1)

    def around(value):
        return float(value * random.uniform(0.8, 1.2))

    systems = []
    for _ in range(count):
        overrides = {
            "friction.nominal_n": around(0.8),
            "friction.susceptibility_per_um2": around(0.38),
            "plate.max_amplitude_um": around(2.5),
            "sensor.cutoff_hz": around(1000.0),
            "sensor.noise_rms_n": around(1e-3),
            "controller.kp": around(15.0),
            "controller.ki": around(50.0),
            "controller.model.nominal_n": around(0.8),
            "controller.model.susceptibility_per_um2": around(0.38),
        }
        system = BASE.evolve(KINDS[kind]).evolve(overrides)
        if system.controller.delay_s:
            system = system.evolve(
                {"controller.delay_s": around(system.controller.delay_s)} if "within" in kind else {}
            )
        if system.disturbance.kind == "sine":
            system = system.evolve({"disturbance.frequency_hz": around(11.0), "setpoint.stop_hz": around(100.0)})
        systems.append(system)
    return systems


def alone(system, seed):
    run = fl.simulate(system, DURATION_S, seed)
    return np.array([run[name].values for name in TRACES])


def together(systems, seeds):
    """Return the traces of one tile, shape (lanes, variables, periods)."""
    traces = np.empty((len(TRACES), PERIODS, LANES))
    run_tile(lower(systems, seeds, traces=traces.reshape(-1)), PERIODS)
    return np.moveaxis(traces, 2, 0)[: len(systems)]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_every_lane_of_a_full_tile_is_the_run_alone(kind):
    systems, seeds = varied(kind, LANES), list(range(LANES))
    for lane, got in enumerate(together(systems, seeds)):
        np.testing.assert_array_equal(got, alone(systems[lane], seeds[lane]), err_msg=f"lane {lane}")


@pytest.mark.parametrize("kind", KINDS)
def test_neither_lane_nor_company_nor_padding_matters(kind):
    systems = varied(kind, 5)
    seeds = [3, 3, 2**40, 0, 2**64 - 1]
    first = together(systems, seeds)
    order = [4, 2, 0, 1, 3]
    again = together([systems[i] for i in order], [seeds[i] for i in order])
    np.testing.assert_array_equal(again, first[order])
    crowd = together([systems[0], *varied(kind, LANES)[5:], systems[1]], [3, *range(LANES - 5), 3])
    np.testing.assert_array_equal(crowd[0], first[0])
    np.testing.assert_array_equal(crowd[-1], first[1])


@pytest.mark.parametrize("kind", KINDS)
def test_what_all_lanes_share_is_computed_as_for_one(kind):
    """Equal signals and seeds take other paths through the kernel: one column for all lanes."""
    system = BASE.evolve(KINDS[kind])
    gains = [system.evolve({"controller.kp": float(kp)}) for kp in range(1, 8)]
    for got, one in zip(together(gains, [9] * 7), gains, strict=True):
        np.testing.assert_array_equal(got, alone(one, 9))


@pytest.mark.parametrize("chunk", [32, 64, 320, 2048])
@pytest.mark.parametrize("kind", KINDS)
def test_any_chunks_of_time(kind, chunk, monkeypatch):
    system = varied(kind, 1)[0]
    whole = alone(system, 5)
    monkeypatch.setattr(simulate_module, "CHUNK", chunk)
    np.testing.assert_array_equal(alone(system, 5), whole)


STEP_METRICS = ["rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s"]  # refused without steps to follow
METRICS = [name for name in fl.METRICS if name not in STEP_METRICS]


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_metrics_of_a_sweep_do_not_depend_on_tiles_or_workers(kind):
    systems = varied(kind, 1)
    kps = [0.5, 1.0, 3.0, 10.0, 40.0, 60.0, 1.5]
    metrics = METRICS + STEP_METRICS * (systems[0].setpoint.kind == "steps")
    options = {"duration_s": DURATION_S, "seeds": [4, 0, 7], "metrics": metrics, "score_from_s": 0.01}
    grid = fl.sweep(systems[0], {"controller.kp": kps}, n_jobs=1, **options)
    assert fl.sweep(systems[0], {"controller.kp": kps}, n_jobs=2, **options).identical(grid)
    for kp in kps:  # a tile of three lanes
        one = fl.sweep(systems[0], {"controller.kp": [kp]}, n_jobs=1, **options)
        assert one.identical(grid.sel({"controller.kp": [kp]}).assign_attrs(one.attrs))
    options["seeds"] = [7]
    single = fl.sweep(systems[0], [{"controller.kp": 3.0}], **options)  # a lane alone
    for name in metrics:
        expected = grid[name].sel({"controller.kp": 3.0, "seed": 7}).values
        np.testing.assert_array_equal(single[name].values.ravel(), expected, err_msg=name)


def test_no_two_seeds_are_alike():
    runs = [alone(BASE, seed)[TRACES.index("f_m")] for seed in (0, 1, 2**32, 2**63)]
    assert len({run.tobytes() for run in runs}) == len(runs)
    quiet = BASE.evolve({"sensor.noise_rms_n": 0.0})
    np.testing.assert_array_equal(alone(quiet, 0), alone(quiet, 1))


def test_recordings_in_one_tile(tmp_path):
    """Each lane follows its own column, also when the lanes' nodes differ."""
    path = tmp_path / "forces.csv"
    np.savetxt(path, 0.1 + 0.1 * normals(0, 9, 0, 800).reshape(400, 2), delimiter=",")
    systems = [
        BASE.evolve(
            {
                "disturbance": fl.Recording(path=str(path), column=str(k % 2), rate_hz=5000.0, scale=1.0 + 0.1 * k),
                "setpoint": fl.Recording(path=str(path), column="0", rate_hz=5000.0, offset_n=0.3),
                "controller.delay_s": delay_s,
            }
        )
        for k, delay_s in enumerate([10e-6, 10e-6, 90e-6, 150e-6])
    ]
    for got, one in zip(together(systems, [1, 2, 3, 4]), systems, strict=True):
        np.testing.assert_array_equal(got, alone(one, systems.index(one) + 1))
