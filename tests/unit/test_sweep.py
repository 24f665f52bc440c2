"""Many runs at once: what the result looks like, and that every number is that of the run alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.loop import sweep as sweep_module
from frictionloop.loop.companion_runs import TURNS

BASE = fl.paper().evolve({"setpoint.sweep_s": 0.1, "sensor.noise_rms_n": 1e-3})
DURATION_S = 0.06
SCORES = {
    "r2_identity": fl.r2_identity,
    "r2_regression": fl.r2_regression,
    "rms_error": fl.rms_error,
    "saturation_index": fl.saturation_index,
    "output_noise": fl.output_noise,
    "r2_bound": fl.r2_bound,
}
STEP_METRICS = {"rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s"}
MOMENTS = {"mean_force", "mean_setpoint", "setpoint_spread", "scored_periods"}
NEWTONS = {"rms_error", "rms_error_turns", "turn_peak", "output_noise", *MOMENTS} - {"scored_periods"}


def test_a_grid_has_a_dim_per_path_and_seeds_last():
    grid = fl.sweep(BASE, {"controller.kp": [1.0, 10.0], "controller.ki": [0.0, 2.0, 20.0]}, DURATION_S, seeds=4)
    assert set(grid.data_vars) == {"r2_identity", "rms_error", "saturation_index"}
    for name in grid.data_vars:
        assert grid[name].dims == ("controller.kp", "controller.ki", "seed")
        assert grid[name].shape == (2, 3, 4)
        assert grid[name].dtype == float
        assert not grid[name].isnull().any()
    assert grid["controller.kp"].values.tolist() == [1.0, 10.0]
    assert grid["controller.ki"].attrs["units"] == "1/s"
    assert grid["seed"].values.tolist() == [0, 1, 2, 3]
    assert grid["rms_error"].attrs["units"] == "N"
    assert fl.system_of(grid) == BASE
    assert grid.attrs["duration_s"] == DURATION_S
    assert grid.attrs["source"] == "simulated"


def test_every_metric_has_a_unit_and_a_name():
    stepped = BASE.evolve({"setpoint": fl.Steps(times_s=(0.0, 0.02), levels_n=(0.5, 0.7))})
    grid = fl.sweep(stepped, {"controller.kp": [1.0]}, DURATION_S, metrics=list(fl.METRICS))
    assert list(grid.data_vars) == list(fl.METRICS)
    others = {"slope", "perceptual_index", "disturbance_left", *TURNS, *STEP_METRICS, *MOMENTS}
    assert set(SCORES) | others == set(fl.METRICS)
    for name in fl.METRICS:
        assert grid[name].attrs["units"] == ("s" if name in STEP_METRICS else "N" if name in NEWTONS else "1")
        assert grid[name].attrs["long_name"]


def test_a_list_of_points():
    points = [{"controller.kp": 1.0}, {"controller.kp": 2.0, "friction.nominal_n": 0.9}, {}]
    grid = fl.sweep(BASE, points, DURATION_S, seeds=[7, 3])
    assert grid["rms_error"].dims == ("point", "seed")
    assert grid["point"].values.tolist() == [0, 1, 2]
    assert grid["seed"].values.tolist() == [7, 3]
    np.testing.assert_array_equal(grid["controller.kp"].values, [1.0, 2.0, np.nan])
    assert grid["friction.nominal_n"].dims == ("point",)
    assert grid["friction.nominal_n"].attrs["units"] == "N"


def test_a_list_may_name_its_dim():
    class Fingers(list):
        dim = "finger"

    grid = fl.sweep(BASE, Fingers([{"friction.nominal_n": 0.7}, {"friction.nominal_n": 0.9}]), DURATION_S)
    assert grid["rms_error"].dims == ("finger", "seed")


def test_values_may_be_arrays_scalars_or_words():
    grid = fl.sweep(BASE, {"controller.kp": np.float32([1, 2]), "controller.ki": 2.0, "plate.kind": "lowpass"}, 0.01)
    assert grid["rms_error"].shape == (2, 1, 1, 1)
    assert grid["plate.kind"].values.tolist() == ["lowpass"]


STRUCTURAL = {
    "kinds": {"disturbance.kind": ["sine", "constant", "noise"], "disturbance.offset_n": [0.1, 0.3]},
    "delays": {"controller.delay_s": [0.0, 50e-6, 200e-6, 330e-6, 0.002]},
    "rates": {"controller.rate_hz": [1000.0, 5000.0, 20000.0]},
    "table sizes": {"controller.model.table_size": [0, 2, 64]},
    "plates": {"plate.cutoff_hz": [10.0, 100.0, 700.0, 2000.0]},
    "sensors": {"sensor.cutoff_hz": [50.0, 1000.0, 30000.0], "sensor.noise_rms_n": [0.0, 1e-2]},
}


@pytest.mark.parametrize("name", STRUCTURAL)
def test_every_number_of_a_sweep_is_that_of_the_run_alone(name):
    grid = fl.sweep(BASE, STRUCTURAL[name], DURATION_S, seeds=[0, 5], metrics=list(SCORES))
    stacked = grid.stack(run=grid["rms_error"].dims)
    assert stacked.sizes["run"] == 2 * np.prod([len(values) for values in STRUCTURAL[name].values()])
    for k in range(stacked.sizes["run"]):
        one = stacked.isel(run=k)
        overrides = {path: one[path].values.item() for path in STRUCTURAL[name]}
        run = fl.simulate(BASE.evolve(overrides), DURATION_S, int(one["seed"]))
        for metric, score in SCORES.items():
            # Sums in another order, and squares of differences (test_metrics): 1e-9 of the metric.
            assert float(one[metric]) == pytest.approx(score(run), rel=1e-9, abs=1e-9), (metric, overrides)


def test_scoring_may_start_late():
    grid = fl.sweep(BASE, [{}], DURATION_S, metrics=list(SCORES), score_from_s=0.02)
    run = fl.simulate(BASE, DURATION_S)
    for metric, score in SCORES.items():
        late = score(run, run["time"].values > 0.02 - 1e-9)
        assert float(grid[metric].squeeze()) == pytest.approx(late, rel=1e-9, abs=1e-9)
        assert metric == "r2_bound" or late != score(run)  # nothing to clip here


def complaint(points, *arguments, **options):
    with pytest.raises(fl.FrictionloopError) as failure:
        fl.sweep(BASE, points, *arguments, **options)
    assert "\n" not in str(failure.value)
    return str(failure.value)


KPS = {"controller.kp": [1.0, 2.0]}


@pytest.mark.parametrize(
    ("points", "options"),
    [
        ({"controller.kpp": [1.0]}, {}),
        ({"controller.kp": [1.0, 2.0, -3.0]}, {}),
        ({"plate.cutoff_hz": [100.0, 1e6]}, {}),
        (KPS, {"metrics": ["rms_error", "rise_63_s"]}),
        (KPS, {"seeds": [1, 1]}),
        (KPS, {"score_from_s": 0.00995}),
    ],
)
def test_bad_input_is_refused_before_anything_runs(points, options, monkeypatch):
    monkeypatch.setattr("frictionloop.loop.sweep.run_tile", lambda *_: pytest.fail("something has run"))
    assert complaint(points, 0.01, **options)


def test_an_unwritable_file_is_refused_before_anything_runs(tmp_path, monkeypatch):
    monkeypatch.setattr("frictionloop.loop.sweep.run_tile", lambda *_: pytest.fail("something has run"))
    assert "cannot be written" in complaint(KPS, 0.01, path=tmp_path / "nowhere" / "sweep.h5")


def test_a_progress_bar_on_demand(capsys):
    fl.sweep(BASE, KPS, 0.01, progress=True)
    assert "sweep" in capsys.readouterr().err
    fl.sweep(BASE, KPS, 0.01)
    assert capsys.readouterr() == ("", "")  # not on a terminal: silence


def test_the_result_is_a_plain_dataset():
    assert type(fl.sweep(BASE, KPS, 0.01)) is xr.Dataset


@pytest.mark.parametrize(("tile_s", "savings"), [(0.1, [0, 4]), (4.0, [0, 2, 4, 4]), (60.0, [0, 1, 2, 3, 4, 4])])
def test_what_is_done_is_kept_by_time_at_the_end_of_a_tile(monkeypatch, tile_s, savings):
    """Before, at the end, and between whenever 5 s have gone: a tile of a bench may take minutes."""
    kept, tiles = [], []
    run_tile = sweep_module.run_tile
    monkeypatch.setattr(sweep_module, "run_tile", lambda *given: (run_tile(*given), tiles.append(given)))
    monkeypatch.setattr("frictionloop.loop.sweep_checkpoint.Result.keep", lambda result: kept.append(len(tiles)))
    rates = {"controller.rate_hz": [50_000.0, 25_000.0, 20_000.0, 10_000.0]}  # a tile each
    fl.sweep(BASE, rates, 0.02, n_jobs=1, clock=lambda: tile_s * len(tiles))
    assert kept == savings


# The best point of a sweep, whether its loop rings, and what has no value.


def codes(found):
    return {each.code for each in found.findings}


@pytest.mark.parametrize(
    ("metric", "at"),
    [
        ("rms_error", 0),
        ("saturation_index", 0),
        ("perceptual_index", 0),
        ("r2_identity", 3),
        ("slope", 1),
        ("r2_bound", 3),
    ],
)
def test_best_is_the_smallest_the_largest_or_the_nearest_to_one(metric, at):
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01, metrics=[metric])
    result[metric][:] = np.array([[0.5], [1.2], [0.7], [1.4]])
    best = fl.best(result).best[metric]
    assert best.point == {"controller.kp": at + 1}
    assert best.at_end == (("controller.kp",) if at != 1 else ())
    assert best.others == 0


def test_equal_points_are_counted():
    result = fl.sweep(fl.feasible(), {"controller.kp": [1, 2, 3, 4]}, 0.01)
    result["saturation_index"][:] = np.array([[0.5], [0.0], [0.0], [np.nan]])
    best = fl.best(result).best["saturation_index"]
    assert (best.point, best.others, best.at_end) == ({"controller.kp": 2}, 1, ())


def test_points_that_ring_are_told_by_their_margins():
    """The ultimate gain tells which proportional gains are stable, whatever the metrics of so short a run."""
    bench = fl.bench().evolve({"controller.kind": "pi", "controller.ki": 1.0})
    kps = [share * fl.kp_limit(bench) for share in (0.1, 3.0)]
    found = fl.best(fl.sweep(bench, {"controller.kp": kps}, 0.1))
    calm, rings = found.peaks
    assert 1.0 < calm < 2.0 and math.isinf(rings)
    assert found.to_dict()["stable"] == [True, False]
    assert found.table("points")["Ms"].tolist() == [calm, rings]


def test_a_best_point_that_rings_is_a_warning():
    found = fl.best(fl.sweep(fl.feasible(), {"controller.kp": [200.0, 201.0]}, 0.1, metrics=["rms_error"]))
    (told,) = (each for each in found.findings if each.code == "BEST-RINGS")
    assert told.remedy == found.best["rms_error"].point and math.isinf(told.value)


def test_many_points_are_not_listed_and_the_best_at_an_end_is_told():
    kps = np.linspace(1.0, 2.0, 15)
    found = fl.best(fl.sweep(fl.feasible(), {"controller.kp": kps}, 0.5, metrics=["rms_error"]))
    assert found.peaks is None and list(found.tables()) == ["best"]
    (told,) = (each for each in found.findings if each.code == "BEST-AT-END")
    assert told.value == {"controller.kp": 2.0}


def test_a_metric_without_any_value_is_told_and_the_sweep_is_complete():
    constant = {"setpoint.kind": "constant", "setpoint.offset_n": 0.5}
    found = fl.best(
        fl.sweep(fl.feasible().evolve(constant), {"controller.kp": [1.0, 2.0]}, 0.1, metrics=["r2_identity"])
    )
    assert found.complete and found.best == {}
    assert "METRIC-NONE" in codes(found) and "STOPPED" not in codes(found)


def test_points_of_a_list_and_words():
    listed = fl.best(fl.sweep(fl.feasible(), [{"controller.kp": 2.0}, {"controller.kp": 500.0}], 0.1))
    assert math.isfinite(listed.peaks[0]) and math.isinf(listed.peaks[1])
    words = fl.best(fl.sweep(fl.feasible(), {"setpoint.kind": ["log_sweep", "constant"]}, 0.1))
    assert words.best["r2_identity"].point == {"setpoint.kind": "log_sweep"}
