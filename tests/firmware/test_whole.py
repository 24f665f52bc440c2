"""A flash that is not what was built drives nothing: single bits of the image and of its table, flipped."""

from __future__ import annotations

import zlib

import numpy as np
import pytest

from frictionloop import FrictionloopError
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.emulator import TeensyEmulator
from frictionloop.device.emulator.budget import SESSION, hello
from frictionloop.device.emulator.processor import RETURN, Patience
from frictionloop.device.emulator.registers import PIT_INTERRUPT
from frictionloop.firmware.image_files import FLASH, elf_file, loaded, symbol_bytes
from frictionloop.quantities.protocol_schema import schema, word_count

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
        most = max(most, board.tick((8000 + 16 * (k % 3), 0), 3277, 4 * k))
        told += [message["fault"] for message in decoder.feed(board.transmit()) if message.name == "fault"]
    return most, told


def test_an_image_as_it_was_built_drives(images):
    most, told = drives(images("pi").elf)
    assert most > 0 and told == []


def test_the_check_sum_is_that_of_all_before_it(images):
    elf = images("pi").elf
    content = bytearray(b"\xff" * 256 * 1024)
    for address, part in loaded(elf):
        content[address - FLASH : address - FLASH + len(part)] = part
    end = max(address - FLASH + len(part) for address, part in loaded(elf))
    assert symbol_bytes(elf, "flash_crc") == zlib.crc32(content[: end - 4]).to_bytes(4, "little")


FLIPS = [
    ("fl_built_parameters", 60),
    pytest.param("image", 20, marks=pytest.mark.slow),
    pytest.param("image", 60, marks=pytest.mark.soak),
]
"""What is damaged, and in how many bits, one at a time."""
LEAST_TOLD = 0.6
"""Share of flips in the image that are told (assumed: 14 of the first 20 are); the others end or mute the board."""


@pytest.mark.parametrize(("what", "flips"), FLIPS)
def test_a_flipped_bit_is_told_and_nothing_is_driven(what, flips, images, tmp_path):
    """None of them drives. One in the table is always told; one in what serves the board may end it, mute it or add."""
    image, rng = images("pi"), np.random.default_rng(7)
    file = image.elf.read_bytes()
    parts = [part for _, part in loaded(image.elf) if len(part) > 100]
    part = symbol_bytes(image.elf, what) or max(parts, key=len)
    begin, found, ended, mute = file.index(part), 0, 0, 0
    for _ in range(flips):
        path = flashed(image, tmp_path, begin + int(rng.integers(len(part))), int(rng.integers(8)))
        try:
            most, told = drives(path)
        except FrictionloopError:
            ended += 1
            continue
        assert most == 0.0
        found += told[:1] == [BAD_IMAGE]
        mute += told == []
    assert found + ended + mute == flips
    assert found >= (flips if what == "fl_built_parameters" else LEAST_TOLD * flips)


@pytest.mark.slow
def test_every_bit_of_the_table_counts(images):
    """On one board, whose check is called again for each: what it looks at is in its memory."""
    elf = images("pi").elf
    board = TeensyEmulator(elf).processor
    begin, size = address_of(elf, "fl_built_parameters", flash=True)
    check, _ = address_of(elf, "board_is_whole")
    assert called(board, check) == 1
    missed = []
    for place in range(begin, begin + size):
        (byte,) = board.uc.mem_read(place, 1)
        for bit in range(8):
            board.uc.mem_write(place, bytes([byte ^ 1 << bit]))
            if called(board, check) != 0:
                missed.append((place, bit))
        board.uc.mem_write(place, bytes([byte]))
    assert missed == [] and size == 8 * word_count()
    assert called(board, check) == 1


def test_a_loop_without_end_is_ended(images):
    """As the watchdog of the board does: 0xE7FE branches to itself."""
    board = TeensyEmulator(images("pi").elf).processor
    board._patience = Patience(board.uc.emu_stop, longest_s=0.1)
    number = 16 + PIT_INTERRUPT
    board.uc.mem_write(board.vector(number) & ~1, b"\xfe\xe7")
    with pytest.raises(FrictionloopError, match="does not come to rest"), board.stretch():
        board.interrupt(number)


def address_of(elf, name: str, flash: bool = False) -> tuple[int, int]:
    """Return where a symbol is, as linked or in the flash that it is copied from, and its size."""
    with elf.open("rb") as file:
        (symbol,) = elf_file(file).get_section_by_name(".symtab").get_symbol_by_name(name)
        parts = [(part["p_vaddr"], part["p_filesz"], part["p_paddr"]) for part in elf_file(file).iter_segments()]
    place = symbol["st_value"] & ~1
    (load,) = (place - linked + load for linked, size, load in parts if 0 <= place - linked < size)
    return load if flash else place, symbol["st_size"]


def called(processor, address: int) -> int:
    """Return what a function without arguments returns."""
    arm = processor.arm
    processor.uc.reg_write(arm.UC_ARM_REG_SP, processor.vector(0))
    processor.uc.reg_write(arm.UC_ARM_REG_LR, RETURN | 1)
    processor.uc.emu_start(address | 1, RETURN)
    return processor.uc.reg_read(arm.UC_ARM_REG_R0)
