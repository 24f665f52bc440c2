"""``frictionloop device``: the simulated board through every command, a loader that records, and what is refused."""

from __future__ import annotations

import os
import re
import signal
import struct
import subprocess
import sys

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.stability import rings_if_linear
from frictionloop.device import run_accuracy, simulated_boards, transport
from frictionloop.device.emulator.processor import _whole
from frictionloop.firmware.parameter_files import fingerprint
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities.protocol_schema import schema, table_hash

LOOKUP = ("--controller.kind", "lookup")
SLIPPERY = ("--motion.load_n", "4", "--open")  # the finger is pressed until its friction is more than the sensor takes
VERBS = "list", "info", "set", "run", "play", "recover", "clear", "monitor", "flash"


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
    monkeypatch.setattr(transport, "described_ports", lambda: [("serial:///dev/ttyUSB7", "an adapter")])
    assert [port.address for port in fl.device.list_ports().ports] == ["serial:///dev/ttyUSB7", "sim:"]
    said = frictionloop("device", "list", "--json").json()
    assert said["ports"][0] == {"address": "serial:///dev/ttyUSB7", "what": "an adapter"}
    monkeypatch.setattr(transport, "described_ports", list)
    assert [port["address"] for port in frictionloop("device", "list", "--json").json()["ports"]] == ["sim:"]


def test_who_answers(frictionloop):
    model, found = fl.bench().controller.model, fl.device.info("sim:")
    assert (found.board, found.law, found.tick_hz, found.protocol) == ("host", "pi", 5000, "5.0")
    assert (found.layout, found.values) == (f"{table_hash():08x}", fingerprint(firmware_words(fl.bench())))
    assert found.clamp_n[1] == pytest.approx(model.nominal_n, abs=2**-28)
    assert found.ceiling_um == model.max_amplitude_um and found.laws == {"lookup": (), "pi": ()}
    assert found.counts["ticks"] > 0 and found.counts["frames"] > 0
    assert found.counts["broken"] == found.counts["missed"] == found.counts["dropped"] == found.counts["overruns"] == 0
    said = frictionloop("device", "info", "sim:", "--json").json()
    assert (said["schema"], said["values"], said["differing"]) == ("device.info/1", found.values, [])


def test_values_are_compared_with_those_of_a_file(frictionloop, tmp_path):
    file, bench = tmp_path / "bench.toml", fl.bench()
    same = fl.device.info("sim:", bench)
    assert same.values == same.system_values == fingerprint(firmware_words(bench))
    assert same.differing == () and same.findings == ()

    other = bench.evolve({"controller.kp": 0.05, "board.ceiling_um": 0.5, "board.ramp_s": 0.04, "board.force_axes": 2})
    fl.write_toml(other, file)
    said = frictionloop("device", "info", "sim:", str(file), "--json").json()
    gains, *rest = said["differing"]
    assert gains == {"name": "law.gains[0]", "device": f"{bench.controller.kp:g}", "system": "0.05"}
    assert {each["name"] for each in rest} == {"drive.ceiling_um", "drive.ramp_um", "force.axes"}
    assert said["system_values"] == fingerprint(firmware_words(other)) != said["values"]
    assert [(each["code"], each["value"]) for each in said["findings"]] == [("TABLE-DIFFERS", 4)]


def test_a_file_that_is_not_there_is_refused_before_the_device_is_looked_for(frictionloop, tmp_path):
    said = refused(frictionloop("device", "info", "serial:///dev/no-such-port", str(tmp_path / "none.toml")))
    assert "none.toml" in said and "no-such-port" not in said


def test_a_folder_stands_for_the_image_in_it(frictionloop, tmp_path):
    said = refused(frictionloop("device", "info", f"emulated:{tmp_path}"))
    assert "teensy41.elf: no such file; firmware build makes one  [BAD-IMAGE]" in said
    (tmp_path / "teensy41.elf").write_text("no image")
    assert "teensy41.elf: no ELF file" in refused(frictionloop("device", "info", f"emulated:{tmp_path}"))


def test_an_address_is_refused_before_what_drives_a_device_is_loaded():
    script = """
import sys
from frictionloop.cli.app import main
for address in ("COM9", "serial:///dev/no-such-port", "tcp://localhost:1"):
    try:
        main(["device", "info", address])
    except SystemExit as end:
        print(end.code, *sorted({"scipy", "xarray", "numba"} & set(sys.modules)))
"""
    told = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert told.stdout == "2\n" * 3 and told.stderr.count("error: ") == 3


# ----------------------------------------------------------------------------------------------------------------- set


def test_values_change_and_are_read_back(frictionloop):
    values = {"drive.ceiling_um": 2, "setpoint.hold_n": 0.25, "force.zero_counts": [-100, 100]}
    found = fl.device.configure("sim:", values)
    assert (found.before["drive.ceiling_um"], found.after["drive.ceiling_um"]) == (2.5, 2.0)
    assert found.units == {"drive.ceiling_um": "um", "setpoint.hold_n": "N", "force.zero_counts": ""}
    words = ("drive.ceiling_um=2", "setpoint.hold_n=0.25", "force.zero_counts=[-100, 100]")
    said = frictionloop("device", "set", "sim:", *words, "--json").json()
    assert said["after"] == {"drive.ceiling_um": 2.0, "setpoint.hold_n": 0.25, "force.zero_counts": [-100.0, 100.0]}
    assert said["system"] is None


def test_a_whole_system_and_one_value_on_top(frictionloop, tmp_path):
    path = tmp_path / "mine.toml"
    weaker = {f"{name}.max_amplitude_um": 2.0 for name in ("plate", "controller.model")}
    fl.write_toml(fl.bench().evolve({"setpoint.offset_n": 0.4, **weaker}), path)
    said = frictionloop("device", "set", "sim:", "--system", path, "law.low_n=0.2", "--json").json()
    assert said["system"]["setpoint"]["offset_n"] == 0.4
    model = fl.bench().controller.model  # that of the device before
    lowest = model.nominal_n * np.exp(-model.susceptibility_per_um2 * model.max_amplitude_um**2)
    assert said["before"]["law.low_n"] == pytest.approx(lowest, rel=1e-3)
    assert said["after"]["law.low_n"] == pytest.approx(0.2, abs=2**-28)


HOLD = ("controller.kp=0.04", "controller.ki=100")


@pytest.mark.slow
def test_gains_are_set_by_their_names_and_only_by_its_owner_while_a_loop_runs(frictionloop, kept):
    fl.write_toml(fl.bench(), "mine.toml")
    said = frictionloop("device", "set", "sim:", *HOLD, "--json").json()
    assert said["before"] == {"controller.kp": 10.0, "controller.ki": 2.0}
    assert said["after"] == {"controller.kp": 0.04, "controller.ki": 100.0}
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
        said = frictionloop("device", "set", "sim:", *more, "--json").json()
        assert said["after"] == {"controller.ki": 100.0, "controller.kp": 0.03, "drive.ceiling_um": 2.0}
    with fl.connect("sim:") as device:
        gains = np.asarray(device.parameters["law.gains"])
        assert gains[:2].tolist() == [0.03, 100.0]
        assert device.parameters["drive.ceiling_um"] == pytest.approx(2.0)


def test_gains_that_ring_are_refused_and_named_by_code(frictionloop, kept):
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=12"))
    assert said.startswith("controller.kp=12: unstable, rings near ") and said.endswith("[LOOP-UNSTABLE]")
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][0] == pytest.approx(10.0)  # as before
        with pytest.raises(fl.FrictionloopError) as ended:
            fl.device.configure(device, {"controller.kp": 12})
    assert ended.value.code == "LOOP-UNSTABLE"


def test_gains_that_ring_are_set_where_that_is_asked_for(frictionloop):
    said = frictionloop("device", "set", "sim:", "controller.kp=12", "--unchecked", "--json").json()
    assert said["after"] == {"controller.kp": 12.0}


def test_of_gains_and_a_value_that_is_refused_neither_is_set(frictionloop, kept):
    assert "law.high_n = 0.1 N" in refused(
        frictionloop("device", "set", "sim:", *HOLD, "law.high_n=0.1", "law.low_n=0.9")
    )
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][0] == pytest.approx(10.0)


def test_gains_close_to_ringing_are_set_with_a_finding():
    found = fl.device.configure("sim:", {"controller.kp": 0, "controller.ki": 150})
    assert [each.code for each in found.findings] == ["LOOP-NEAR"] and found.findings[0].value > 4.0


def test_gains_of_a_board_that_nobody_described_are_read_from_it_and_set_unchecked(frictionloop, kept):
    assert frictionloop("device", "set", "sim:", "law.low_n=0.2").code == 0  # of no System from now on
    found = fl.device.configure("sim:", {"controller.ki": 100, "controller.kp": 0.04})
    assert found.before == {"controller.ki": 2.0, "controller.kp": 10.0}
    assert found.after == pytest.approx({"controller.ki": 100.0, "controller.kp": 0.04})
    assert [each.code for each in found.findings] == ["NOT-CHECKED"]
    with fl.connect("sim:") as device:
        assert device.parameters["law.gains"][:2] == pytest.approx([0.04, 100.0])
        assert device.parameters["law.low_n"] == pytest.approx(0.2)  # all else stays
    fl.write_toml(fl.bench(), "mine.toml")
    assert frictionloop("device", "set", "sim:", "--system", "mine.toml", *HOLD).code == 0


def test_what_a_board_that_nobody_described_cannot_tell_needs_its_system(frictionloop, kept):
    assert frictionloop("device", "set", "sim:", "law.low_n=0.2").code == 0
    said = refused(frictionloop("device", "set", "sim:", "controller.kind=notch_pi"))
    assert said.startswith("controller.kind: accepted controller.kp, controller.ki; ")
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=-1"))
    assert said == "controller.kp = -1 N/N: must be greater than or equal to 0"
    assert frictionloop("device", "set", "sim:", "law.hash=0").code == 0
    said = refused(frictionloop("device", "set", "sim:", "controller.kp=1"))
    assert said.startswith("law = 'lookup': must be pi; ")


@pytest.mark.slow
def test_another_law_needs_another_image(frictionloop, kept):
    said = refused(frictionloop("device", "set", "sim:", "controller.kind=notch_pi", "controller.kp=0.05"))
    assert "(pi) or 0 (lookup)" in said and "firmware build FILE" in said
    assert fl.device.info("sim:").law == "pi"


HELD = {"controller.kp": 0.03, "controller.ki": 60.0}


def test_a_low_ceiling_is_named_where_the_force_stays_high():
    low = fl.device.run("sim:", fl.bench().evolve(HELD | {"board.ceiling_um": 0.5}), 0.5)
    (held,) = (each for each in low.findings if each.code == "AT-CEILING")
    assert (held.value, held.limit, low.at_ceiling) == (0.5, 2.5, pytest.approx(1.0))
    assert held.more["share"] == pytest.approx(100.0) and held.more["above"] > 20.0


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
    assert said["saved"] == {"run": str(path), "figure": str(figure)}
    assert (said["schema"], said["state"], "recording" in said) == ("device.run/1", "closed", False)
    assert figure.read_text(encoding="utf-8").lstrip().startswith("<?xml")


@pytest.mark.parametrize("device_knows_f_a", [True, False])
def test_a_loop_that_rings_is_found(monkeypatch, device_knows_f_a):
    if not device_knows_f_a:
        monkeypatch.setattr(simulated_boards.BenchPipe, "felt", lambda *_: None)
    rings = fl.device.run("sim:", fl.bench(), 0.5)
    assert "LOOP-UNSTABLE" in [each.code for each in rings.findings] and rings.saturation_index > 0.5
    assert (rings.rms_error_n is None) != device_knows_f_a
    held = fl.device.run("sim:", fl.bench().evolve(HELD), 0.5)
    assert held.findings == () and held.measured_rms_error_n < 0.2 * rings.measured_rms_error_n


def test_open_loop_does_not_ring():
    found = fl.device.run("sim:", fl.bench(), 0.2, open_loop=True)
    assert (found.state, found.findings) == ("open", ())


def test_a_file_or_a_preset_and_not_both(frictionloop, tmp_path):
    arguments = ("device", "run", "sim:", "--open", "--duration-s", "0.1")
    assert frictionloop(*arguments, "--preset", "bench").code == 0
    fl.write_toml(fl.bench(), tmp_path / "mine.toml")
    assert "[TWO-SYSTEMS]" in refused(frictionloop(*arguments, "mine.toml", "--preset", "bench"))


def test_a_run_in_which_no_finger_slides_has_no_error(frictionloop):
    said = frictionloop("device", "run", "sim:", "--open", "--duration-s", "0.002", "--json").json()
    assert said["counted"] == 0 and said["measured_rms_error_n"] is None


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
    assert answer.code == 0
    assert fl.load(tmp_path / "run.h5").f_r.values == pytest.approx(0.55, abs=2e-4)


def test_a_device_that_knows_no_force_on_the_finger_is_drawn(frictionloop, monkeypatch, tmp_path):
    monkeypatch.setattr(simulated_boards.BenchPipe, "felt", lambda *_: None)
    answer = frictionloop("device", "run", "sim:", *LOOKUP, "--duration-s", "0.1", "--out", "run.h5", "--plot", "r.svg")
    assert (answer.code, answer.err) == (0, "")
    assert "f_a" not in fl.load(tmp_path / "run.h5")
    assert (tmp_path / "r.svg").stat().st_size > 10_000


@pytest.mark.parametrize("out", ["cut.h5", None])
def test_a_fault_in_mid_run_is_one_line_and_keeps_the_recording(frictionloop, tmp_path, out):
    arguments = ("device", "run", "sim:", *SLIPPERY, "--duration-s", "0.4")
    said = refused(frictionloop(*arguments, *(("--out", out) if out else ()), "--json"))
    kept = out or "interrupted-run.h5"
    assert re.match(r"fault force_range at tick \d+: .*: 2\.4\d* N; \d+ samples are in", said)
    assert said.endswith(f" {kept}  [FAULT-FORCE-RANGE]")
    run = fl.load(tmp_path / kept)
    assert run.sizes["time"] == int(said.split("; ")[1].split()[0]) > 100
    # The force was about to leave what the sensor takes.
    assert 0.9 * fl.bench().sensor.range_n < float(np.abs(run.f_m).max()) <= fl.bench().sensor.range_n


def test_the_bench_that_ends_in_mid_run_is_one_line(frictionloop, tmp_path):
    sweep = {"kind": "log_sweep", "offset_n": 0.1, "start_hz": 1, "stop_hz": 10, "sweep_s": 0.15}
    flags = [word for name, value in sweep.items() for word in (f"--disturbance.{name}", value)]
    said = refused(frictionloop("device", "run", "sim:", *LOOKUP, *flags, "--duration-s", "0.3", "--out", "cut.h5"))
    assert "disturbance.sweep_s = 0.15 s is over" in said and "are in cut.h5" in said
    assert fl.load(tmp_path / "cut.h5").sizes["time"] < 750


def test_ctrl_c_says_where_the_recording_is(frictionloop, monkeypatch, tmp_path):
    def impatient(*_):
        def stop(samples):
            if samples > 250:
                raise KeyboardInterrupt

        return stop

    monkeypatch.setattr(run_accuracy, "_steps", impatient)
    answer = frictionloop("device", "run", "sim:", *LOOKUP, "--duration-s", "1", "--out", "cut.h5")
    count = fl.load(tmp_path / "cut.h5").sizes["time"]
    assert 250 < count < 1000
    assert (answer.code, answer.out) == (130, "")
    assert answer.err == f"interrupted: {count} samples are in cut.h5\n"


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
            boards[address] = simulated_boards.BenchPipe(simulated_boards.Simulated(system), system, seed)
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
    with fl.connect("sim:") as device, pytest.raises(fl.DeviceError, match=r"fault force_range: clear\(\) it first"):
        device.run(0.5, 0.5)
    assert frictionloop(*first).code == 0 and kept["sim:"] is board
    assert asked == ["done", "done"]


# --------------------------------------------------------------------------------------------------------------- clear


def test_a_fault_is_cleared_and_named(frictionloop, kept):
    assert fl.device.clear("sim:").fault is None
    fail()
    said = refused(frictionloop("device", "clear", "sim:"))
    assert said.startswith("fault force_range lasts: ") and said.endswith("[FAULT-FORCE-RANGE]")
    assert frictionloop("device", "set", "sim:", "safety.force_limit_n=2").code == 0
    assert frictionloop("device", "clear", "sim:", "--json").json()["fault"] == "force_range"
    assert frictionloop("device", "clear", "sim:").out == "cleared  no fault\n"


def test_a_board_that_tells_no_sample_is_not_cleared(frictionloop, monkeypatch):
    monkeypatch.setattr(fl.Device, "stream", lambda *_: iter(()))
    assert "sim:: sends no samples" in refused(frictionloop("device", "clear", "sim:"))


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


# What the ROM of the chip looks for: the tag of the flash's words, 4 KB further the image's, which say where they are.
def head(tag=b"FCFB", entry=0x6000_1030, itself=0x6000_1000, begin=0x6000_0000):
    vectors = struct.pack("<8I", 0x432000D1, entry, 0, 0, 0x6000_1020, itself, 0, 0)
    return tag.ljust(0x1000, b"\xff") + vectors + struct.pack("<3I", begin, 0x1040, 0).ljust(32, b"\xff")


def upper(address):
    """Return the record that gives the upper half of the addresses that follow."""
    body = bytes([2, 0, 0, 4]) + address.to_bytes(2, "big")
    return f":{(body + bytes([-sum(body) % 256])).hex().upper()}\n"


def records(content):
    return upper(0x6000) + "".join(record(k, content[k : k + 16]) for k in range(0, len(content), 16))


ENDS = ":00000001FF\n"
TEENSY = records(head()) + ENDS


@pytest.mark.parametrize("name", ["teensy_loader_cli", "teensy-loader-cli"])
def test_the_loader_is_told_the_board_and_the_image(frictionloop, loader, name):
    arguments = loader(name)
    answer = frictionloop("device", "flash", "image.hex")
    assert (answer.code, answer.out) == (0, "flashed  image.hex, 4,160 bytes\n")
    assert arguments.read_text().split("\n") == ["--mcu=TEENSY41", "-w", "-v", "image.hex"]


def test_a_loader_that_fails_is_said(frictionloop, loader):
    loader(code=3)
    answer = frictionloop("device", "flash", "image.hex")
    assert answer.code == 2 and answer.out == ""
    assert "error: teensy_loader_cli: exit code 3; " in answer.err


def test_a_loader_that_is_missing_is_named_with_where_to_get_it(frictionloop, loader):
    said = refused(frictionloop("device", "flash", "image.hex"))
    assert said.startswith("teensy_loader_cli: not installed, https://www.pjrc.com")


@pytest.mark.parametrize("image", ["image.elf", "other.hex"])
def test_an_image_that_is_none_never_reaches_the_loader(frictionloop, loader, image):
    arguments = loader()
    said = refused(frictionloop("device", "flash", image))
    assert said.startswith(f"IMAGE = '{image}': ") and said.endswith("  [BAD-IMAGE]")
    assert not arguments.exists()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (records(bytes(0x1040)) + ENDS, "is no image of a Teensy 4.1"),
        (records(head(tag=b"FCFA")) + ENDS, "is no image of a Teensy 4.1"),
        (records(head(entry=0x2000_0000)) + ENDS, "is no image of a Teensy 4.1"),
        (records(head(itself=0x6000_0000)) + ENDS, "is no image of a Teensy 4.1"),
        (records(head(begin=0)) + ENDS, "is no image of a Teensy 4.1"),
        (records(head()[:0x1000]) + ENDS, "is no image of a Teensy 4.1"),
        (records(head()), "cut off"),
        (TEENSY.replace("46434642", "46434643"), "no Intel hex (Record at line 2 has invalid checksum)"),
        ("not hex\n", "no Intel hex (Hex file contains invalid record at line 1)"),
        ("", "cut off"),
        ("\u00b5", "no Intel hex"),
    ],
)
def test_an_image_of_another_board_never_reaches_the_loader(frictionloop, loader, tmp_path, content, says):
    arguments = loader()
    (tmp_path / "image.hex").write_text(content, encoding="utf-8")
    assert says in refused(frictionloop("device", "flash", "image.hex"))
    assert not arguments.exists()


def test_gains_that_ring_only_with_the_resonance_off_are_refused(frictionloop):
    # Stable as described, and not with the resonance lower: what a sensor does that is not quite as written down.
    pi = {"controller.kind": "pi", "controller.kp": 0.0}
    found = 160.0
    near = fl.bench().evolve(pi | {"controller.ki": found})
    assert rings_if_linear(near).stable
    assert not rings_if_linear(near.evolve({"sensor.resonance_hz": 0.9 * 145.0})).stable
    fl.write_toml(fl.bench(), "mine.toml")
    arguments = ("controller.kind=pi", "controller.kp=0", f"controller.ki={found}", "--system", "mine.toml")
    said = refused(frictionloop("device", "set", "sim:", *arguments))
    assert "resonance -10 %" in said and "--unchecked" in said
