"""The firmware's controller inside the simulator: `controller.form = "firmware"`."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl

FORM = {"controller.form": "firmware"}


def both(system, **run):
    return fl.simulate(system, **run), fl.simulate(system.evolve(FORM), **run)


def test_where_the_loop_is_not_chaotic_it_is_the_same_loop():
    """On the reachable signals of Section 2 what fixed point rounds away dies out."""
    floating, fixed = both(fl.feasible(), duration_s=2.0)
    assert float(np.abs(floating.f_a - fixed.f_a).max()) < 0.4e-3  # 0.2 mN each of command and amplitude
    assert np.array_equal(floating.f_r, fixed.f_r)


def test_on_the_bench_it_leaves_as_much():
    floating, fixed = both(fl.bench(), duration_s=4.0, seed=3)
    assert fl.rms_error(fixed) == pytest.approx(fl.rms_error(floating), rel=0.02)


def test_lanes_of_a_sweep_have_states_of_their_own():
    """A lane in a grid has the bits of the same point alone."""
    system, gains, options = fl.feasible().evolve(FORM), [2.0, 5.0, 10.0], {"duration_s": 0.5}
    grid = fl.sweep(system, {"controller.kp": gains}, **options)
    alone = [fl.sweep(system, {"controller.kp": [kp]}, **options) for kp in gains]
    assert np.array_equal(grid.rms_error.to_numpy().ravel(), [one.rms_error.item() for one in alone])
    assert len(np.unique(grid.rms_error)) == len(gains)


def test_a_lost_tick_keeps_command_and_state():
    runs = both(fl.feasible().evolve({"controller.lost_ticks": 0.5}), duration_s=0.5)
    floating, fixed = (np.diff(run.u.to_numpy()) == 0 for run in runs)
    assert 0.4 < fixed.mean() < 0.6
    assert np.mean(floating == fixed) > 0.99  # the same ticks; a command may also happen to stay


@pytest.mark.parametrize("law", ["pi", "notch_pi", "limit_observer"])
def test_it_is_opened_and_closed_alike(law):
    """What fixed point rounds away is all there is between them until the loop has closed; then it is a loop."""
    changed = {"controller.kind": law, "controller.open_until_s": 0.5, "setpoint.amplitude_n": 0.0}
    changed |= fl.RETUNED if law == "pi" else {}
    floating, fixed = both(fl.bench().evolve(changed), duration_s=1.5, seed=1)
    apart = np.abs(floating.u - fixed.u).to_numpy()
    assert apart[:2500].max() < 4e-9  # a step of 2^-28 N, and the set-point's
    assert apart[2500:2510].max() < 0.4e-3
    assert np.array_equal(floating.saturated[:2500], fixed.saturated[:2500])
    late = {"time": slice(1.0, None)}
    assert fl.rms_error(fixed.sel(late)) == pytest.approx(fl.rms_error(floating.sel(late)), rel=0.05)


def test_it_is_in_the_file(tmp_path):
    path = tmp_path / "run.h5"
    fl.save(fl.simulate(fl.feasible().evolve(FORM), duration_s=0.1), path)
    assert '"form":"firmware"' in fl.load(path).attrs["system"].replace(" ", "")


# The C core closing the loop around the plant of the bench, against the simulator's float64 loop, by statistics.


MODEL = fl.bench().controller.model
SYSTEMS = {
    "pi retuned": fl.bench().evolve(fl.RETUNED),
    "notch, fed forward and overdriven": fl.bench().evolve(
        {"controller": fl.NotchPiController(delay_s=200e-6, feedforward=True, overdrive=True, model=MODEL)}
    ),
    "limit observer": fl.bench().evolve({"controller.kind": "limit_observer"}),
    "lookup": fl.bench().evolve({"controller": fl.LookupController(delay_s=200e-6, model=MODEL)}),
}
PERIODS, SEED = 10_000, 8


def closed_by_firmware(parity, system, setpoints):
    """Friction force at each sample."""
    law, loop, forces = parity.FixedLaw(system.controller), fl.Stepper(system, seed=SEED), np.empty(len(setpoints))
    told = np.rint(setpoints * 2.0**28).astype(np.int32)
    for k in range(len(setpoints)):
        forces[k] = loop.force_n
        rows, _ = parity.quantised(np.array([loop.measured]), setpoints[k : k + 1])
        command = law.run(rows[0], told[k : k + 1])[0, 2]
        loop.tick(command / 2.0**28)
    return forces


@pytest.mark.parametrize("name", SYSTEMS)
def test_residual_is_that_of_the_float64_loop(parity, name):
    system = SYSTEMS[name]
    run = fl.simulate(system, duration_s=PERIODS / 5000.0, seed=SEED)
    setpoints = run["f_r"].values.astype(float)
    forces = closed_by_firmware(parity, system, setpoints)
    scored = run["sliding"].values
    residuals = [np.sqrt(np.mean((f_a - setpoints)[scored] ** 2)) for f_a in (forces, run["f_a"].values)]
    assert residuals[0] == pytest.approx(residuals[1], rel=0.02)
