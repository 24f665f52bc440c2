"""The C framing against the packages `cobs` and `fastcrc`, which the host uses."""

from __future__ import annotations

import zlib
from typing import Any

import pytest
from cobs import cobs
from fastcrc.crc16 import ibm_3740
from hypothesis import example, given
from hypothesis import strategies as st

HEADER, LARGEST = 7, 279
FRAMES = st.binary(min_size=HEADER, max_size=LARGEST)
# Runs of 252 to 256 bytes without a zero, where COBS begins another block or does not.
RUNS = st.builds(
    lambda before, run, after: before + b"\x01" * run + after,
    st.binary(max_size=8),
    st.integers(248, 258),
    st.binary(max_size=8),
)


def coded(frame: bytes) -> bytes:
    """Return what the packages make of a frame."""
    return cobs.encode(frame + ibm_3740(frame).to_bytes(2, "little")) + b"\0"


@given(FRAMES | RUNS)
@example(bytes(LARGEST))
@example(b"\x01" * 252)
@example(b"\xff" * LARGEST)
def test_c_codes_as_the_packages_do(core: Any, frame: bytes) -> None:
    assert core.encoded(frame) == coded(frame)
    assert core.decoded(coded(frame)) == ([frame], 0)


@pytest.mark.parametrize("count", [*range(7, 12), *range(248, 258), 278, 279])
def test_a_buffer_of_the_largest_size_is_never_passed(core: Any, count: int) -> None:
    frame = b"\x55" * count
    need = len(coded(frame))
    worst = count + 2 + -(-(count + 2) // 254) + 1
    assert core.encoded(frame, worst) == coded(frame)
    assert core.encoded(frame, need - 1) == b""


def test_a_frame_beyond_the_largest_is_neither_coded_nor_accepted(core: Any) -> None:
    long = bytes(LARGEST + 1)
    assert core.encoded(long, 400) == b""
    assert core.decoded(coded(long) + coded(b"abcdefgh")) == ([b"abcdefgh"], 1)


def test_zero_bytes_alone_are_no_broken_frames(core: Any) -> None:
    assert core.decoded(b"\0\0\0" + coded(b"abcdefgh") + b"\0\0") == ([b"abcdefgh"], 0)


def test_a_frame_shorter_than_its_header_is_broken(core: Any) -> None:
    assert core.decoded(coded(b"abcdef") + b"\x01\0" + b"\xff\0") == ([], 3)


@given(st.binary(max_size=600).filter(lambda junk: 0 not in junk[-1:]), FRAMES)
def test_after_any_junk_the_next_zero_byte_finds_the_frames_again(core: Any, junk: bytes, frame: bytes) -> None:
    found, broken = core.decoded(junk + b"\0" + coded(frame))
    assert found[-1] == frame
    assert broken <= len(junk)


@given(st.binary(max_size=600), st.integers(0, 600))
def test_check_sums_in_one_go_and_in_parts(core: Any, data: bytes, cut: int) -> None:
    lib = core.lib
    assert lib.fl_crc32(0, data, len(data)) == zlib.crc32(data)
    assert lib.fl_crc16(0xFFFF, data, len(data)) == ibm_3740(data)
    first, rest = data[:cut], data[cut:]
    assert lib.fl_crc32(lib.fl_crc32(0, first, len(first)), rest, len(rest)) == zlib.crc32(data)
    assert lib.fl_crc16(lib.fl_crc16(0xFFFF, first, len(first)), rest, len(rest)) == ibm_3740(data)


def test_check_values_of_the_catalogue(core: Any) -> None:
    lib = core.lib
    assert lib.fl_crc16(0xFFFF, b"123456789", 9) == 0x29B1  # CRC RevEng, CRC-16/IBM-3740
    assert lib.fl_crc32(0, b"123456789", 9) == 0xCBF43926  # CRC RevEng, CRC-32/ISO-HDLC
