"""Bad input: one line on stderr that names what is wrong, exit code 2, nothing on stdout, no traceback."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

KP = ("sweep", "--over", "controller.kp=1,2", "--duration-s", "0.01")
SIMULATE = [
    (("--controller.kpp", "3"), "unknown parameter 'controller.kpp'; did you mean controller.kp (N/N)"),
    (("--controller.delay_us", "3"), "did you mean controller.delay_s (s)"),
    (("--controller.kp",), "--controller.kp: needs a value"),
    (("--controller.kp", "--json"), "--controller.kp: needs a value"),
    (("--controller.kp", "nan"), "controller.kp = nan N/N: must be a finite number"),
    (("--controller.kp=-3",), "controller.kp = -3 N/N: must be greater than or equal to 0"),
    (("--friction.susceptibility_per_um2", "-1"), "friction.susceptibility_per_um2 = -1 um^-2: must be greater than 0"),
    (("--setpoint.offset_n", "0.5 N"), "setpoint.offset_n = '0.5 N' N: must be a valid number"),
    (("--setpoint.kind", "sinus"), "setpoint.kind = 'sinus' is unknown; accepted: 'constant', 'sine'"),
    (("--disturbance.kind", "recording", "--disturbance.path", "no.csv"), "no.csv: there is no such file"),
    (("--preset", "papr"), 'Invalid value "papr" for --preset. Choose from: "paper", "feasible"'),
    (("--sed", "3"), "Unknown option: --sed. Did you mean --seed?"),
    (("--seed", "x"), "Invalid value for --seed"),
    (("--seed", "1.5"), 'Invalid value for --seed: unable to convert "1.5" into a whole number'),
    (("--seed",), "--seed requires an argument"),
    (("--seed", "-1"), "seed = -1: must be a whole number from 0"),
    (("--seed", str(2**64)), "must be a whole number from 0 to 9223372036854775807"),
    (("a.toml", "b.toml"), "b.toml: not expected here"),
    (("no.toml",), "no.toml: cannot be read (No such file or directory)"),
    (("no.toml", "--preset", "paper"), "no.toml and --preset paper both name a system"),
    (("--duration-s", "0"), "duration_s = 0.0 s: must be a positive number"),
    (("--duration-s", "nan"), "duration_s = nan s: must be a positive number"),
    (("--duration-s", "0.00013"), "not a whole number of control periods at controller.rate_hz = 5000 Hz; nearest: "),
    (("--duration-s", "11"), "duration_s = 11 s runs past the end of setpoint.sweep_s = 10 s"),
    (("--setpoint.sweep_s", "1e7", "--duration-s", "1e7"), "needs 5600.0 GB of memory"),
    (("--score-from-s", "10"), "score_from_s = 10 s: must be from 0 s to less than duration_s = 10 s"),
    (("--score-from-s", "-1"), "score_from_s = -1 s: must be from 0 s"),
    (("--out", "run.txt"), "out = 'run.txt': must end in .h5 or .hdf5 or .nc"),
    (("--out", "no/run.h5"), "out = 'no/run.h5': there is no folder 'no'; create it first"),
    (("--plot", "run.gif"), "plot = 'run.gif': must end in .svg or .pdf or .png"),
    (("--save-system", "bench.yaml"), "save_system = 'bench.yaml': must end in .toml"),
    (("--json=3",), "Invalid value for --json"),
]
SWEEP = [
    ((), "--over requires an argument"),
    (("--over", "controller.kp"), "over = 'controller.kp': accepted: NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2"), "accepted: NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:x"), "accepted: NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:3:lag"), "accepted: NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:3:log:log"), "accepted: NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=0:2:3:log"), "start and stop must be positive for log spacing"),
    (("--over", "controller.kp=1:inf:3"), "start and stop must be finite, count from 2 to"),
    (("--over", "controller.kp=1:2:1"), "start and stop must be finite, count from 2 to"),
    (("--over", "controller.kp=1,a"), "controller.kp = 'a' N/N: must be a valid number"),
    (("--over", "controller.kp=1,,2"), "controller.kp = '' N/N: must be a valid number"),
    (("--over", "controller.kp=1", "--seeds", "1.5"), "Invalid value for --seeds"),
    (("--over", "controller.kp=1", "--jobs", "1.5"), "Invalid value for --jobs"),
    (("--over", "controller.kpp=1,2"), "unknown parameter 'controller.kpp'"),
    (("--over", "setpoint.kind=sine,sinus"), "setpoint.kind = 'sinus' is unknown"),
    (("--over", "controller.kp=1", "--over", "controller.kp=2"), "controller.kp is swept twice"),
    (("--over", "controller.kp=1:2:9999", "--over", "controller.ki=1:2:9999"), "99980001 runs are more than 20000000"),
]
SWEEP_KP = [
    (("--resume",), "resume: needs --out FILE.h5"),
    (("--metrics", "r2"), "metrics = ['r2']: accepted are r2_identity"),
    (("--seeds", "0"), "seeds = 0: must be a whole number from 1"),
    (("--jobs", "0"), "jobs = 0: must be a whole number from 1"),
    (("--csv", "table.txt"), "csv = 'table.txt': must end in .csv"),
    (("--out", "no/sweep.h5"), "out = 'no/sweep.h5': there is no folder 'no'"),
    (("--score-from-s", "1"), "score_from_s = 1 s: must be from 0 s to less than duration_s = 0.01 s"),
]
OTHERS = [
    (("simulat",), 'Unknown command "simulat". Did you mean "simulate"?'),
    (("--bogus",), 'Unknown command "--bogus". Available commands: reproduce, simulate, sweep.'),
    (("reproduce", "x"), "x: not expected here"),
]
ALL = [
    *((("simulate", *tokens), line) for tokens, line in SIMULATE),
    *((("sweep", *tokens), line) for tokens, line in SWEEP),
    *(((*KP, *tokens), line) for tokens, line in SWEEP_KP),
    *OTHERS,
]


def only_line(answer):
    assert (answer.code, answer.out) == (2, "")
    assert answer.err.startswith("error: ")
    assert answer.err.count("\n") == 1
    return answer.err


@pytest.mark.parametrize(("tokens", "line"), ALL, ids=lambda value: " ".join(value) if isinstance(value, tuple) else "")
def test_one_line(frictionloop, tokens, line):
    assert line in only_line(frictionloop(*tokens))


@pytest.mark.parametrize(
    ("content", "line"),
    [
        (b"schema = 99", "bench.toml: schema = 99 is newer than this version reads"),
        (b"x = [", "bench.toml: is not TOML"),
        (b"\xff\xfe\x00", "bench.toml: cannot be read"),
        (b"[controller]\nkp = 3", "bench.toml: setpoint is missing"),
        (b'preset = "paper"\n[controller]\nkp = -3', "bench.toml: controller.kp = -3 N/N: must be greater"),
    ],
)
def test_file_is_named(frictionloop, content, line):
    Path("bench.toml").write_bytes(content)
    assert line in only_line(frictionloop("simulate", "bench.toml"))


def test_system_file_is_never_replaced(frictionloop):
    Path("bench.toml").write_text("# edited by hand\n")
    assert "exists and stays as it is" in only_line(frictionloop("simulate", "--save-system", "bench.toml"))
    assert Path("bench.toml").read_text() == "# edited by hand\n"


@pytest.mark.parametrize("tokens", [("simulate", "--duration-s", "0.01"), KP], ids=["simulate", "sweep"])
def test_output_that_is_a_folder(frictionloop, tokens):
    Path("run.h5").mkdir()
    assert "run.h5: cannot be written (Is a directory)" in only_line(frictionloop(*tokens, "--out", "run.h5"))


@pytest.mark.parametrize("option", ["--out=run.h5", "--plot=run.svg"])
def test_full_disk_leaves_the_old_file(frictionloop, monkeypatch, option):
    target = Path(option.partition("=")[2])
    target.write_bytes(b"old")

    def full(*_, **__):
        raise OSError(errno.ENOSPC, "No space left on device")

    for name in ("write_bytes", "write_text"):
        monkeypatch.setattr(Path, name, full)
    line = only_line(frictionloop("simulate", "--duration-s", "0.01", option))
    assert line == f"error: {target}: cannot be written (No space left on device); the old file is untouched\n"
    assert target.read_bytes() == b"old"
    assert [path.name for path in Path().iterdir()] == [target.name]
