"""A flash that is not what was built drives nothing: single bits of the image and of its table, flipped."""

from __future__ import annotations

import zlib

import numpy as np
import pytest
from tick_corpus import SESSION, hello

from frictionloop import FrictionloopError
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.firmware.image_files import loaded, symbol_bytes
from frictionloop.quantities.schema import schema

pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
CLOSED, BAD_IMAGE = schema()["states"]["closed"], schema()["faults"]["bad_image"]


def flashed(image, tmp_path, place: int, bit: int):
    """Return the path of an image with a bit flipped at a place of its file."""
    content = bytearray(image.elf.read_bytes())
    content[place] ^= 1 << bit
    path = tmp_path / "flipped.elf"
    path.write_bytes(content)
    return path


def drives(path) -> tuple[float, list[int]]:
    """Return the largest duty of a board that is asked to close its loop on a finger, and the faults that it tells."""
    board, decoder, told, most = TeensyEmulator(path), Decoder(), [], 0.0
    for k in range(400):
        if k % 100 == 0:
            board.receive(hello() * (k == 0) + encode("mode", k + 1, SESSION, state=CLOSED))
        most = max(most, board.tick((8000 + k % 3, 0), 3277, 4 * k))
        told += [message["fault"] for message in decoder.feed(board.transmit()) if message.name == "fault"]
    return most, told


def test_an_image_as_it_was_built_drives(images):
    most, told = drives(images("pi").elf)
    assert most > 0 and told == []


def test_the_check_sum_is_that_of_all_before_it(images):
    elf = images("pi").elf
    content = bytearray(b"\xff" * 256 * 1024)
    for address, part in loaded(elf):
        content[address : address + len(part)] = part
    end = max(address + len(part) for address, part in loaded(elf))
    assert symbol_bytes(elf, "flash_crc") == zlib.crc32(content[: end - 4]).to_bytes(4, "little")


@pytest.mark.parametrize("what", ["fl_built_parameters", "image"])
def test_a_flipped_bit_is_told_and_nothing_is_driven(what, images, tmp_path):
    """Where the flip is in what starts or serves the board, it may say nothing at all."""
    image, rng = images("pi"), np.random.default_rng(7)
    file = image.elf.read_bytes()
    parts = [part for _, part in loaded(image.elf) if len(part) > 100]
    part = symbol_bytes(image.elf, what) or max(parts, key=len)
    begin, started = file.index(part), 0
    for _ in range(20):
        path = flashed(image, tmp_path, begin + int(rng.integers(len(part))), int(rng.integers(8)))
        try:
            most, told = drives(path)
        except FrictionloopError:
            continue
        assert most == 0.0
        if told:
            started += 1
            assert told == [BAD_IMAGE]
    assert started >= 12
