"""The whole firmware at a simulated bench, through the calls that a board on the desk takes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import frictionloop as fl

# Smooth and slow, so that two runs of the loop stay together whatever rounds: the plant of Section 2, PI of low gain.
SYSTEM = fl.paper().evolve(
    {
        "controller.kp": 0.5,
        "controller.ki": 40.0,
        "disturbance.kind": "constant",
        "disturbance.offset_n": 0.3,
        "setpoint.kind": "sine",
        "setpoint.offset_n": 0.6,
        "setpoint.amplitude_n": 0.1,
        "setpoint.frequency_hz": 2.0,
    }
)
HALF = 5e-5
"""N and um: half a step of the telemetry."""


@pytest.fixture
def device() -> Any:
    with fl.connect("sim:", SYSTEM) as found:
        yield found


def test_rows_are_the_ticks_of_the_bench(device: fl.Device) -> None:
    run = device.run(SYSTEM.setpoint, 0.5)
    # The same plant, driven with the amplitudes that were recorded, tick by tick from the first on.
    bench, commands = fl.Stepper(SYSTEM), np.concatenate([np.zeros(run.attrs["start_tick"]), run.a])
    measured, felt = [bench.measured.force], []
    for command in commands:
        measured.append(bench.tick(float(command)).force)
        felt.append(bench.force_n)
    at = slice(run.attrs["start_tick"], run.attrs["start_tick"] + run.sizes["time"])
    # Half a step of the amplitude is 2 tau a f0 5e-5 um, at most 1e-4 N; the converter has steps of 8e-5 N.
    np.testing.assert_allclose(run.f_m, measured[at], atol=HALF + 1e-4 + 4e-5)
    np.testing.assert_allclose(run.f_a, felt[at], atol=1e-4)


def test_the_firmware_does_what_the_simulation_does(device: fl.Device) -> None:
    run = device.run(SYSTEM.setpoint, 2.0, state="closed")
    simulated = fl.simulate(SYSTEM, 2.0)
    # The table plays from the moment it is asked for; the loop closes some ticks later.
    late = min(range(20), key=lambda k: float(np.abs(run.f_r.values[:200] - simulated.f_r.values[k : k + 200]).max()))
    rows, same = slice(5000, 9900), slice(5000 + late, 9900 + late)  # the clamp opens over 0.1 s
    # The points of the table are as far apart as the steps of the telemetry.
    np.testing.assert_allclose(run.f_r[rows], simulated.f_r[same], atol=2 * HALF + 1e-9)
    for name in ("f_a", "f_m", "u"):
        np.testing.assert_allclose(run[name].values[rows], simulated[name].values[same], atol=1e-3)


def test_a_run_carries_its_system_and_is_scored_like_any_other(device: fl.Device, tmp_path: Any) -> None:
    device.run(SYSTEM.setpoint, 1.0, path=tmp_path / "run.h5")
    run = fl.load(tmp_path / "run.h5")
    assert (run.attrs["source"], run.attrs["lost_samples"]) == ("simulated", 0)
    assert fl.system_of(run) == SYSTEM
    assert fl.system_of(device.run(0.4, 0.1)).setpoint == fl.Constant(offset_n=0.4)
    assert fl.rms_error(run) == pytest.approx(float(np.sqrt(np.mean((run.f_a - run.f_r) ** 2))))


def test_another_system_is_uploaded(device: fl.Device) -> None:
    device.upload(SYSTEM.evolve({"controller.kp": 0.25}))
    assert device.parameters["law.gains"][0] == 0.25
    assert fl.system_of(device.run(0.5, 0.1)).controller.kp == 0.25


def test_the_board_refuses_and_faults_by_name(device: fl.Device, tmp_path: Any) -> None:
    device.set("law.low_n", 0.9)
    device.set("law.high_n", 0.1)
    said = "^commit: refused, law.high_n = 0.1 N: must be above law.low_n = 0.9 N$"
    with pytest.raises(fl.DeviceError, match=said):
        device.commit()
    device.set("safety.force_limit_n", 0.001)
    device.commit()
    with pytest.raises(fl.Interrupted, match="fault force_range"):
        device.run(0.5, 1.0, path=tmp_path / "cut.h5")
    with pytest.raises(fl.DeviceError, match=r"^clear: the device refuses, still at fault$"):
        device.clear()


def test_a_finger_on_the_bench_is_felt_as_in_the_simulation() -> None:
    system = fl.bench().evolve(fl.RETUNED).evolve({"setpoint.kind": "constant", "setpoint.offset_n": 0.5})
    with fl.connect("sim:", system, seed=3) as device:
        run = device.run(0.5, 4.0)
    simulated = fl.simulate(system, 4.0, seed=3)
    assert run.attrs["dropped_samples"] == run.attrs["lost_samples"] == 0
    # The device tells what its sensors see, with 10 um and 2 mN of noise; its first tick, 1, is at t = 0.
    late = run.attrs["start_tick"] - 1
    for name, noise, step in (("position", 10e-6, 1e-5), ("load", 2e-3, 2e-4)):
        there, same = run[name].values[: 20000 - late], simulated[name].values[late:]
        np.testing.assert_allclose(there, same, atol=6 * noise + step)
    late = {"time": slice(1.0, None)}
    # The loop is as good on the board: the friction of the finger is the same, and the law is.
    errors = [float((x.f_a - x.f_r).where(x.sliding).sel(late).std()) for x in (run, simulated)]
    assert errors[0] == pytest.approx(errors[1], rel=0.1)
    assert float(run.sliding.mean()) == pytest.approx(float(simulated.sliding.mean()), abs=0.02)


def test_a_bench_whose_signals_are_over_ends_a_run_and_keeps_it(tmp_path: Any) -> None:
    sweep = {"kind": "log_sweep", "offset_n": 0.3, "start_hz": 1.0, "stop_hz": 10.0, "sweep_s": 0.5}
    system = SYSTEM.evolve({f"disturbance.{name}": value for name, value in sweep.items()})
    with (
        fl.connect("sim:", system) as device,
        pytest.raises(fl.Interrupted, match=r"disturbance.sweep_s = 0.5 s is over; \d+ samples are in"),
    ):
        device.run(0.5, 2.0, path=tmp_path / "cut.h5")
    assert 2000 < fl.load(tmp_path / "cut.h5").sizes["time"] <= 2500


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("law.hash", 9, "law.hash = 9: must be "),
        ("drive.ceiling_um", 5, "drive.ceiling_um = 5 um: must be at most drive.largest_um = 2.5 um"),
        ("drive.largest_um", 0, "drive.largest_um = 0 um: must be above 0 um"),
        ("drive.ramp_um", 2**-8, "drive.ramp_um = 0.00390625 um: must be at least 0.005 um"),
        ("lookup.squares_um2", [4, *[3] * 255, 3.5], "lookup.squares_um2[256] = 3.5 um^2: must be none above"),
    ],
)
def test_a_refused_table_is_said_by_name_and_limit(device: fl.Device, name: str, value: Any, said: str) -> None:
    device.set("lookup.entries", 257)
    device.set(name, value)
    with pytest.raises(fl.DeviceError) as refused:
        device.commit()
    assert str(refused.value).startswith(f"commit: refused, {said}")
    assert refused.value.reason == "out_of_range"


def test_a_board_that_is_wired_otherwise_tells_the_same_forces() -> None:
    wired = SYSTEM.evolve(
        {"board.force_zero_counts": (900, 0), "board.force_n_per_count": -6e-5, "board.ceiling_um": 0.9}
    )
    with fl.connect("sim:", wired) as device:
        run = device.run(SYSTEM.setpoint, 0.3)
        assert device.parameters["drive.ceiling_um"] == pytest.approx(0.9, abs=1e-8)
        device.upload(wired)
        assert device.parameters["drive.ceiling_um"] == pytest.approx(0.9, abs=1e-8)
    bench, commands = fl.Stepper(wired), np.concatenate([np.zeros(run.attrs["start_tick"]), run.a])
    measured = [bench.measured.force, *(bench.tick(float(command)).force for command in commands)]
    at = slice(run.attrs["start_tick"], run.attrs["start_tick"] + run.sizes["time"])
    np.testing.assert_allclose(run.f_m, measured[at], atol=HALF + 1e-4 + 3e-5)
    assert run.a.values.max() == pytest.approx(0.9, abs=HALF)


def test_a_run_has_as_many_samples_as_a_line_carries() -> None:
    """All channels of 16 samples are 278 bytes on the line: at 12.5 kHz 0.22 MB a second, where 2 Mbaud are 0.2."""
    for rate_hz, ticks in ((10_000.0, 1), (12_500.0, 2), (20_000.0, 2)):
        run = fl.device.run("sim:", SYSTEM.evolve({"controller.rate_hz": rate_hz}), 0.05)
        assert run.samples == math.ceil(0.05 * rate_hz / ticks) and run.lost_samples == 0
        assert [each.code for each in run.findings if each.code == "LINE-CARRIES"] == ["LINE-CARRIES"] * (ticks > 1)
