"""Bad input: one line on stderr that names what is wrong, exit code 2, nothing on stdout, no traceback."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

KP = ("sweep", "--over", "controller.kp=1,2", "--duration-s", "0.01")
SIMULATE = [
    (("--controller.kpp", "3"), "unknown parameter 'controller.kpp'; did you mean controller.kp (N/N)"),
    (("--controller.delay_us", "3"), "did you mean controller.delay_s = 3e-06 s?"),
    (("--controller.kp",), "--controller.kp: needs a value"),
    (("--controller.kp", "--json"), "--controller.kp: needs a value"),
    (("--controller.kp", "nan"), "controller.kp = nan N/N: must be a finite number"),
    (("--controller.kp=-3",), "controller.kp = -3 N/N: must be greater than or equal to 0"),
    (("--friction.susceptibility_per_um2", "-1"), "friction.susceptibility_per_um2 = -1 um^-2: must be greater than 0"),
    (("--plate.q", "200"), "plate.kind = resonant has it"),
    (
        ("--disturbance.path", "x.csv"),
        "disturbance.kind = recording has it",
    ),
    (("--setpoint.offset_n", "0.5 N"), "setpoint.offset_n = '0.5 N' N: must be a valid number"),
    (("--kp", "12"), "Unknown option: --kp. Did you mean --controller.kp?"),
    (("--speed", "20"), "Unknown option: --speed. Did you mean --motion.speed_mm_s?"),
    (("--setpoint", "3"), "Unknown option: --setpoint. Did you mean --setpoint.kind?"),
    (("--setpoint.kind", "sinus"), "setpoint.kind = 'sinus' is unknown; accepted: 'constant', 'sine'"),
    (
        ("--disturbance.kind", "recording", "--disturbance.path", "no.csv", "--disturbance.offset_n", "0.4"),
        "no.csv: there is no such file",
    ),
    (("--preset", "papr"), 'Invalid value "papr" for --preset. Choose from: "paper", "feasible", "bench"'),
    (("--setpoint.kind", "steps", "--setpoint.levels_n", "[.4, 0.6]"), "[.4, 0.6]: accepted a list such as [0.4"),
    (("--split", "3"), "Unknown option: --split. Did you mean --split-hz?"),
    (("--jobs", "3"), "Unknown option: --jobs. simulate has none; it belongs to `sweep`, `compare`"),
    (("--sed", "3"), "Unknown option: --sed. Did you mean --seed?"),
    (("--seed", "x"), "Invalid value for --seed"),
    (("--seed", "1.5"), 'Invalid value for --seed: unable to convert "1.5" into a whole number'),
    (("--seed",), "--seed requires an argument"),
    (("--seed", "-1"), "seed = -1: must be a whole number from 0"),
    (("--seed", str(2**64)), "must be a whole number from 0 to 9223372036854775807"),
    (("a.toml", "b.toml"), "b.toml: not expected here"),
    (("no.toml",), "no.toml: cannot be read (No such file or directory)"),
    (("no.toml", "--preset", "paper"), "no.toml and --preset paper: "),
    (("--duration-s", "0"), "duration_s = 0 s: "),
    (("--duration-s", "nan"), "duration_s = nan s: must be a positive number"),
    (("--duration-s", "0.00013"), "whole periods of controller.rate_hz = 5000 Hz, as 0.0002"),
    (
        ("--duration-s", "11"),
        "duration_s = 11 s: must be at most setpoint.sweep_s = 10",
    ),
    (("--setpoint.sweep_s", "1e7", "--duration-s", "1e7"), "5600.0 GB"),
    (("--score-from-s", "10"), "score_from_s = 10 s: must be from 0 s to less than duration_s = 10 s"),
    (("--score-from-s", "-1"), "score_from_s = -1 s: must be from 0 s"),
    (("--out", "run.txt"), "out = 'run.txt': must end in .h5 or .hdf5 or .nc"),
    (("--out", "run.csv"), "how-to/read-the-results-elsewhere.md"),
    (("--out", "no/run.h5"), "out = 'no/run.h5': there is no folder 'no'"),
    (("--plot", "run.gif"), "plot = 'run.gif': must end in .svg or .pdf or .png"),
    (("--save-system", "bench.yaml"), "--save-system = 'bench.yaml': must end in .toml"),
    (("--json=3",), "Invalid value for --json"),
]
SWEEP = [
    ((), "over: give --over NAME=VALUES, such as controller.kp=1,2,5, or --fingers N"),
    (("--over",), "--over requires an argument"),
    (("--over", "controller.kp=1", "--fingers", "3"), "over: give --over NAME=VALUES"),
    (("--over", "controller.kp=1", "--fingers-seed", "3"), "fingers_seed = 3: accepted with --fingers N"),
    (("--fingers", "3"), 'friction.kind = "gaussian": must be "finger", as in bench()'),
    (("--fingers", "0"), "fingers = 0: must be a whole number from 1 to 1000000"),
    (("--fingers", "500000", "--seeds", "4"), "fingers = 500000: must be a whole number from 1 to 250000"),
    (("--fingers", "2.5"), "Invalid value for --fingers"),
    (("--fingers", "3", "--fingers-seed", "-1"), "fingers_seed = -1: must be a whole number from 0"),
    (("--over", "controller.kp"), "over = 'controller.kp': must be NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2"), "must be NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:x"), "must be NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:3:lag"), "must be NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=1:2:3:log:log"), "must be NAME=a,b,c or NAME=start:stop:count"),
    (("--over", "controller.kp=0:2:3:log"), "must have ends above 0 for log"),
    (("--over", "controller.kp=1:inf:3"), "must have finite ends and 2 to"),
    (("--over", "controller.kp=1:2:1"), "must have finite ends and 2 to"),
    (("--over", "controller.kp=1,a"), "controller.kp = 'a' N/N: must be a valid number"),
    (("--over", "controller.kp=1,,2"), "controller.kp = '' N/N: must be a valid number"),
    (("--over", "controller.kp=1", "--seeds", "1.5"), "Invalid value for --seeds"),
    (("--over", "controller.kp=1", "--jobs", "1.5"), "Invalid value for --jobs"),
    (("--over", "controller.kpp=1,2"), "unknown parameter 'controller.kpp'"),
    (("--over", "setpoint.kind=sine,sinus"), "setpoint.kind = 'sinus' is unknown"),
    (("--over", "controller.kp=1", "--over", "controller.kp=2"), "controller.kp is there twice"),
    (
        ("--over", "controller.kp=1:2:9999", "--over", "controller.ki=1:2:9999"),
        "99980001 runs; must be at most 20000000",
    ),
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
BENCH = [
    (("--plate.q", "0"), "plate.q = 0: must be greater than 0"),
    (("--plate.cutoff_hz", "90"), "unknown parameter 'plate.cutoff_hz'"),
    (("--sensor.resonance_hz", "-1"), "sensor.resonance_hz = -1 Hz: must be greater than 0"),
    (("--sensor.noise_rms_n", "1"), "unknown parameter 'sensor.noise_rms_n'; did you mean sensor.noise_density_n_rthz"),
    (("--sensor.adc_bits", "1.5"), "sensor.adc_bits = 1.5: must be a valid integer"),
    (("--controller.jitter_s", "2"), "controller.jitter_s = 2 s: must be less than or equal to 1"),
    (("--controller.lost_ticks", "1"), "controller.lost_ticks = 1: must be less than 1"),
    (("--controller.rate_hz", "20"), "controller.rate_hz = 20 Hz: must be at least"),
    (("--finger.kind", "soft"), "finger.kind = 'soft' is unknown; accepted: 'rigid', 'skin'"),
    (("--finger.slip_length_um", "glue"), "slip_length_um = 'glue' um: must be a valid number"),
    (("--finger.stiffness", "1"), "unknown parameter 'finger.stiffness'; did you mean finger.stiffness_n_m (N/m)"),
    (("--motion.kind", "sliding"), 'motion.kind = "strokes"'),
    (("--motion.load_n", "-1"), "motion.load_n = -1 N: must be greater than 0"),
    (("--motion.speed_mm_s", "600"), "touch.position.fastest_mm_s"),
    (("--motion.contact_s", "0.01"), "contact_s = 0.01 s: "),
    (("--touch.position.noise", "3"), "did you mean touch.position.noise_um (um)"),
    (("--touch.position.noise_um", "-3"), "touch.position.noise_um = -3 um: must be greater than or equal to 0"),
    (("--touch.noise_um", "3"), "unknown parameter 'touch.noise_um'; did you mean touch.position.noise_um (um)"),
]
SWEEP_BENCH = [
    (("--fingers", "3", "--finger.kind", "rigid"), 'finger.kind = "rigid": must be "skin"'),
    (("--fingers", "3", "--motion.load-n", "1"), "motion.load_n: each finger brings its own"),
    (("--over", "controller.kp=1,2", "--loads", "0.4,1.2"), "loads: accepted with --fingers N"),
    (("--fingers", "3", "--metrics", "rise_63_s"), "metric rise_63_s: "),
    (("--over", "finger.kind=skin,soft"), "finger.kind = 'soft' is unknown; accepted: 'rigid', 'skin'"),
    (("--over", "motion.speed_mm_s=20,600"), "touch.position.fastest_mm_s"),
]
VERBS = "reproduce, simulate, sweep, compare, studio, explain, design, effect, identify, firmware, experiment, device"
VERBS_WITHOUT_A_LOOP = [
    (("design", "nothing"), 'Unknown command "nothing". Available commands: sensor, plate, controller, check, limits.'),
    (("design", "sensor", "--adc.bits", "0"), "adc.bits = 0: must be greater than or equal to 4"),
    (("design", "sensor", "--range-n", "x"), 'Invalid value for --range-n: unable to convert "x"'),
    (("design", "sensor", "--noise-rms-n", "0"), "noise_rms_n = 0 N: must be finite and above 0"),
    (("design", "sensor", "--electrodes.gap", "3"), "did you mean electrodes.gap_um (um)"),
    (("design", "sensor", "--spice", "x.txt"), "spice = 'x.txt': must end in .cir"),
    (("design", "plate", "--frequency-hz", "-5"), "frequency_hz = -5 Hz: must be finite and above 0"),
    (("design", "plate", "--bandwidth-hz", "nan"), "bandwidth_hz = nan Hz: must be finite and above 0"),
    (("design", "plate", "--geometry.thick", "3"), "did you mean geometry.thickness_mm (mm)"),
    (("design", "plate", "extra"), "extra: not expected here"),
    (("firmware", "build", "--out", "img", "--board", "uno"), "board = 'uno'"),
    (("device", "info"), "parameter ADDRESS requires an argument"),
    (("device", "info", "COM3"), "serial://COM3"),
    (("device", "run", "sim:", "--decimation", "1.5"), 'unable to convert "1.5" into a whole number'),
    (("device", "run", "sim:", "--duration-s", "1e9"), "duration_s = 1e+09 s: "),
    (("device", "set", "sim:", "controller.kp=1", "controller.kp=2"), "controller.kp = 2: "),
    (("device", "flash", "x.hex"), "IMAGE = 'x.hex': "),
    (("simulate", "--whole"), "whole = True: must be with --save-system FILE.toml"),
    (
        ("simulate", "--setpoint.kind", "steps", "--setpoint.times_s", "0,1", "--setpoint.levels_n", "0.4"),
        "setpoint.levels_n = 0.4 N: must be a list, such as [0.4, 0.8]",
    ),
    (("simulate", "--use", "nosuch"), "--use nosuch: no such module"),
]
OTHERS = [
    (("simulat",), 'Unknown command "simulat". Did you mean "simulate"?'),
    (("--bogus",), f'Unknown command "--bogus". Available commands: {VERBS}.'),
    (("reproduce", "x"), "x: not expected here"),
]
ALL = [
    *((("simulate", *tokens), line) for tokens, line in SIMULATE),
    *((("sweep", *tokens), line) for tokens, line in SWEEP),
    *(((*KP, *tokens), line) for tokens, line in SWEEP_KP),
    *((("simulate", "--preset", "bench", *tokens), line) for tokens, line in BENCH),
    *((("sweep", "--preset", "bench", *tokens), line) for tokens, line in SWEEP_BENCH),
    *VERBS_WITHOUT_A_LOOP,
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
        (b"schema = 99", "bench.toml: schema = 99: "),
        (b"x = [", "bench.toml: is not TOML"),
        (b"\xff\xfe\x00", "bench.toml: is no UTF-8"),
        (b"[controller]\nkp = 3", "bench.toml: setpoint is missing"),
        (b'preset = "paper"\n[controller]\nkp = -3', "bench.toml: controller.kp = -3 N/N: must be greater"),
        (b'preset = "bank"', "bench.toml: preset = 'bank' is unknown; accepted: 'paper', 'feasible', 'bench'"),
        (b'preset = "bench"\n[plate]\nq = 0', "bench.toml: plate.q = 0: must be greater than 0"),
        (b'preset = "bench"\n[touch.load]\nnoise = 0', "bench.toml: unknown parameter 'touch.load.noise'"),
    ],
)
def test_file_is_named(frictionloop, content, line):
    Path("bench.toml").write_bytes(content)
    assert line in only_line(frictionloop("simulate", "bench.toml"))


def test_system_file_is_never_replaced(frictionloop):
    Path("bench.toml").write_text("# edited by hand\n")
    assert "delete it first" in only_line(frictionloop("simulate", "--save-system", "bench.toml"))
    assert Path("bench.toml").read_text() == "# edited by hand\n"


@pytest.mark.parametrize("tokens", [("simulate", "--duration-s", "0.01"), KP], ids=["simulate", "sweep"])
def test_output_that_is_a_folder(frictionloop, tokens):
    Path("run.h5").mkdir()
    assert "run.h5: cannot be written (Is a directory)" in only_line(frictionloop(*tokens, "--out", "run.h5"))


@pytest.mark.parametrize(
    ("tokens", "option"),
    [
        (("simulate",), "--out = '/proc/run.h5'"),
        (("sweep", "--controller.kp", "1,2"), "--csv = '/proc/run.csv'"),
        (("compare",), "--plots = '/proc/figures'"),
        (("compare",), "--csv = '/proc/scores.csv'"),
        (("design", "controller"), "--plots = '/proc/figures'"),
    ],
)
def test_a_folder_that_takes_no_file_is_found_before_any_work(frictionloop, tokens, option):
    name, _, path = option.partition(" = ")
    line = only_line(frictionloop(*tokens, name, path.strip("'")))
    assert line == f"error: {option}: nothing can be written in '/proc' (No such file or directory)\n"


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


def test_a_parameter_that_is_given_twice_is_refused(frictionloop):
    answer = frictionloop("simulate", "--controller.kp", "1", "--controller.ki", "2", "--controller.kp", "3")
    assert (answer.code, answer.noted) == (2, ["error: --controller.kp: is given more than once"])
