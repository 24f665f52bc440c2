"""``frictionloop device``: the simulated board through every command, a loader that records, and what is refused."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.cli import device_run
from frictionloop.device import boards as simulated_boards
from frictionloop.device import serial_pipe, simulated_pipe
from frictionloop.device.emulator.processor import _whole
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.values import fingerprint
from frictionloop.quantities.schema import schema, table_hash

LOOKUP = ("--controller.kind", "lookup")
SLIPPERY = ("--motion.load_n", "4", "--open")  # the finger is pressed until its friction is more than the sensor takes
VERBS = "list", "info", "set", "run", "play", "recover", "clear", "monitor", "flash"


def rows(out):
    """Return a borderless table as a dictionary."""
    return {line.split("  ", 1)[0]: line.split("  ", 1)[1].strip() for line in out.splitlines() if "  " in line}


def refused(answer):
    """Return the one line that says what is wrong."""
    assert answer.code == 2 and answer.out == "" and answer.err.startswith("error: ") and answer.err.count("\n") == 1
    return answer.err.removeprefix("error: ").rstrip("\n")


# ---------------------------------------------------------------------------------------------------------------- help


@pytest.mark.parametrize("verb", VERBS)
def test_help_has_examples_that_fit(frictionloop, monkeypatch, verb):
    monkeypatch.setenv("COLUMNS", "80")
    out = frictionloop("device", verb, "--help").out
    assert f"\n  frictionloop device {verb}" in out
    assert max(len(line.rstrip()) for line in out.splitlines()) <= 80


def test_help_of_the_group_names_every_command(frictionloop):
    out = frictionloop("device", "--help").out
    assert all(f"\n    {verb} " in out for verb in VERBS)


# ---------------------------------------------------------------------------------------------------------- list, info


def test_ports_are_listed_by_the_address_that_others_take(frictionloop, monkeypatch):
    monkeypatch.setattr(serial_pipe, "described_ports", lambda: [("serial:///dev/ttyUSB7", "an adapter")])
    answer = frictionloop("device", "list")
    assert (answer.code, answer.err) == (0, "")
    assert rows(answer.out)["serial:///dev/ttyUSB7"] == "an adapter" and "sim:" in rows(answer.out)
    said = frictionloop("device", "list", "--json").json()
    assert said["ports"][0] == {"address": "serial:///dev/ttyUSB7", "is": "an adapter"}
    assert [port["address"] for port in said["ports"]] == ["serial:///dev/ttyUSB7", "sim:"]


def test_no_port_is_said_and_there_is_still_the_simulated_board(frictionloop, monkeypatch):
    monkeypatch.setattr(serial_pipe, "described_ports", list)
    answer = frictionloop("device", "list")
    assert (answer.code, answer.err) == (0, "") and "\nno serial port: " in answer.out
    assert list(rows(answer.out)) == ["sim:"]
    assert [port["address"] for port in frictionloop("device", "list", "--json").json()["ports"]] == ["sim:"]


def test_who_answers(frictionloop):
    said = rows(frictionloop("device", "info", "sim:").out)
    model = fl.bench().controller.model
    assert said["board"] == "host"
    assert "protocol 4.0" in said["firmware"] and "5000 ticks a second" in said["firmware"]
    assert said["layout"] == f"{table_hash():08x}, as here"
    assert said["values"] == fingerprint(firmware_words(fl.bench()))
    assert said["law"] == f"pi, 0.0884 to {model.nominal_n:g} N, at most {model.max_amplitude_um:g} um"
    assert said["telemetry"] == "0 samples dropped"
    assert said["ticks"].endswith(" 0 late, longest tick not measured")
    numbers = frictionloop("device", "info", "sim:", "--json").json()
    assert (numbers["board"], numbers["law"], numbers["tick_hz"]) == ("host", "pi", 5000)
    assert (numbers["layout"], numbers["values"]) == (f"{table_hash():08x}", said["values"])
    assert "table_hash" not in numbers and "differing" not in numbers
    assert numbers["clamp_n"][1] == pytest.approx(model.nominal_n, abs=2**-28)
    assert numbers["ceiling_um"] == model.max_amplitude_um
    assert numbers["ticks"] > 0 and numbers["frames"] > 0 and numbers["broken"] == numbers["missed"] == 0


def test_values_are_compared_with_those_of_a_file(frictionloop, tmp_path):
    file = tmp_path / "bench.toml"
    fl.write_toml(fl.bench(), file)
    answer = frictionloop("device", "info", "sim:", str(file))
    values = fingerprint(firmware_words(fl.bench()))
    assert answer.code == 0 and f"{values}, those of" in answer.out and "NOT" not in answer.out
    assert frictionloop("device", "info", "sim:", str(file), "--json").json()["differing"] == []

    kp = {"controller.kp": 0.05, "board.ceiling_um": 0.5, "board.ramp_s": 0.04, "board.force_axes": 2}
    other = fl.bench().evolve(kp)
    fl.write_toml(other, file)
    said = " ".join(frictionloop("device", "info", "sim:", str(file)).out.split())
    assert f"values {values}, NOT those of" in said and fingerprint(firmware_words(other)) in said
    assert f"law.gains[0] {fl.bench().controller.kp:g} on the device, 0.05 in the file" in said
    numbers = frictionloop("device", "info", "sim:", str(file), "--json").json()
    names = [each["name"] for each in numbers["differing"]]
    assert {"law.gains[0]", "drive.ceiling_um", "drive.ramp_um", "force.axes"} == set(names)
    assert f"and {len(names) - 3} more" in said and names[3] not in said
    assert numbers["file_values"] == fingerprint(firmware_words(other)) != numbers["values"]


def test_a_file_that_is_not_there_is_refused_before_the_device_is_looked_for(frictionloop, tmp_path):
    said = refused(frictionloop("device", "info", "serial:///dev/no-such-port", str(tmp_path / "none.toml")))
    assert "none.toml" in said and "no-such-port" not in said


def test_a_folder_stands_for_the_image_in_it(frictionloop, tmp_path):
    said = refused(frictionloop("device", "info", f"emulated:{tmp_path}"))
    assert "is a folder without teensy31.elf; frictionloop firmware build FILE --out FOLDER makes one" in said
    (tmp_path / "teensy31.elf").write_text("no image")
    assert "teensy31.elf: is not an ELF file" in refused(frictionloop("device", "info", f"emulated:{tmp_path}"))


@pytest.mark.parametrize(
    ("address", "says"),
    [
        ("simulator:", "address 'simulator:': must be one of sim:, emulated:"),
        ("serial:///dev/no-such-port", "/dev/no-such-port: no such port; there is "),
        ("tcp://localhost", "address 'tcp://localhost': must be one of"),
        ("emulated:no-such.elf", "no-such.elf"),
        ("COM9", "address 'COM9': did you mean serial://COM9?"),
        ("/dev/ttyACM0", "address '/dev/ttyACM0': did you mean serial:///dev/ttyACM0?"),
    ],
)
def test_an_address_where_nothing_is(frictionloop, address, says):
    assert says in refused(frictionloop("device", "info", address))


@pytest.mark.parametrize("address", ["COM9", "serial:///dev/no-such-port", "tcp://localhost:1"])
def test_an_address_is_refused_before_what_drives_a_device_is_loaded(address):
    script = f"""
import sys
from frictionloop.cli.app import main
try:
    main(["device", "info", {address!r}])
except SystemExit as end:
    print(end.code, *sorted({{"scipy", "xarray", "numba"}} & set(sys.modules)))
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert told.stdout == "2\n" and told.stderr.startswith("error: ")


# ----------------------------------------------------------------------------------------------------------------- set


def test_values_change_and_are_read_back(frictionloop):
    arguments = ("device", "set", "sim:", "drive.ceiling_um=2", "setpoint.hold_n=0.25")
    assert rows(frictionloop(*arguments).out) == {
        "drive.ceiling_um": "2.5 um -> 2 um",
        "setpoint.hold_n": "0.6 N -> 0.25 N",
    }
    said = frictionloop(*arguments, "--json").json()
    assert said["before"]["drive.ceiling_um"] == 2.5
    assert said["after"] == {"drive.ceiling_um": 2.0, "setpoint.hold_n": 0.25}
    assert said["system"] is None


def test_a_parameter_of_several_numbers(frictionloop):
    said = frictionloop("device", "set", "sim:", "force.zero_counts=[-100, 100]", "--json").json()
    assert said["after"] == {"force.zero_counts": [-100.0, 100.0]}
    assert rows(frictionloop("device", "set", "sim:", "force.zero_counts=[-100, 100]").out) == {
        "force.zero_counts": "2 numbers -> 2 numbers"
    }


def test_a_whole_system_and_one_value_on_top(frictionloop, tmp_path):
    path = tmp_path / "mine.toml"
    weaker = {f"{name}.max_amplitude_um": 2.0 for name in ("plate", "controller.model")}
    fl.write_toml(fl.bench().evolve({"setpoint.offset_n": 0.4, **weaker}), path)
    said = frictionloop("device", "set", "sim:", "--system", path, "law.low_n=0.2", "--json").json()
    assert said["system"] == str(path)
    model = fl.bench().controller.model  # that of the device before
    lowest = model.nominal_n * np.exp(-model.susceptibility_per_um2 * model.max_amplitude_um**2)
    assert said["before"]["law.low_n"] == pytest.approx(lowest, rel=1e-3)
    assert said["after"]["law.low_n"] == pytest.approx(0.2, abs=2**-28)
    assert f"set from {path}".split()[0] in frictionloop("device", "set", "sim:", "--system", path).out


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["drive.ceilng_um=2"], "parameter 'drive.ceilng_um': unknown; near: drive.ceiling_um"),
        (
            ["xyzzy=1"],
            "parameter 'xyzzy': unknown; there are law.*, lookup.*, overdrive.*, drive.*, ",
        ),
        (["kp=3"], "parameter 'kp': unknown; did you mean controller.kp?"),
        (["drive.ceiling_um=200"], "drive.ceiling_um = 200 um: must be a number from 0 to 7.9 um"),
        (["drive.ceiling_um=nan"], "drive.ceiling_um = nan um: must be a number from 0 to 7.9 um"),
        (["drive.ceiling_um=high"], "drive.ceiling_um = 'high': must be a number from 0 to 7.9 um"),
        (["force.zero_counts=1"], "force.zero_counts: 1 number; must be 2"),
        (["drive.ceiling_um"], "'drive.ceiling_um': must be NAME=VALUE, such as drive.ceiling_um=2"),
        (["drive.ceiling_um="], "'drive.ceiling_um=': must be NAME=VALUE"),
        (["=2"], "'=2': must be NAME=VALUE"),
        ([], "set: needs NAME=VALUE or --system FILE"),
        (["--system", "nothing.toml"], "nothing.toml"),
        (["law.low_n=0.9", "law.high_n=0.1"], "commit: the device refuses law.high_n = 0.1 N, out of range"),
    ],
)
def test_what_is_not_set_is_one_line(frictionloop, arguments, says):
    assert says in refused(frictionloop("device", "set", "sim:", *arguments))


HOLD = ("controller.kp=0.04", "controller.ki=100")


@pytest.mark.slow
def test_gains_are_set_by_their_names_and_only_by_its_owner_while_a_loop_runs(frictionloop, kept):
    fl.write_toml(fl.bench(), "mine.toml")
    assert rows(frictionloop("device", "set", "sim:", *HOLD).out) == {
        "controller.kp": "10.0 -> 0.04",
        "controller.ki": "2.0 -> 100.0",
    }
    with fl.connect("sim:") as device:
        device.mode("closed")
        more = (HOLD[1], "controller.kp=0.03", "drive.ceiling_um=2", "--system", "mine.toml")
        said = refused(frictionloop("device", "set", "sim:", *more))
        assert "another host's loop is on" in said
        device.reconnect()  # both have one line here, which the other has closed
        device.set("setpoint.hold_n", 0.25)
        device.commit()
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][0] == pytest.approx(0.04, rel=1e-6)  # as before
        assert device.parameters["setpoint.hold_n"] == 0.25
        answer = frictionloop("device", "set", "sim:", *more, "--json")
        said = json.loads(answer.out)
        assert "this loop rings on slip length 0 um at 10, 20, 80 mm/s" in answer.err  # the file's is Dahl's
        assert said["after"] == {"controller.ki": 100.0, "controller.kp": 0.03, "drive.ceiling_um": 2.0}
    with fl.connect("sim:") as device:
        gains = np.asarray(device.parameters["law.gains"])
        assert gains[:2] == pytest.approx([0.03, 100.0 / 5000.0], rel=1e-6)
        assert device.parameters["drive.ceiling_um"] == pytest.approx(2.0)


def test_gains_that_ring_are_refused_with_gains_that_hold(frictionloop, kept):
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=12"))
    assert said.startswith("controller.kp=12: this loop rings near ") and "--unchecked sets it all the same" in said
    held = re.findall(r"controller\.k[pi]=[\d.]+", said.split("gains that hold at slip length 11.5 um, 20 mm/s")[1])
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][0] == pytest.approx(10.0)  # as before
    assert len(held) == 2 and frictionloop("device", "set", "sim:", *held).code == 0


def test_gains_that_ring_are_set_where_that_is_asked_for(frictionloop):
    said = frictionloop("device", "set", "sim:", "controller.kp=12", "--unchecked", "--json").json()
    assert said["after"] == {"controller.kp": 12.0}


def test_of_gains_and_a_value_that_is_refused_neither_is_set(frictionloop, kept):
    assert "law.high_n = 0.1 N" in refused(
        frictionloop("device", "set", "sim:", *HOLD, "law.high_n=0.1", "law.low_n=0.9")
    )
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][0] == pytest.approx(10.0)


def test_gains_close_to_ringing_are_set_with_a_word(frictionloop):
    answer = frictionloop("device", "set", "sim:", "controller.kp=0", "controller.ki=150")
    assert answer.code == 0 and "this loop is close to ringing near" in answer.err


def test_gains_of_a_board_that_nobody_described_are_read_from_it_and_set_unchecked(frictionloop, kept):
    assert frictionloop("device", "set", "sim:", "law.low_n=0.2").code == 0  # of no System from now on
    answer = frictionloop("device", "set", "sim:", "controller.ki=100", "controller.kp=0.04")
    assert rows(answer.out) == {"controller.ki": "2.0 -> 100.0", "controller.kp": "10.0 -> 0.04"}
    assert answer.err.startswith("controller.ki, controller.kp: not checked: a board does not tell its bench")
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][:2] == pytest.approx([0.04, 100.0 / 5000.0], rel=1e-6)
        assert device.parameters["law.low_n"] == pytest.approx(0.2)  # all else stays
    fl.write_toml(fl.bench(), "mine.toml")
    assert frictionloop("device", "set", "sim:", "--system", "mine.toml", *HOLD).code == 0


def test_what_a_board_that_nobody_described_cannot_tell_needs_its_system(frictionloop, kept):
    assert frictionloop("device", "set", "sim:", "law.low_n=0.2").code == 0
    said = refused(frictionloop("device", "set", "sim:", "controller.kind=notch_pi"))
    assert said.startswith("controller.kind: the device tells controller.kp and controller.ki alone; ")
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=-1"))
    assert said == "controller.kp = -1 N/N: must be greater than or equal to 0"
    assert frictionloop("device", "set", "sim:", "law.number=2").code == 0
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=1"))
    assert said.startswith("controller: the device runs law lookup and tells the gains of law pi alone; ")
    assert "--system FILE" in said


def test_a_parameter_as_a_flag_is_told_how_it_is_written_here(frictionloop):
    said = refused(frictionloop("device", "set", "sim:", "--controller.kp", "5000"))
    assert said == "--controller.kp: is no option here; without dashes: controller.kp=5000"
    said = refused(frictionloop("device", "info", "sim:", "--controller.kp", "5000"))
    assert said == "Unknown option: --controller.kp. device info takes no parameters of a system; see --help"


@pytest.mark.slow
def test_the_kind_that_was_set_is_told(frictionloop, kept):
    assert frictionloop("device", "set", "sim:", "controller.kind=notch_pi", "controller.kp=0.05").code == 0
    known = fl.bench().evolve({"controller.kind": "notch_pi", "controller.kp": 0.05})
    with fl.connect("sim:") as device:
        assert device.parameters.hold(firmware_words(known))
    assert rows(frictionloop("device", "info", "sim:").out)["law"].startswith("filtered_pi or notch_pi, ")


def test_a_low_ceiling_is_named_where_the_force_stays_high(frictionloop):
    held = ("--controller.kp", "0.0434", "--controller.ki", "108", "--duration-s", "0.5")
    low = " ".join(frictionloop("device", "run", "sim:", *held, "--board.ceiling_um", "0.5").out.split())
    assert "The amplitude is at its ceiling, 0.5 um, 100% of the time" in low
    assert "The ceiling may be why: the plate gives 2.5 um." in low
    assert "ceiling" not in frictionloop("device", "run", "sim:", *held).out


def test_ctrl_c_waits_until_the_emulator_has_returned():
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    reached = []
    try:
        with pytest.raises(KeyboardInterrupt), _whole():
            signal.raise_signal(signal.SIGINT)
            reached.append("end")
        assert reached == ["end"] and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    finally:
        signal.signal(signal.SIGINT, before)


# ----------------------------------------------------------------------------------------------------------------- run


def test_a_run_is_recorded_and_said(frictionloop, tmp_path):
    path, figure = tmp_path / "run.h5", tmp_path / "run.svg"
    arguments = ("device", "run", "sim:", *LOOKUP, "--duration-s", "0.2", "--out", path, "--plot", figure)
    said = frictionloop(*arguments, "--json").json()
    run = fl.load(path)
    assert run.attrs["source"] == "simulated" and run.sizes["time"] == said["samples"] == 1000
    assert fl.system_of(run).controller.kind == "lookup"
    assert said["counted"] == pytest.approx(float((run.scored & run.sliding).mean()))
    error = (run.f_m - run.f_r).where(run.scored)
    assert said["measured_rms_error_n"] == pytest.approx(float(np.sqrt((error**2).mean())))
    assert said["lost_samples"] == said["gaps"] == said["reconnects"] == said["broken_frames"] == 0
    assert said["saved"] == {"run": str(path), "plot": str(figure)}
    assert figure.read_text(encoding="utf-8").lstrip().startswith("<?xml")


def test_a_run_in_words(frictionloop):
    answer = frictionloop("device", "run", "sim:", *LOOKUP, "--duration-s", "0.2", "--decimation", "5")
    assert (answer.code, answer.err) == (0, "")
    said = rows(answer.out)
    assert said["device"] == "sim:" and said["system"] == "bench() with controller.kind = lookup"
    assert said["recorded"] == "200 samples"
    assert re.match(r"[\d.]+ %: a finger slides, 2 mm or more from where it turns$", said["counted"])
    assert said["f_m - f_r"].endswith("mN rms by the device's own sensor") and said["lost"] == "nothing"


@pytest.mark.slow
@pytest.mark.parametrize("device_knows_f_a", [True, False])
def test_a_loop_that_rings_is_told_of_as_in_simulate(frictionloop, monkeypatch, device_knows_f_a):
    if not device_knows_f_a:
        monkeypatch.setattr(simulated_pipe.BenchPipe, "felt", lambda *_: None)
    arguments = ("--duration-s", "1")
    here, there = frictionloop("device", "run", "sim:", *arguments), frictionloop("simulate", "--preset", "bench",
                                                                                 *arguments)  # fmt: skip
    assert here.code == there.code == 0
    said = [
        re.findall(r"^(?:This loop rings near|Gains that hold:|They hold) .*$", each.out, re.M)
        for each in (here, there)
    ]
    assert len(said[0]) == len(said[1]) == 3 and said[0][1:] == said[1][1:]
    loudest_hz = [float(re.search(r"near ([\d.]+) Hz", lines[0])[1]) for lines in said]
    assert loudest_hz[0] == pytest.approx(loudest_hz[1], rel=0.2)


def test_gains_that_are_named_hold_on_the_device(frictionloop):
    rings = frictionloop("device", "run", "sim:", "--duration-s", "0.5", "--json").json()
    assert rings["ringing"]["law"] == "pi" and not rings["ringing"]["stable"]
    gains = [word for name, gain in rings["ringing"]["held"].items() for word in (f"--{name}", gain)]
    held = frictionloop("device", "run", "sim:", *gains, "--duration-s", "0.5", "--json").json()
    assert held["ringing"] is None
    assert held["measured_rms_error_n"] < 0.2 * rings["measured_rms_error_n"]


def test_open_loop_does_not_ring(frictionloop):
    said = frictionloop("device", "run", "sim:", "--open", "--duration-s", "0.2", "--json").json()
    assert said["ringing"] is None


def test_a_preset_stands_for_a_file(frictionloop, tmp_path):
    arguments = ("device", "run", "sim:", "--open", "--duration-s", "0.1")
    assert rows(frictionloop(*arguments, "--preset", "bench").out)["system"] == "bench()"
    fl.write_toml(fl.bench(), tmp_path / "mine.toml")
    assert "both name a system" in refused(frictionloop(*arguments, "mine.toml", "--preset", "bench"))


def test_a_run_in_which_no_finger_slides_has_no_error(frictionloop):
    arguments = ("device", "run", "sim:", "--open", "--duration-s", "0.002")
    said = rows(frictionloop(*arguments).out)
    assert said["counted"].startswith("0 %") and said["f_m - f_r"] == "none"
    assert frictionloop(*arguments, "--json").json()["measured_rms_error_n"] is None


def test_open_loop_asks_for_what_the_lookup_has(frictionloop, tmp_path):
    frictionloop("device", "run", "sim:", "--open", "--setpoint.kind", "constant", "--setpoint.offset_n", "0.5",
                 "--duration-s", "0.1", "--out", tmp_path / "open.h5")  # fmt: skip
    run = fl.load(tmp_path / "open.h5")
    model = fl.bench().controller.model
    wanted_um = np.sqrt(np.log(model.nominal_n / 0.5) / model.susceptibility_per_um2)
    assert float(run.a[-1]) == pytest.approx(wanted_um, abs=2e-3)


def test_a_file_is_loaded_and_its_set_point_is_played(frictionloop, tmp_path):
    fl.write_toml(fl.bench().evolve({"setpoint.kind": "constant", "setpoint.offset_n": 0.55}), tmp_path / "mine.toml")
    answer = frictionloop("device", "run", "sim:", "mine.toml", "--open", "--duration-s", "0.1", "--out", "run.h5")
    assert rows(answer.out)["system"] == "mine.toml"
    assert fl.load(tmp_path / "run.h5").f_r.values == pytest.approx(0.55, abs=2e-4)


def test_a_device_that_knows_no_force_on_the_finger_is_drawn(frictionloop, monkeypatch, tmp_path):
    monkeypatch.setattr(simulated_pipe.BenchPipe, "felt", lambda *_: None)
    answer = frictionloop("device", "run", "sim:", *LOOKUP, "--duration-s", "0.1", "--out", "run.h5", "--plot", "r.svg")
    assert (answer.code, answer.err) == (0, "")
    assert "f_a" not in fl.load(tmp_path / "run.h5")
    assert (tmp_path / "r.svg").stat().st_size > 10_000


@pytest.mark.parametrize("out", ["cut.h5", None])
def test_a_fault_in_mid_run_is_one_line_and_keeps_the_recording(frictionloop, tmp_path, out):
    arguments = ("device", "run", "sim:", *SLIPPERY, "--duration-s", "0.4")
    said = refused(frictionloop(*arguments, *(("--out", out) if out else ()), "--json"))
    kept = out or "interrupted-run.h5"
    assert re.match(r"fault force_range at tick \d+ \(2\.4\d* N\): the force is outside .*; ", said) and said.endswith(
        f"samples recorded so far are in {kept}"
    )
    run = fl.load(tmp_path / kept)
    assert run.sizes["time"] == int(said.split("; ")[1].split()[0]) > 100
    # The force was about to leave what the sensor takes.
    assert 0.9 * fl.bench().sensor.range_n < float(np.abs(run.f_m).max()) <= fl.bench().sensor.range_n


def test_the_bench_that_ends_in_mid_run_is_one_line(frictionloop, tmp_path):
    sweep = {"kind": "log_sweep", "offset_n": 0.1, "start_hz": 1, "stop_hz": 10, "sweep_s": 0.15}
    flags = [word for name, value in sweep.items() for word in (f"--disturbance.{name}", value)]
    said = refused(frictionloop("device", "run", "sim:", *LOOKUP, *flags, "--duration-s", "0.3", "--out", "cut.h5"))
    assert "disturbance.sweep_s = 0.15 s is over" in said and said.endswith("are in cut.h5")
    assert fl.load(tmp_path / "cut.h5").sizes["time"] < 750


def test_ctrl_c_says_where_the_recording_is(frictionloop, monkeypatch, tmp_path):
    from contextlib import contextmanager

    @contextmanager
    def impatient(*_):
        def stop(samples):
            if samples > 250:
                raise KeyboardInterrupt

        yield stop

    monkeypatch.setattr(device_run, "_progress", impatient)
    answer = frictionloop("device", "run", "sim:", *LOOKUP, "--duration-s", "1", "--out", "cut.h5")
    count = fl.load(tmp_path / "cut.h5").sizes["time"]
    assert 250 < count < 1000
    assert (answer.code, answer.out) == (130, "")
    assert answer.err == f"interrupted: {count} samples recorded so far are in cut.h5\n"


def fail(limit_n=0.001):
    """Make the board at sim: fault in mid-run; it takes hardly any force from now on."""
    with fl.connect("sim:") as device:
        device.set("safety.force_limit_n", limit_n)
        device.commit()
        with pytest.raises(fl.Interrupted, match="fault force_range"):
            device.run(0.5, 0.5)


@pytest.fixture
def kept(monkeypatch):
    """Boards by their address: one that is there is connected to again, as it was left."""
    boards = {}

    def same_board(address, system=None, seed=0):
        if address not in boards:
            system = system or fl.bench()
            boards[address] = simulated_pipe.BenchPipe(simulated_boards.Simulated(system), system, seed)
        return boards[address].opened

    for room in ("device", "transport"):
        monkeypatch.setattr(f"frictionloop.device.{room}.opener", same_board)
    return boards


def test_a_run_clears_the_fault_of_the_one_before(frictionloop, monkeypatch, kept):
    asked = []
    monkeypatch.setattr(fl.Device, "clear", lambda device: asked.append(device._link.ask("clear").name))
    first = ("device", "run", "sim:", *LOOKUP, "--duration-s", "0.1")
    assert frictionloop(*first).code == 0
    board = kept["sim:"]
    fail()
    with fl.connect("sim:") as device, pytest.raises(fl.DeviceError, match="has the fault force_range: find its cause"):
        device.run(0.5, 0.5)
    assert frictionloop(*first).code == 0 and kept["sim:"] is board
    assert asked == ["done", "done"]


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--duration-s", "0"], "duration_s = 0"),
        (["--decimation", "0"], "decimation = 0: must be a whole number from 1 to 65535"),
        (["--controller.rate_hz", "10000"], "controller.rate_hz = 10000 Hz"),
        (["--out", "run.csv"], "out = 'run.csv'"),
        (["--plot", "run.h5"], "plot = 'run.h5'"),
        (["--out", "nowhere/run.h5"], "nowhere"),
        (["--contoller.kp", "1"], "contoller.kp"),
        (["missing.toml"], "missing.toml"),
    ],
)
def test_a_run_that_is_refused_leaves_no_file(frictionloop, tmp_path, arguments, says):
    assert says in refused(frictionloop("device", "run", "sim:", *arguments))
    assert list(tmp_path.iterdir()) == []


# --------------------------------------------------------------------------------------------------------------- clear


def test_a_fault_is_cleared_and_named(frictionloop, kept):
    answer = frictionloop("device", "clear", "sim:")
    assert (answer.code, answer.out, answer.err) == (0, "no fault\n", "")
    assert frictionloop("device", "clear", "sim:", "--json").json() == {"cleared": None}
    fail()
    assert refused(frictionloop("device", "clear", "sim:")).startswith("fault force_range: its cause lasts")
    assert frictionloop("device", "set", "sim:", "safety.force_limit_n=2").code == 0
    assert frictionloop("device", "clear", "sim:").out == "cleared force_range\n"
    assert frictionloop("device", "clear", "sim:").out == "no fault\n"
    fail()
    assert frictionloop("device", "set", "sim:", "safety.force_limit_n=2").code == 0
    assert frictionloop("device", "clear", "sim:", "--json").json() == {"cleared": "force_range"}


def test_a_board_that_tells_no_sample_is_not_cleared(frictionloop, monkeypatch):
    monkeypatch.setattr(fl.Device, "stream", lambda *_: iter(()))
    assert refused(frictionloop("device", "clear", "sim:")) == "sim:: sends no samples, so its fault is not known"


# ------------------------------------------------------------------------------------------------------------- monitor


def test_lines_of_the_monitor_have_every_channel(frictionloop):
    answer = frictionloop("device", "monitor", "sim:", "--duration-s", "0.25", "--rate-hz", "20")
    assert (answer.code, answer.err) == (0, "")
    head, *lines = answer.out.splitlines()
    channels = [entry["name"] for entry in schema()["channel"] if entry["name"] != "flags"]
    assert [name for name in channels if name not in head.split()] == []
    assert 4 <= len(lines) <= 5
    table = np.array([[float(cell) for cell in line.split()[:-1]] for line in lines])
    assert table.shape == (len(lines), 1 + len(channels))
    assert np.diff(table[:, 0]) == pytest.approx(0.05, abs=0.011)
    assert {line.split()[-1] for line in lines} == {"idle"}
    assert {len(line) for line in [*lines, head.replace("state", "idle")]} == {78}
    of = dict(zip(["s", *channels], table.T, strict=True))
    assert np.all(of["a"] == 0)  # the plate is not asked for anything
    system = fl.bench()
    assert of["load"] == pytest.approx(system.motion.load_n, rel=0.3)
    assert of["speed"][-1] == pytest.approx(system.motion.speed_mm_s, rel=0.3)
    assert np.diff(of["position"])[-1] == pytest.approx(0.05 * of["speed"][-1], rel=0.3)


@pytest.mark.parametrize("rate", ["0", "-1", "101", "nan", "inf"])
def test_a_rate_that_nobody_can_read_is_refused(frictionloop, rate):
    assert "must be above 0 and at most 100" in refused(frictionloop("device", "monitor", "sim:", "--rate-hz", rate))


@pytest.mark.parametrize("duration", ["0", "-1", "nan", "inf"])
def test_a_time_without_end_or_beginning_is_refused(frictionloop, duration):
    assert "must be above 0 and finite" in refused(frictionloop("device", "monitor", "sim:", "--duration-s", duration))


# --------------------------------------------------------------------------------------------------------------- flash


@pytest.fixture
def loader(monkeypatch, tmp_path):
    """Return what puts a loader on a path that has nothing else: it records its arguments and ends as it is told."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))

    def put(name="teensy_loader_cli", code=0):
        script = folder / name
        script.write_text(
            f"#!{sys.executable}\nimport sys\n"
            f"open({str(tmp_path / 'arguments')!r}, 'w').write('\\n'.join(sys.argv[1:]))\nraise SystemExit({code})\n"
        )
        os.chmod(script, 0o755)
        return tmp_path / "arguments"

    (tmp_path / "image.hex").write_text(TEENSY)
    return put


def record(address, content):
    """Return a record of Intel hex with data."""
    body = bytes([len(content), *divmod(address, 256), 0, *content])
    return f":{(body + bytes([-sum(body) % 256])).hex().upper()}\n"


# Twelve times FF, then FSEC, FOPT and two more: what the manual of the chip asks for at 0x400.
OPEN_CHIP = bytes.fromhex("ffffffffffffffffffffffffdef9ffff")
ENDS = ":00000001FF\n"
TEENSY = record(0, bytes(16)) + record(0x400, OPEN_CHIP) + ENDS


@pytest.mark.parametrize("name", ["teensy_loader_cli", "teensy-loader-cli"])
def test_the_loader_is_told_the_board_and_the_image(frictionloop, loader, name):
    arguments = loader(name)
    answer = frictionloop("device", "flash", "image.hex")
    assert (answer.code, answer.out, answer.err) == (0, "flashed image.hex\n", "press the button on the board\n")
    assert arguments.read_text().split("\n") == ["--mcu=TEENSY31", "-w", "-v", "image.hex"]


def test_a_loader_that_fails_is_said(frictionloop, loader):
    loader(code=3)
    answer = frictionloop("device", "flash", "image.hex")
    assert answer.code == 2 and answer.out == ""
    assert answer.err.endswith(
        "error: teensy_loader_cli: ended with 3; is the board plugged in, and its udev rule there?\n"
    )


def test_a_loader_that_is_missing_is_named_with_where_to_get_it(frictionloop, loader):
    said = refused(frictionloop("device", "flash", "image.hex"))
    assert said.startswith("teensy_loader_cli is not installed: ")
    assert "apt-get install teensy-loader-cli" in said and "https://www.pjrc.com" in said


@pytest.mark.parametrize(
    ("image", "says"),
    [("image.elf", "must end in .hex; frictionloop firmware build makes one"), ("other.hex", "there is no such file")],
)
def test_an_image_that_is_none_never_reaches_the_loader(frictionloop, loader, image, says):
    arguments = loader()
    assert refused(frictionloop("device", "flash", image)) == f"IMAGE = '{image}': {says}"
    assert not arguments.exists()


LOCKED_CHIP = OPEN_CHIP[:12] + b"\xdc" + OPEN_CHIP[13:]


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (record(0, bytes(64)) + ENDS, "is not an image of a Teensy"),
        (record(0x400, LOCKED_CHIP) + ENDS, "is not an image of a Teensy"),
        (record(0x400, OPEN_CHIP[:8]) + ENDS, "is not an image of a Teensy"),
        (record(0x400, OPEN_CHIP), "it is cut off"),
        (TEENSY.replace("DEF9", "DEF8"), "cannot be read as Intel hex (Record at line 2 has invalid checksum)"),
        ("not hex\n", "cannot be read as Intel hex (Hex file contains invalid record at line 1)"),
        ("", "it is cut off"),
        ("\u00b5", "cannot be read as Intel hex"),
    ],
)
def test_an_image_that_is_no_teensys_never_reaches_the_loader(frictionloop, loader, tmp_path, content, says):
    arguments = loader()
    (tmp_path / "image.hex").write_text(content, encoding="utf-8")
    assert says in refused(frictionloop("device", "flash", "image.hex"))
    assert not arguments.exists()


def test_gains_that_ring_only_with_the_resonance_off_are_refused(frictionloop):
    from frictionloop.cli import ringing

    # Stable as described, and not with the resonance lower: what a sensor does that is not quite as written down.
    pi = {"controller.kind": "pi", "controller.kp": 0.0}
    found = next(
        ki
        for ki in np.geomspace(2000.0, 50.0, 200)
        if all(loop.is_stable() for loop in ringing.points_of(fl.bench().evolve(pi | {"controller.ki": ki})))
    )
    lower = fl.bench().evolve(pi | {"controller.ki": found, "sensor.resonance_hz": 0.9 * 145.0})
    assert not all(loop.is_stable() for loop in ringing.points_of(lower))
    fl.write_toml(fl.bench(), "mine.toml")
    arguments = ("controller.kind=pi", "controller.kp=0", f"controller.ki={found}", "--system", "mine.toml")
    said = refused(frictionloop("device", "set", "sim:", *arguments))
    assert "this loop rings at" in said and "resonance" in said and "--unchecked" in said
