"""Spoilt bytes against both decoders: flips, drops, repeats, cuts and noise; what is whole must come through.

A CRC of 16 bits lets one in 65536 spoilt frames pass at random; what passes is counted and held against that.
"""

from __future__ import annotations

import random
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from frictionloop.device import codec
from frictionloop.device.codec import HEADER, LAYOUTS, Decoder, Message, cobs, crc16, encode, framed
from frictionloop.quantities.protocol_schema import firmware_folder

FUZZ = Path(__file__).with_name("fuzz.c")
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def by_chance(broken: int) -> float:
    """Return the most wrong frames that the CRC's odds explain: the mean of so many trials and five deviations."""
    mean = broken / 2**16
    return mean + 5 * mean**0.5 + 5


def check(wrong: int, lost: int, broken: int, inputs: int) -> None:
    """Hold what came of so many spoilt frames, each with a whole one after it."""
    assert lost == 0
    assert broken > inputs / 2
    assert wrong <= by_chance(broken)


def ran(program: Path, inputs: int) -> None:
    told = subprocess.run([program, str(inputs), "1"], check=True, capture_output=True, text=True).stdout
    done, *found = map(int, told.split())
    assert done == inputs
    check(*found, inputs)


@pytest.mark.parametrize(
    "inputs", [20_000, pytest.param(10_000_000, marks=[pytest.mark.soak, pytest.mark.timeout(900)])]
)
def test_c_under_the_sanitizers(build: Callable[..., Path], inputs: int) -> None:
    ran(build("fuzz", FUZZ, *(SANITIZED if shutil.which("cc") else [])), inputs)


PLANTED = {
    "a byte beyond the frame": ("decoder->count < sizeof decoder->frame", "decoder->count <= sizeof decoder->frame"),
    "half of the check": ("crc == (end[0] | end[1] << 8)", "(crc & 0xFF) == end[0]"),
    "the rest of a broken frame stays": ("decoder->begun = decoder->left = ", "decoder->begun = "),
    "a full block stands for a zero byte": ("byte != 0xFF", "1"),
    "a block of more than 254 bytes": ("if (*coder->code == 0xFF)", "if (0)"),
}
"""What in fl_frame.c becomes what."""


@pytest.mark.slow
@pytest.mark.skipif(not shutil.which("cc"), reason="no cc here: zig brings no address sanitizer")
@pytest.mark.parametrize("name", PLANTED)
def test_a_bug_that_is_planted_in_c_is_found(build: Callable[..., Path], tmp_path: Path, name: str) -> None:
    core = shutil.copytree(firmware_folder() / "core", tmp_path / "core")
    text = (core / "fl_frame.c").read_text(encoding="utf-8")
    assert text.count(PLANTED[name][0]) == 1
    (core / "fl_frame.c").write_text(text.replace(*PLANTED[name]), encoding="utf-8")
    program = build("fuzz", FUZZ, *SANITIZED, core=core)
    with pytest.raises((AssertionError, subprocess.CalledProcessError)):
        ran(program, 200_000)


def random_frame(draw: random.Random) -> bytes:
    """Return the frame of a telemetry message."""
    count = draw.randrange(0, 33)
    fixed = HEADER.pack(LAYOUTS["telemetry"].type, draw.getrandbits(16), draw.getrandbits(32))
    return framed(fixed + draw.randbytes(10) + (draw.randbytes(2 * count) if draw.randrange(4) else bytes(2 * count)))


def spoilt(frame: bytes, draw: random.Random) -> bytes:
    """Return the frame as a bad line hands it on."""
    way, line = draw.randrange(5), bytearray(frame)
    first = draw.randrange(len(line))
    last = draw.randrange(first + 1, len(line) + 1)
    if way == 0:
        for _ in range(draw.randrange(1, 5)):
            line[draw.randrange(len(line))] ^= 1 << draw.randrange(8)
    elif way == 1:
        del line[first:last]
    elif way == 2:
        line[first:first] = line[first:last]
    elif way == 3:
        line = line[:first]
    else:
        line = bytearray(draw.randbytes(draw.randrange(1, 300)))
    return bytes(line) + b"\0"


def coded(message: Message) -> bytes:
    """Return the frame of a message that was decoded."""
    return encode(message.name, message.sequence, message.stamp, **message.fields)


def spoil_python(inputs: int) -> None:
    """Hand the decoder so many spoilt frames, and a whole one after each."""
    draw, decoder = random.Random(1), Decoder()
    wrong = lost = 0
    for _ in range(inputs):
        frame = random_frame(draw)
        bad = spoilt(frame, draw)
        cut = draw.randrange(len(bad))  # the line stalls anywhere
        for message in decoder.feed(bad[:cut]) + decoder.feed(bad[cut:]):
            wrong += coded(message) != frame
        good = random_frame(draw)
        lost += [coded(message) for message in decoder.feed(good)] != [good]
    check(wrong, lost, decoder.broken, inputs)


@pytest.mark.parametrize(
    "inputs", [20_000, pytest.param(10_000_000, marks=[pytest.mark.soak, pytest.mark.timeout(1800)])]
)
def test_python(inputs: int) -> None:
    spoil_python(inputs)


def half_of_the_check(line: bytes) -> bytes | None:
    try:
        content = bytes(cobs.decode(line))
    except cobs.DecodeError:
        return None
    return content[:-2] if len(content) >= HEADER.size + 2 and crc16(content[:-2]) % 256 == content[-2] else None


BUGS = {
    "half of the check": ("uncoded", half_of_the_check),
    "bytes that are no COBS are an error": ("uncoded", lambda line: cobs.decode(line)[:-2]),
    "a frame that is too long is given up too soon": ("LARGEST_CODED", 40),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", BUGS)
def test_a_bug_that_is_planted_in_python_is_found(monkeypatch: pytest.MonkeyPatch, name: str) -> None:
    monkeypatch.setattr(codec, *BUGS[name])
    with pytest.raises((AssertionError, cobs.DecodeError)):
        spoil_python(100_000)
