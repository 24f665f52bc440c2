"""An effect as the set-point: the kernel plays what the player plays, at the place that the controller knows of."""

from __future__ import annotations

import numpy as np
import pytest
from effect_trees import TREES
from hypothesis import HealthCheck, given, settings

import frictionloop as fl
from frictionloop.quantities import FrictionloopError

R = fl.rendering
CALM = {
    "motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "touch.position.noise_um": 0.0,
    "touch.load.noise_n": 0.0, "controller.kind": "notch_pi",
}  # fmt: skip


def bench(effect, **more):
    return fl.bench().evolve({"setpoint": {"kind": "effect", "effect": effect}, "controller.kind": "notch_pi", **more})


def replayed(run, effect, touches_n=1e-12):
    """What the player asks for along the true motion of a run."""
    system = fl.system_of(run)
    model = system.controller.model
    player, dt = R.Player(effect, band_n=(model.floor_n, model.nominal_n)), 1.0 / system.controller.rate_hz
    player.touches_n = touches_n
    x, v, load = (run[name].values for name in ("position", "speed", "load"))
    return np.array([player.tick(*map(float, each), dt) for each in zip(1e3 * x, 1e3 * v, load, strict=True)])


@pytest.mark.parametrize("name", list(R.LIBRARY))
def test_the_kernel_plays_what_the_player_plays(name):
    run = fl.simulate(bench(name, **{"motion.load_n": 0.65, "motion.load_drift": 0.3}), 0.5)
    assert np.abs(run["f_r_intended"].values - replayed(run, R.LIBRARY[name])).max() < 1e-9


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(TREES)
def test_the_kernel_plays_any_effect_within_the_band(effect):
    try:
        run = fl.simulate(bench(effect), 0.05)
    except FrictionloopError as error:
        assert "at most" in str(error) or "trigger" in str(error)
        return
    low, high = fl.clamp_of(fl.bench().controller.model)
    for trace in ("f_r", "f_r_intended"):
        assert np.all((run[trace].values >= low) & (run[trace].values <= high))
    assert np.abs(run["f_r_intended"].values - replayed(run, effect)).max() < 1e-9


def test_a_grating_in_the_loop_is_a_sine_in_time_with_the_right_phase_at_every_sample():
    system = bench(R.Grating(spacing_mm=2.0), **CALM, **{"motion.start": 0.25, "setpoint.position": "measured"})
    run = fl.simulate(system, 0.5)
    wanted = 0.45 + 0.15 * np.sin(2 * np.pi * 20.0 * run["time"].values / 2.0)
    assert np.abs(run["f_r"].values - wanted).max() < 1e-6
    assert np.abs(run["f_r_intended"].values - wanted).max() < 1e-6


def test_the_predicted_place_is_that_of_the_middle_of_the_commands_period():
    system = bench(R.Grating(spacing_mm=2.0), **CALM, **{"motion.start": 0.25})
    run = fl.simulate(system, 0.5)
    ahead_s = 200e-6 + 0.5 / 5000
    wanted = 0.45 + 0.15 * np.sin(2 * np.pi * 20.0 * (run["time"].values + ahead_s) / 2.0)
    assert np.abs(run["f_r"].values - wanted)[100:].max() < 1e-5


def test_the_noise_of_the_position_sensor_is_in_the_set_point():
    given = {"setpoint.position": "measured", "motion.start": 0.25, "motion.tremor_um": 0.0}
    run = fl.simulate(bench(R.Gradient(from_n=0.3, to_n=0.7, length_mm=40.0), **given), 0.5)
    error = run["f_r"].values - run["f_r_intended"].values
    assert np.std(error) == pytest.approx(0.01 * 0.4 / 40.0, rel=0.05)  # 10 um on 10 N/m
    predicted = fl.simulate(
        bench(R.Gradient(from_n=0.3, to_n=0.7, length_mm=40.0), **given | {"setpoint.position": "predicted"}), 0.5
    )
    steps = [np.std(np.diff(each["f_r"].values)) for each in (run, predicted)]
    assert steps[1] < 0.2 * steps[0]


def test_the_steps_of_the_position_sensor_are_in_the_set_point_and_the_prediction_smooths_them():
    """A step of q um on a slope of 10 N/m is a staircase: an error of 10 q/sqrt(12), and rises of 10 q between."""
    gradient = R.Gradient(from_n=0.3, to_n=0.7, length_mm=40.0)
    given = CALM | {"motion.start": 0.25, "motion.speed_mm_s": 80.0, "touch.position.resolution_um": 50.0}
    runs = {
        position: fl.simulate(bench(gradient, **given, **{"setpoint.position": position}), 0.2)
        for position in ("measured", "predicted")
    }
    error = (runs["measured"]["f_r"] - runs["measured"]["f_r_intended"]).values
    assert np.abs(error).max() <= 10 * 25e-6 * (1 + 1e-6)
    assert np.std(error) == pytest.approx(10 * 50e-6 / np.sqrt(12), rel=0.02)
    rises = {name: np.abs(np.diff(run["f_r"].values))[200:].max() for name, run in runs.items()}
    assert rises["measured"] == pytest.approx(10 * 50e-6, rel=1e-6)
    assert rises["predicted"] < 0.6 * rises["measured"]


def test_a_stepper_is_told_positions_on_the_steps():
    loop = fl.Stepper(bench("grating", **{"touch.position.resolution_um": 40.0}))
    places = np.array([loop.tick(0.0).position for _ in range(50)]) / 40e-6
    assert np.abs(places - np.round(places)).max() < 1e-9
    assert np.ptp(places) > 0


@pytest.mark.parametrize("speed", [20.0, 80.0, 150.0])
def test_the_predicted_place_is_the_better_one(speed):
    def error(position):
        run = fl.simulate(
            bench(
                "grating",
                **{"setpoint.position": position, "motion.speed_mm_s": speed, "controller.kind": "limit_observer"},
            ),
            3.0,
        )
        keep = run["scored"].values
        return np.sqrt(np.mean((run["f_a"].values - run["f_r_intended"].values)[keep] ** 2))

    assert error("predicted") < error("measured")


@pytest.mark.parametrize("kind", ["pi", "lookup", "filtered_pi", "notch_pi", "limit_observer"])
def test_every_law_takes_an_effect(kind):
    run = fl.simulate(bench("grating", **{"controller.kind": kind}), 0.2)
    assert np.all(np.isfinite(run["f_a"].values))
    assert np.ptp(run["f_r"].values) > 0.2


def test_a_sweep_gives_what_single_runs_give():
    system = bench("slider")
    fingers = fl.fingers(3, seed=1)
    swept = fl.sweep(system, fingers, duration_s=0.5, seeds=1, metrics=("rms_error", "mean_setpoint"))
    for number, finger in enumerate(fingers):
        run = fl.simulate(system.evolve(finger), 0.5, seed=0)
        assert float(swept["rms_error"][number, 0]) == pytest.approx(fl.rms_error(run), rel=1e-12)


def test_effects_can_be_swept_by_their_values():
    swept = fl.sweep(
        bench("grating"),
        {"setpoint.effect.spacing_mm": [1.0, 4.0], "setpoint.effect.amplitude_n": [0.05, 0.1]},
        duration_s=1.0,
        metrics=("setpoint_spread",),
    )
    spread = swept["setpoint_spread"].values[..., 0]
    assert np.allclose(spread[:, 1] / spread[:, 0], 2.0, rtol=0.02)


def test_a_run_with_an_effect_can_be_saved_and_repeated(tmp_path):
    run = fl.simulate(bench("bump"), 0.1)
    fl.save(run, tmp_path / "run.h5")
    again = fl.load(tmp_path / "run.h5")
    assert fl.system_of(again) == fl.system_of(run)
    repeated = fl.simulate(fl.system_of(again), 0.1)
    assert np.array_equal(repeated["f_r"].values, run["f_r"].values)
    assert run["f_r_intended"].attrs["units"] == "N"


def test_a_controller_outside_asks_the_player():
    system = bench("grating", **CALM)
    loop, player = fl.Stepper(system), R.Player(R.LIBRARY["grating"])
    seen = loop.measured
    for _ in range(200):
        force = player.tick(1e3 * seen.position, 1e3 * seen.speed, seen.load, 2e-4)
        seen = loop.tick(float(fl.amplitude_for(force, system.friction)) if force < 0.8 else 0.0)
    assert 0.3 <= force <= 0.6


def test_a_system_with_an_effect_goes_through_a_file(tmp_path):
    system = bench(R.LIBRARY["slider"] + R.LIBRARY["button"])
    fl.write_toml(system, tmp_path / "bench.toml")
    assert fl.read_toml(tmp_path / "bench.toml") == system
    (tmp_path / "short.toml").write_text('preset = "bench"\n[setpoint]\nkind = "effect"\neffect = "bump"\n')
    assert fl.read_toml(tmp_path / "short.toml").setpoint.effect == R.LIBRARY["bump"]


def test_a_linear_analysis_looks_at_the_mean_of_an_effect():
    found = fl.linearise(bench("grating")).elements.force_n
    assert found == pytest.approx(0.45 - fl.bench().disturbance.offset_n, abs=1e-3)


@pytest.mark.parametrize("level", [-50.0, 50.0])
def test_nothing_reaches_the_plate_above_its_ceiling_whatever_an_effect_says(level):
    wild = R.Grating(offset_n=level, amplitude_n=100.0, shape="square", spacing_mm=0.5) * level
    run = fl.simulate(bench(wild), 0.5)
    system = fl.system_of(run)
    low, high = fl.clamp_of(system.controller.model)
    assert run["a"].values.min() >= 0.0
    assert run["a"].values.max() <= system.plate.max_amplitude_um
    assert np.all((run["f_r"].values >= low) & (run["f_r"].values <= high))
