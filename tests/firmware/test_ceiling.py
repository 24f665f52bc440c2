"""Whatever table, readings and bytes come: never more than the ceiling, never undefined behaviour."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.control.laws import LAWS
from frictionloop.device.codec import encode
from frictionloop.device.simulated_boards import HostBoard, Sample
from frictionloop.firmware.image_law import board_law
from frictionloop.quantities.protocol_schema import firmware_folder, parameter_words
from tests.helpers.host_frames import SESSION, hello

WATCHED = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all", "-g", "-O1"]
"""Reading beyond an array, overflow, a shift too far: each ends the program."""
AT = {name: word.first for name, word in parameter_words().items()}


def build(
    folder: Path,
    compiler: list[str],
    *flags: str,
    changed: Path | None = None,
    beside: Path | None = None,
    law: str = "filtered_pi",
) -> Path:
    """Compile and link the core with what drives it, or one changed file with what was compiled in another folder."""
    core, program = firmware_folder() / "core", folder / "wild"
    own = Path(__file__).parent / "wild.c", board_law(LAWS[law]).write(folder)
    sources = [changed] if changed else [*sorted(core.glob("*.c")), *own]
    given = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", f"-I{core}", *flags]
    subprocess.run([*compiler, *given, "-c", *sources], cwd=folder, check=True)
    parts = {part.name: part for where in (beside, folder) if where for part in sorted(where.glob("*.o"))}
    subprocess.run([*compiler, *flags, *parts.values(), "-o", program, "-lm"], check=True)
    return program


@pytest.fixture(scope="module")
def wild(tmp_path_factory: pytest.TempPathFactory) -> Path:
    if not (cc := shutil.which("cc")):
        pytest.skip("no cc here: zig brings no address sanitizer")
    return build(tmp_path_factory.mktemp("wild"), [cc], *WATCHED)


def roam(wild: Path, seed: int, ticks: int) -> tuple[np.ndarray, str]:
    """Run it and return the ticks in each state and with a new table, and the digest of what was driven."""
    done = subprocess.run([wild, str(seed), str(ticks)], check=False, capture_output=True, text=True)
    assert done.returncode == 0, (done.stdout + done.stderr)[-2000:]
    counts, digest = done.stdout.splitlines()
    return np.array(counts.split(), dtype=int), digest


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pi", "filtered_pi", "limit_observer"])
def test_random_tables_samples_and_bytes_under_the_sanitizers(wild, tmp_path, law: str):
    """Gains up to 1e30: most laws do not survive them, and the board does."""
    program = wild if law == "filtered_pi" else build(tmp_path, ["cc"], *WATCHED, law=law)
    seen = sum(roam(program, seed, 20_000)[0] for seed in range(8))
    assert np.all(seen > 100)  # it has been everywhere


@pytest.mark.soak
def test_many_more_of_them(wild):
    assert np.all(sum(roam(wild, seed, 500_000)[0] for seed in range(100, 120)) > 10_000)


PLANTED = {
    "another ceiling": ("app_parameters.c", "is_more(p, built))", "(0 && is_more(p, built)))", "duty: "),
    "it rises while it is idle": (
        "app_control.c", "app->amplitude - p->drive_ramp_um", "app->amplitude + 1", "rises: ",
    ),
    "any rise in a tick": ("app_drive.c", "p->drive_largest_um / FL_RISE_TICKS", "p->drive_largest_um", "leaps: "),
    "twice the silence": ("app_safety.c", "> FL_SILENCE_MS * 1000", "> FL_SILENCE_MS * 2000", "silence: "),
    "one sample beyond the ring": ("app_telemetry.c", "at + 1 < FL_SAMPLES", "at < FL_SAMPLES", "out of bounds"),
    "values beyond the store": ("fl_effect_wrong.c", " || s->count + s->repeats > until - s->first", "", "AddressSan"),
    "words beyond the table": ("app_parameters.c", "count > FL_WORDS - first", "count > FL_WORDS", "table: "),
}  # fmt: skip
"""In which file what becomes what, and what the watched program then says."""


@pytest.mark.slow
@pytest.mark.parametrize("name", PLANTED)
def test_a_planted_bug_is_found(wild, tmp_path, name: str):
    file, old, new, said = PLANTED[name]
    text = (firmware_folder() / "core" / file).read_text(encoding="utf-8")
    assert text.count(old) == 1
    (tmp_path / file).write_text(text.replace(old, new), encoding="utf-8")
    program = build(tmp_path, ["cc"], *WATCHED, changed=tmp_path / file, beside=wild.parent)
    for seed in range(100, 120):
        done = subprocess.run([program, str(seed), "500000"], check=False, capture_output=True, text=True)
        if done.returncode:
            break
    assert done.returncode != 0 and said in done.stdout + done.stderr


@pytest.mark.slow
@pytest.mark.parametrize("compiler", ["cc", "zig"])
@pytest.mark.parametrize("level", ["-O0", "-O2", "-Os"])
def test_the_same_bits_from_every_compiler(wild, tmp_path, compiler: str, level: str):
    command = [sys.executable, "-m", "ziglang", "cc", "-fno-sanitize=all"] if compiler == "zig" else ["cc"]
    if compiler == "zig" and not find_spec("ziglang"):
        pytest.skip("ziglang is not installed")
    assert roam(build(tmp_path, command, level), 5, 200_000)[1] == roam(wild, 5, 200_000)[1]


@settings(max_examples=200)
@given(
    st.floats(0.0, 10.0),
    st.lists(st.one_of(st.binary(max_size=40), st.tuples(*[st.integers(-(2**31), 2**31 - 1)] * 4)), max_size=40),
)
def test_the_amplitude_at_the_pin_is_at_most_the_ceiling(words, ceiling, happenings):
    """The fundamental of a carrier goes with the sine of its duty; the table of the arcsine has cells of 1/256."""
    largest = float(words[AT["drive.largest_um"]])
    table = words.copy()
    table[AT["drive.ceiling_um"]] = ceiling = min(ceiling, largest)
    board = HostBoard(table)
    board.receive(hello() + encode("mode", 1, SESSION, state=2), 0)
    for k, happens in enumerate(happenings):
        if isinstance(happens, bytes):
            board.receive(happens, 200 * k)
            continue
        drive = board.tick(Sample(*happens), 200 * k)
        assert 0 <= largest * np.sin(np.pi * drive.duty / 2**17) <= ceiling + largest / 1024
        assert 0 <= drive.amplitude_um <= ceiling
