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

from frictionloop.device.codec import Decoder, encode, framed
from frictionloop.device.layout import HEADER, LAYOUTS

FUZZ = Path(__file__).with_name("fuzz.c")
SANITIZED = ["-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


def by_chance(broken: int) -> float:
    """Return the most wrong frames that the CRC's odds explain: the mean of so many trials and five deviations."""
    mean = broken / 2**16
    return mean + 5 * mean**0.5 + 5


@pytest.mark.parametrize(
    "inputs", [20_000, pytest.param(10_000_000, marks=[pytest.mark.soak, pytest.mark.timeout(900)])]
)
def test_c_under_the_sanitizers(build: Callable[..., Path], inputs: int) -> None:
    program = build("fuzz", FUZZ, *(SANITIZED if shutil.which("cc") else []))
    told = subprocess.run([program, str(inputs), "1"], check=True, capture_output=True, text=True).stdout
    done, wrong, lost, broken = map(int, told.split())
    assert (done, lost) == (inputs, 0)
    assert broken > inputs / 2
    assert wrong <= by_chance(broken)


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


@pytest.mark.parametrize(
    "inputs", [20_000, pytest.param(10_000_000, marks=[pytest.mark.soak, pytest.mark.timeout(1800)])]
)
def test_python(inputs: int) -> None:
    draw, decoder = random.Random(1), Decoder()
    wrong = 0
    for k in range(inputs):
        frame = random_frame(draw)
        bad = spoilt(frame, draw)
        cut = draw.randrange(len(bad))  # the line stalls anywhere
        for message in decoder.feed(bad[:cut]) + decoder.feed(bad[cut:]):
            wrong += encode(message.name, message.sequence, message.stamp, **message.fields) != frame
        (good,) = decoder.feed(encode("status", k % 2**16, k, state=1, fault=2, tick=k, commits=0, reset=1))
        assert (good.name, good["tick"]) == ("status", k)
    assert decoder.broken > inputs / 2
    assert wrong <= by_chance(decoder.broken)
