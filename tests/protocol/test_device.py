"""The device as its user sees it, against a board made of Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.device import Device
from frictionloop.device.device_run import Interrupted
from frictionloop.device.errors import Refused
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities.protocol_schema import parameter_words, schema, word_count


@pytest.fixture
def board(boards: Any) -> Any:
    return boards.Board()


@pytest.fixture
def device(boards: Any, board: Any) -> Any:
    with Device(lambda: boards.Line(board)) as found:
        yield found


def test_who_answers(device: Device) -> None:
    assert (device.info.board, device.info.revision, device.info.serial) == ("host", "1.2", 77)
    assert device.statistics()["longest_us"] == 1.5


def test_parameters_are_read_and_written_in_their_units(device: Device, board: Any) -> None:
    device.set("setpoint.hold_n", 0.5)
    device.set("touch.n_per_count", 1.5e-4)
    device.set("force.zero_counts", [-3, 4])
    assert device.parameters["setpoint.hold_n"] == 0.0  # it waits
    device.commit()
    assert device.parameters["setpoint.hold_n"] == 0.5
    assert device.parameters["touch.n_per_count"] == 1.5e-4
    assert device.parameters["force.zero_counts"].tolist() == [-3, 4]
    assert board.words[parameter_words()["setpoint.hold_n"].first] == 0.5
    assert device.parameters.about("touch.n_per_count").unit == "N"
    assert len(device.parameters) == len(list(device.parameters)) == len(parameter_words())


def test_gains_are_set_by_the_names_of_a_system() -> None:
    with fl.connect("sim:") as device:
        device.set("controller.kp", 12)
        assert device.controller.kp == 10.0  # it waits
        device.set("controller.ki", 3.0)
        device.commit()
        assert (device.system.controller.kp, device.system.controller.ki) == (12.0, 3.0)
        assert device.parameters.hold(firmware_words(device.system))
        with pytest.raises(fl.FrictionloopError, match=r"^controller.kp = -1.0 N/N: must be"):
            device.set("controller.kp", -1.0)
        device.commit()
        assert device.controller.kp == 12.0


def test_gains_of_a_device_that_nobody_described_are_those_it_tells(device: Device) -> None:
    device.parameters.write(firmware_words(fl.bench()))
    device.commit()
    assert device.system is None
    assert (device.controller.kp, device.controller.ki) == (10.0, 2.0)
    device.set("controller.kp", 12)
    device.set("drive.ceiling_um", 2.0)
    device.commit()
    assert device.parameters["law.gains"][:2] == pytest.approx([12.0, 2.0])
    assert (device.controller.kp, device.controller.ki) == (12.0, 2.0)
    with pytest.raises(fl.FrictionloopError, match=r"^controller.overdrive: accepted controller.kp"):
        device.set("controller.overdrive", True)
    device.set("law.hash", 0)
    device.commit()
    with pytest.raises(fl.FrictionloopError, match=r"^law = 'lookup': must be pi"):
        device.set("controller.kp", 1.0)


def test_what_another_host_left_waiting_is_written_over(device: Device, board: Any) -> None:
    board.waiting[:] = 5
    device.set("law.hash", 2)
    device.commit()
    wanted = np.zeros(word_count())
    wanted[0] = 2
    np.testing.assert_array_equal(board.words, wanted)


def test_another_version_and_another_table_are_refused(boards: Any) -> None:
    major = schema()["protocol"]["major"]
    words = f"^device: protocol {major + 1}.0, must be {major}.x$"
    with pytest.raises(fl.DeviceError, match=words):
        Device(lambda: boards.Line(boards.Board(major=major + 1)))
    other = Device(lambda: boards.Line(boards.Board(hash_of_table=5)))
    with pytest.raises(fl.DeviceError, match="layout 00000005: must be"):
        other.set("setpoint.hold_n", 0.5)


def test_what_says_nothing_is_no_device(boards: Any, board: Any) -> None:
    board.receive = lambda data: None
    with pytest.raises(fl.DeviceError, match="no answer in frictionloop's protocol"):
        Device(lambda: boards.Line(board))


def test_set_points_over_time_and_position(device: Device, board: Any) -> None:
    device.play(np.linspace(0, 1, 300), spacing_s=1e-3)
    assert (board.played["source"], board.played["count"], board.played["step"]) == (1, 300, round(2**24 / 5))
    np.testing.assert_array_equal(board.points[:300], np.rint(np.linspace(0, 1e4, 300)))
    device.play([0.1, 0.2], spacing_m=1e-3, start_m=-0.01, loop=True)
    assert board.played == board.played | {"source": 2, "loops": 1, "step": round(2**24 / 1e3), "start_um": -10000}


def test_a_run_has_the_form_of_a_simulated_one(device: Device, board: Any, tmp_path: Any) -> None:
    run = device.run(fl.Sine(offset_n=0.5, amplitude_n=0.2, frequency_hz=2.0), 1.0, path=tmp_path / "run.h5")
    simulated = fl.simulate(fl.bench(), duration_s=0.1)
    assert run.sizes["time"] == 5000
    assert run.attrs["lost_samples"] == run.attrs["gaps"] == 0
    for name in run.data_vars:
        if name in simulated:
            # No board measures what the plate does: `a` is what it was told to do.
            told = {"long_name": "amplitude command, zero-to-peak"} if name == "a" else {}
            assert run[name].attrs == simulated[name].attrs | told
            assert run[name].dtype == simulated[name].dtype
    assert run.time.attrs == simulated.time.attrs
    np.testing.assert_allclose(run.time, np.arange(5000) / 5000)
    assert run.attrs["source"] == "simulated"
    kept = fl.load(tmp_path / "run.h5")
    np.testing.assert_array_equal(kept.f_m, run.f_m)
    assert kept.attrs["revision"] == "1.2"
    assert (board.played["loops"], board.played["step"]) == (1, round(2**24 * 1024 * 2 / 5000))
    assert board.state == 0
    assert board.decimation == 0


def test_a_fault_ends_a_run_and_keeps_what_was_recorded(device: Device, board: Any, tmp_path: Any) -> None:
    def later(rows: int) -> None:
        if rows > 1000:
            board.raise_fault("force_range")

    with pytest.raises(Interrupted, match=r"^fault force_range at tick \d+: .*: 7 N; \d+ samples are in") as ended:
        device.run(0.5, 2.0, path=tmp_path / "cut.h5", progress=later)
    assert ended.value.code == "FAULT-FORCE-RANGE"
    kept = fl.load(tmp_path / "cut.h5")
    assert 1000 < kept.sizes["time"] < 1200
    assert kept.attrs["lost_samples"] == 0
    with pytest.raises(Refused, match=r"^mode \(state = 2\): the device refuses, not now$"):
        device.mode("closed")
    with pytest.raises(fl.DeviceError, match=r"^fault force_range: clear\(\) it first$"):
        device.run(0.5, 1.0)
    device.clear()
    device.mode("closed")


def test_an_unplugged_device_ends_a_run_and_keeps_it_in_a_file(
    boards: Any, board: Any, tmp_path: Any, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("frictionloop.device.device_run.PAUSE_S", 0.0)
    lines: list[Any] = []

    def opened() -> Any:
        if lines and not there:
            raise fl.DeviceError("no such port")
        lines.append(boards.Line(board))
        return lines[-1]

    there = True
    device = Device(opened)

    def pulled(rows: int) -> None:
        nonlocal there
        if rows > 1000:
            lines[-1].is_open = there = False

    with pytest.raises(Interrupted, match=r"unplugged; \d+ samples are in interrupted-run.h5") as ended:
        device.run(0.5, 2.0, progress=pulled)
    kept = fl.load("interrupted-run.h5")
    assert kept.sizes["time"] == ended.value.run.sizes["time"] > 1000
    there, board.state, board.fault = True, 0, 0
    device.reconnect()
    assert device.run(0.5, 0.1).sizes["time"] == 500


def test_a_device_that_stops_talking_ends_a_run(device: Device, board: Any, tmp_path: Any) -> None:
    def later(rows: int) -> None:
        if rows > 1000:
            board.say = lambda name, **fields: None

    with pytest.raises(Interrupted, match="no telemetry for 2 s"):
        device.run(0.5, 2.0, path=tmp_path / "cut.h5", progress=later)


def test_forces_at_every_tick_are_spread_over_the_run(device: Device, board: Any) -> None:
    forces = np.linspace(0.3, 0.7, 5000)
    run = device.run(forces, 1.0)
    assert board.played == board.played | {"source": 1, "count": 1024, "step": round(2**24 * 1023 / 5000)}
    np.testing.assert_allclose(board.points, np.interp(np.linspace(0, 5000, 1024), range(5000), forces) * 1e4, atol=1)
    assert run.attrs["setpoint_error_n"] < 1e-4
    device.run(forces, 0.2)  # at every tick where there is room for that
    assert (board.played["count"], board.played["step"]) == (1001, 2**24)
    np.testing.assert_array_equal(board.points[:1001], np.rint(forces[:1001] * 1e4))


@pytest.mark.parametrize(("duration_s", "decimation", "rows"), [(0.5, 7, 358), (0.3, 1, 1500), (0.00015, 1, 1)])
def test_a_duration_is_rounded_up_to_whole_samples(
    device: Device, duration_s: float, decimation: int, rows: int
) -> None:
    run = device.run(0.5, duration_s, decimation=decimation)
    assert run.sizes["time"] == rows
    assert float(run.time[-1]) < duration_s <= float(run.time[-1]) + decimation / 5000 + 1e-12


def test_ctrl_c_names_the_file_and_overwrites_none(device: Device, board: Any, tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)

    def stopped(rows: int) -> None:
        if rows > 1000:
            raise KeyboardInterrupt

    for name in ("interrupted-run.h5", "interrupted-run-2.h5", "interrupted-run-3.h5"):
        with pytest.raises(KeyboardInterrupt, match=rf"^\d+ samples are in {name}$"):
            device.run(0.5, 2.0, progress=stopped)
        assert fl.load(name).sizes["time"] > 1000
        assert (board.state, board.decimation) == (0, 0)


def test_a_run_that_ends_before_its_first_sample_leaves_no_file(
    device: Device, board: Any, tmp_path: Any, monkeypatch: Any
) -> None:
    monkeypatch.chdir(tmp_path)
    said = board.say
    board.say = lambda name, **fields: None if name == "telemetry" else said(name, **fields)

    def stopped(_: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt, match=r"^nothing recorded$"):
        device.run(0.5, 2.0, progress=stopped)
    assert not list(tmp_path.iterdir())


def test_telemetry_as_it_comes(device: Device, board: Any) -> None:
    parts = list(device.stream(0.5, decimation=10))
    ticks = np.concatenate([part["tick"] for part in parts])
    assert len(ticks) == pytest.approx(250, abs=16)
    assert set(np.diff(ticks)) == {10}
    np.testing.assert_array_equal(np.concatenate([part["f_m"] for part in parts]), board.values(ticks, 0)[:, 1] * 1e-4)


def test_who_only_looks_leaves_the_mode_alone(boards: Any, board: Any) -> None:
    with Device(lambda: boards.Line(board)) as runs:
        runs.mode("closed")
        with Device(lambda: boards.Line(board)) as looks:
            assert looks.info.board == "host"
            looks.statistics()
            list(looks.stream(0.02))
        assert board.state == 2
    assert board.state == 0


def test_a_device_that_ran_is_left_idle(boards: Any, board: Any) -> None:
    device = Device(lambda: boards.Line(board))
    device.run(0.5, 0.02)
    board.state = 1  # as if the run's own stop had not come through
    device.close()
    assert board.state == 0
