"""Bad input over all verbs: wrong types, kinds and files of every sort end in one line with exit code 2."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

BENCH = 'preset = "bench"\n'


@pytest.fixture(autouse=True)
def files(frictionloop):
    """Files that are not what their names say, in the folder of the test."""
    for name in ("empty.toml", "empty.csv", "empty.h5"):
        Path(name).touch()
    for name in ("folder", "folder.toml"):
        Path(name).mkdir()
    noise = np.random.default_rng(0).integers(128, 256, 3000, dtype=np.uint8).tobytes()
    for name in ("random.toml", "random.csv", "random.h5", "random.wav", "random.mat"):
        Path(name).write_bytes(noise)
    Path("bench.toml").write_text(BENCH)
    Path("utf16.toml").write_text(BENCH, encoding="utf-16")
    Path("nan.toml").write_text(BENCH + "[controller]\nkp = nan\n")
    Path("huge.toml").write_text(BENCH + "[controller]\nkp = 1e400\n")
    Path("word.toml").write_text(BENCH + '[controller]\nkp = "a"\n')
    Path("number.toml").write_text("preset = 3\n")
    Path("flat.toml").write_text("controller = 3\n" + BENCH)
    Path("schema.toml").write_text('schema = "x"\n')
    Path("kind.toml").write_text(BENCH + '[controller]\nkind = "pid"\n')
    Path("loop.toml").symlink_to("loop.toml")
    Path("one.csv").write_text("time,force\n1,2\n")
    Path("any.json").write_text('{"a": 1}')


RECORDED = ("simulate", "--setpoint.kind", "recording", "--setpoint.path")
DESIGN = ("design", "controller")
CASES = [
    (("simulat",), 'Unknown command "simulat". Did you mean "simulate"?'),
    (("design", "controler"), 'Unknown command "controler". Did you mean "controller"?'),
    (("simulate", "empty.toml"), "empty.toml: is empty; accepted: preset ="),
    (("simulate", "folder.toml"), "folder.toml: cannot be read (Is a directory)"),
    (("simulate", "utf16.toml"), "utf16.toml: is no UTF-8 (byte 0)"),
    (("simulate", "random.toml"), "random.toml: is no UTF-8"),
    (("simulate", "loop.toml"), "loop.toml: cannot be read (Too many levels of symbolic links)"),
    (("simulate", "nan.toml"), "nan.toml: controller.kp = nan N/N: must be a finite number (line 3: 'kp = nan')"),
    (("simulate", "huge.toml"), "huge.toml: controller.kp = inf N/N: must be a finite number (line 3: 'kp = 1e400')"),
    (("simulate", "word.toml"), "word.toml: controller.kp = 'a' N/N: must be a valid number"),
    (("simulate", "number.toml"), "number.toml: preset = 3 is unknown; accepted: 'paper'"),
    (("simulate", "flat.toml"), "flat.toml: controller = 3: must be a table of values (line 1"),
    (("simulate", "schema.toml"), "schema.toml: schema = 'x': must be a whole number"),
    (("simulate", "kind.toml"), "kind.toml: controller.kind = 'pid' is unknown; accepted: 'pi'"),
    (("simulate", "bench.toml", "bench.toml"), "bench.toml: not expected here"),
    (("simulate", "--duration-s", "nan"), "duration_s = nan s: must be a positive number"),
    (("simulate", "--seed", "9" * 25), "must be a whole number from 0 to"),
    (("simulate", "--controller.kp="), "controller.kp = '' N/N: must be a valid number"),
    (("simulate", "--controller.kp", "1,2"), "controller.kp = [1, 2] N/N: "),
    (("simulate", "--controller.rate_hz", "1e12"), "must be less than or equal to 1000000000"),
    (("simulate", "--use", "empty.toml"), "--use empty.toml: no such module; files end in .py"),
    ((*RECORDED, "empty.csv"), "empty.csv: rows of numbers = 0"),
    ((*RECORDED, "folder"), "folder: is a folder; accepted is a file: .csv"),
    ((*RECORDED, "random.h5"), "random.h5: cannot be read, empty or damaged"),
    ((*RECORDED, "random.wav"), "random.wav: cannot be read, empty or damaged"),
    ((*RECORDED, "random.mat"), "random.mat: cannot be read, empty or damaged"),
    ((*RECORDED, "one.csv", "--setpoint.column", "force"), "one.csv: rate_hz is missing"),
    (("sweep", "--over", "controller.kp=nan,1"), "controller.kp = nan N/N: must be a finite number"),
    (("sweep", "--over", "controller.kp=1:2:99999999"), "2 to 20000000 values"),
    (("sweep", "--over", "controller.kp=1,2", "--jobs", "0"), "jobs = 0: must be a whole number from 1 to 1024"),
    (("compare", "--speeds", "a"), "speeds = 'a': must be numbers in mm/s with commas between"),
    (("compare", "--out", "bench.toml"), "out = 'bench.toml': must end in .h5"),
    ((*DESIGN, "--law", "pid"), "law: 'pid' is unknown; did you mean pi?"),
    ((*DESIGN, "--speeds", "60,20"), "speeds = '60,20': must be mm/s, such as 20,60"),
    ((*DESIGN, "--corners", "any.json"), "any.json = 'no corners': must be a certificate"),
    ((*DESIGN, "--resonance-error", "nan"), "resonance_error = nan: must be from 0 to 0.25"),
    ((*DESIGN, "--preset", "paper", "--law", "notch_pi"), "sensor.kind = 'lowpass': "),
    (
        ("design", "sensor", "bench.toml"),
        "bench.toml: describes a bench (has preset); must be a design of a sensor",
    ),
    (("design", "sensor", "--resonance-hz", "nan"), "resonance_hz = nan Hz: must be finite and above 0"),
    (("design", "plate", "--frequency-hz", "-1"), "frequency_hz = -1 Hz: must be finite and above 0"),
    (("identify", "channels", "folder"), "folder: is a folder; accepted is a file"),
    (("identify", "channels", "empty.csv"), "empty.csv: is empty"),
    (("effect", "show", "bench.toml"), "bench.toml: "),
    (("firmware", "export", "--out", "bench.toml"), "out = 'bench.toml': must be a folder"),
    (("device", "info", "nope"), "address = 'nope': "),
    (("device", "set", "sim:", "controller.kp=nan"), "controller.kp = "),
    (("experiment", "check", "bench.toml"), "bench.toml: "),
    (("experiment", "report", "folder"), "folder"),
    (("reproduce", "--out", "bench.toml"), "bench.toml"),
    (("studio", "--port", "99999999"), "port = 99999999"),
]


@pytest.mark.parametrize(("tokens", "said"), CASES, ids=lambda each: " ".join(each) if isinstance(each, tuple) else "")
def test_bad_input_is_one_line(frictionloop, tokens, said):
    answer = frictionloop(*tokens)
    assert (answer.code, answer.out) == (2, "")
    (line,) = answer.noted
    assert line.startswith("error: ")
    assert said in line
    assert "Traceback" not in line
