"""The image for qemu-system-arm against the host: one scenario, 20 000 ticks in the timer's interrupt."""

import re
import shutil
import subprocess
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from frictionloop.device.codec import Decoder
from frictionloop.firmware.build_identity import revision_here
from frictionloop.firmware.compiled_core import declarations, host_sources, law_of_table
from frictionloop.firmware.host_compiler import shared_library
from frictionloop.firmware.image_files import loaded, symbol_bytes
from frictionloop.firmware.image_law import board_law
from frictionloop.quantities.protocol_schema import firmware_folder, schema

QEMU = shutil.which("qemu-system-arm")
needs_qemu = pytest.mark.skipif(QEMU is None, reason="qemu-system-arm is not installed")
SCENARIO = """
typedef struct { uint64_t drives, bytes; uint32_t sent; } fl_scenario;
void fl_scenario_run(fl_scenario *, fl_app *, const fl_identity *, const void *);
void fl_scenario_start(fl_scenario *, fl_app *, const fl_identity *, const void *);
size_t fl_stimulus_bytes(uint32_t, uint8_t *);
"""


@pytest.fixture(scope="module")
def scenario(law_words, tmp_path_factory):
    """What the host makes of the scenario, by law; None for a board without parameters."""
    cffi = pytest.importorskip("cffi")
    ffi = cffi.FFI()
    ffi.cdef(declarations() + SCENARIO)
    core, boards = firmware_folder() / "core", firmware_folder() / "boards"
    sources = [*sorted(core.glob("*.c")), boards / "scenario.c", boards / "stimulus.c"]

    @cache
    def built(law):
        own = board_law(law_of_table(law_words[law])).write(tmp_path_factory.mktemp(law))
        plain = [source for source in host_sources()[0] if source.parent.name == "host"]
        folders = (core, boards, boards / "host")
        return ffi.dlopen(str(shared_library("scenario", [*sources, *plain, own], folders)))

    def run(law):
        library = built(law or "pi")
        out, memory = ffi.new("fl_scenario *"), ffi.new("uint64_t[]", library.fl_app_size() // 8 + 1)
        revision = ffi.new("char[]", revision_here().encode())
        identity = ffi.new("fl_identity *", (schema()["boards"]["mps2"], 0, revision))
        words = ffi.new("double[]", law_words[law].tolist()) if law else ffi.NULL
        library.fl_scenario_run(out, ffi.cast("fl_app *", memory), identity, words)
        return {"drives": out.drives, "bytes": out.bytes, "sent": out.sent}

    run.ffi, run.library = ffi, built("pi")
    return run


def qemu(image, timeout_s=100):
    command = [
        QEMU, "-M", "mps2-an500", "-icount", "shift=4", "-nographic", "-monitor", "none", "-serial", "null",
        "-semihosting-config", "enable=on,target=native", "-kernel", str(image),
    ]  # fmt: skip
    # semihosting writes to the standard error
    done = subprocess.run(command, check=True, capture_output=True, text=True, timeout=timeout_s)
    return {name: int(value, 16) for name, value in (line.split() for line in done.stderr.splitlines())}


@needs_qemu
@pytest.mark.parametrize("law", ["notch_pi", pytest.param("limit_observer", marks=pytest.mark.slow)])
def test_the_digest_in_the_timers_interrupt_is_the_hosts(law, images, scenario):
    ran = qemu(images(law, board="mps2-scenario").elf)
    assert ran.pop("late") == 0
    assert ran.pop("passed") < 1000  # ticks in which a frame was made: less than one in twenty
    assert ran == scenario(law)


FLIPS = [
    ("fl_built_parameters", 1),
    *(pytest.param(what, 4, marks=pytest.mark.slow) for what in ("fl_built_parameters", "image")),
    *(pytest.param(what, 12, marks=pytest.mark.soak) for what in ("fl_built_parameters", "image")),
]
"""What is damaged, and in how many bits, one at a time."""
WITNESS = (
    *(f"fl_scenario_{part}" for part in ("start", "tick", "background", "run")),
    *("fl_stimulus", "fl_stimulus_bytes", "fl_digest", "fl_tick", "main"),
)
"""What of the image is not the board's but the test's: it tells and digests what the board does."""


@needs_qemu
def test_without_access_to_its_registers_the_first_double_is_a_fault(images, tmp_path):
    """The image that writes nothing to CPACR: the instructions that do are no operations."""
    content = images("pi", board="mps2-scenario").elf.read_bytes()
    orr = rb"[\x40-\x4e]\xf4\x70[\x00-\x0e]"  # orr r, r, #0xF00000 (Armv7-M Architecture Reference Manual, A7.7.91)
    assert len(re.findall(orr, content)) == 1
    (tmp_path / "none.elf").write_bytes(re.sub(orr, b"\x00\xbf\x00\xbf", content))
    with pytest.raises(subprocess.CalledProcessError):
        qemu(tmp_path / "none.elf", timeout_s=20)


@needs_qemu
@pytest.mark.parametrize(("what", "flips"), FLIPS)
def test_a_flipped_bit_of_the_image_is_refused_at_boot(what, flips, images, scenario, tmp_path):
    """It runs as a board without parameters does, whose amplitude is 0; one in what serves the board may end it."""
    elf, rng = images("pi", board="mps2-scenario").elf, np.random.default_rng(7)
    file, refused, ended = elf.read_bytes(), 0, 0
    part = symbol_bytes(elf, what) or max((part for _, part in loaded(elf)), key=len)
    nothing = scenario(None)
    assert nothing["drives"] != scenario("pi")["drives"]
    witness = np.zeros(len(part), dtype=bool)
    for told in filter(None, (symbol_bytes(elf, name) for name in WITNESS)):
        if told in part:
            witness[part.index(told) :][: len(told)] = True
    for where in rng.choice(np.flatnonzero(~witness), flips):
        content = bytearray(file)
        content[file.index(part) + int(where)] ^= 1 << int(rng.integers(8))
        path = tmp_path / "flipped.elf"
        path.write_bytes(content)
        try:
            ran = qemu(path, timeout_s=20)
        except (subprocess.SubprocessError, ValueError):
            ran = {}
        if "drives" in ran:
            assert ran["drives"] == nothing["drives"]
            refused += 1
        else:
            ended += 1
    assert refused + ended == flips
    assert refused >= (flips if what == "fl_built_parameters" else 0.75 * flips)


@pytest.mark.slow
@needs_qemu
@pytest.mark.parametrize("law", ["pi", "lookup", "limit_observer"])
def test_so_it_is_with_every_other_law(law, images, scenario):
    ran = qemu(images(law, board="mps2-scenario").elf)
    assert {name: ran[name] for name in ("drives", "bytes", "sent", "late")} == {**scenario(law), "late": 0}


def test_the_scenario_depends_on_the_law(scenario):
    """A digest that is the same for different laws would show nothing."""
    digests = [scenario(law)["drives"] for law in ("lookup", "pi", "notch_pi", "limit_observer")]
    assert len(set(digests)) == len(digests)


def test_the_scenario_asks_for_the_loop_and_keeps_silent_once(scenario):
    ffi, told = scenario.ffi, []
    out = ffi.new("uint8_t[64]")
    for tick in range(20000):
        count = scenario.library.fl_stimulus_bytes(tick, out)
        told += [(tick, message.name) for message in Decoder().feed(bytes(ffi.buffer(out, count)))]
    names = [name for _, name in told]
    assert names[:5] == ["heartbeat", "hello", "identify", "stream", "mode"]
    silences = [after - before for (before, _), (after, _) in pairwise(told)]
    assert [ticks for ticks in silences if ticks > schema()["protocol"]["silence_ms"] * 5] == [max(silences)]
    assert names.count("mode") == 2
    assert names.count("clear") == 1
