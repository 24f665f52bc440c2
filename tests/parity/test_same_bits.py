"""The C core gives the same bits whatever compiles it, and does nothing undefined, whatever it is given."""

from __future__ import annotations

import shutil
import subprocess
from importlib.util import find_spec
from zlib import crc32

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware.compiled_core import host_library, host_sources
from frictionloop.firmware.compiler import FLAGS, zig
from frictionloop.quantities.schema import parameter_words, word_count

MODEL = fl.bench().controller.model
AHEAD = {"feedforward": True, "overdrive": True, "model": MODEL}
SECTIONS = (
    (0.32, -0.62, 0.31, -0.16, 0.09),
    (0.82, 0.59, -0.23, 0.52, 0.0),
    (1.01, -1.995, 0.989, -1.995, 0.996),
    (1.36, -0.035, 0.001, -0.85, 0.45),
    (0.998, -1.994, 0.9965, -1.994, 0.9945),
    (1.15, -1.896, 0.756, -1.961, 0.962),
)
CONTROLLERS = {
    "pi": fl.bench().controller,
    "lookup": fl.LookupController(overdrive=True, model=MODEL),
    "notch": fl.NotchPiController(delay_s=330e-6, **AHEAD),
    "limit observer": fl.bench().evolve({"controller.kind": "limit_observer"}).controller,
    "six sections": fl.FilteredPiController(sections=SECTIONS, kp=12.8, ki=531.0, **AHEAD),
}
BUILDS = [(name, level) for name in ("gcc", "clang", "zig") for level in ("-O0", "-O2", "-Os")]
SANITIZED = ("-std=c11", "-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
STATES = 21


def command_of(name):
    if not (find_spec("ziglang") if name == "zig" else shutil.which(name)):
        pytest.skip(f"{name} is not installed")
    return zig() if name == "zig" else (name,)


def digest(parity, library=None):
    """CRC of all that the laws do over 1e5 ticks."""
    rows, setpoints = parity.quantised(*parity.wild(100_000 // len(CONTROLLERS), 9))[0]
    crc = 0
    for controller in CONTROLLERS.values():
        law = parity.FixedLaw(controller, library)
        for array in (law.run(rows, setpoints), law.state, law.believed):
            crc = crc32(array.tobytes(), crc)
    return crc


@pytest.mark.slow
@pytest.mark.parametrize(("name", "level"), BUILDS)
def test_every_compiler_gives_the_same_bits(parity, name, level):
    flags = (*(flag for flag in FLAGS if flag != "-O2"), level)
    assert digest(parity, host_library(flags, command_of(name))) == digest(parity)


@pytest.fixture(scope="module")
def replay(tmp_path_factory):
    """The core under the sanitizers: bytes of records in, bytes out."""
    if not shutil.which("cc"):
        pytest.skip("cc is not installed")
    folder = tmp_path_factory.mktemp("replay")
    probe, program = folder / "probe.c", folder / "replay"
    probe.write_text("int main(void) { return 0; }\n")
    if subprocess.run(["cc", *SANITIZED, probe, "-o", program], check=False, capture_output=True).returncode:
        pytest.skip("cc has no sanitizers")
    sources, folders = host_sources()
    given = [*(f"-I{each}" for each in folders), *sources, __file__.replace("test_same_bits.py", "replay.c")]
    subprocess.run(["cc", *SANITIZED, *given, "-o", program], check=True, capture_output=True)

    def run(records):
        done = subprocess.run([program], input=records, check=False, capture_output=True)
        assert done.returncode == 0, done.stderr.decode()[:1000]
        return done.stdout

    return run


def record(words, state, rows, setpoints):
    arrays = (np.array([len(rows)]), words, np.pad(state, (0, STATES - len(state))), rows, setpoints)
    return b"".join(np.ascontiguousarray(array, dtype=np.int32).tobytes() for array in arrays)


@pytest.mark.slow
def test_sanitizers_find_nothing_and_change_nothing(parity, replay):
    rows, setpoints = parity.quantised(*parity.wild(100_000 // len(CONTROLLERS), 9))[0]
    for controller in CONTROLLERS.values():
        law = parity.FixedLaw(controller)
        got = replay(record(law.words, law.state, rows, setpoints))
        commands = law.run(rows, setpoints)
        states = np.pad(law.state, (0, STATES - len(law.state)))
        assert got == commands.tobytes() + states.tobytes() + law.believed.tobytes()


@pytest.mark.slow
def test_nothing_is_undefined_for_any_parameters_within_their_ranges(replay):
    rng, (_, library) = np.random.default_rng(10), host_library()
    built = [number for number in range(1, 7) if library.fl_host_states(number) >= 0]
    records = []
    for k in range(200):
        table = np.zeros(word_count(), dtype=np.int64)
        for word in parameter_words().values():
            place = slice(word.first, word.first + word.words)
            table[place] = any_words(rng, word)
        table[0] = built[k % len(built)]
        inputs = extreme(rng, (100, 6))
        inputs[:, 4] = rng.integers(0, 2, 100)
        records.append(record(table, extreme(rng, STATES), inputs[:, :5], inputs[:, 5]))
    assert len(replay(b"".join(records))) == 200 * 4 * (3 * 100 + STATES + 1)


def any_words(rng, word):
    """Words of a parameter anywhere in its range."""
    if word.format == "gain":
        pairs = np.column_stack([extreme(rng, word.count), rng.integers(-1, 63, word.count)])
        return pairs.ravel()
    scale = {"q28": 2.0**28, "q25": 2.0**25, "count": 1.0}[word.format]
    low = -(2**31) if word.low is None else round(word.low * scale)
    high = 2**31 - 1 if word.high is None else min(round(word.high * scale), 2**31 - 1)
    return np.clip(extreme(rng, word.count), low, high)


def extreme(rng, shape):
    """Words of any size, the ends among them."""
    sizes = rng.integers(-(2**31), 2**31, shape) >> rng.integers(0, 31, shape)
    return np.where(rng.random(shape) < 0.1, rng.choice([-(2**31), 2**31 - 1, 0, 1, -1], shape), sizes)
