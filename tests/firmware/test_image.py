"""The image as it would be flashed."""

import struct

import pytest

from frictionloop import FrictionloopError
from frictionloop.control.laws import LAWS
from frictionloop.firmware.image import build
from frictionloop.firmware.image_files import FLASH, check, check_teensy, elf_file, loaded, read_hex
from frictionloop.firmware.image_law import board_law
from frictionloop.quantities.protocol_schema import word_count


def intel_hex(text):
    """Bytes by address, by the format's own description (Intel, 1988), sums checked."""
    memory, base = {}, 0
    for line in text.split():
        assert line[0] == ":"
        record = bytes.fromhex(line[1:])
        count, address, kind, data = record[0], int.from_bytes(record[1:3], "big"), record[3], record[4:-1]
        assert len(data) == count
        assert sum(record) % 256 == 0
        if kind == 0:
            memory |= {base + address + k: byte for k, byte in enumerate(data)}
        elif kind in {2, 4}:
            base = int.from_bytes(data, "big") << (4 if kind == 2 else 16)
        elif kind == 1:
            return memory
    pytest.fail("no end record")


def test_the_hex_file_is_the_elf_files_flash(images):
    image = images("pi")
    flashed = intel_hex(image.hex.read_text())
    assert flashed == {a + k: byte for a, content in loaded(image.elf) for k, byte in enumerate(content)}
    assert max(flashed) + 1 - FLASH == image.flash_bytes


def test_the_rom_finds_what_it_reads_before_it_starts_an_image(images):
    """i.MX RT1060 Reference Manual, System Boot: the flash's words at 0x0000, the image's at 0x1000 of it."""
    flashed = intel_hex(images("pi").hex.read_text())
    words = struct.unpack("<128I", bytes(flashed[FLASH + k] for k in range(512)))
    assert words[0] == int.from_bytes(b"FCFB", "little") and words[1] >> 24 == ord("V")
    assert (words[20], words[112], words[113]) == (8 << 20, 256, 4096)
    tag, entry, _, dcd, boot, itself, _, _ = struct.unpack("<8I", bytes(flashed[FLASH + 0x1000 + k] for k in range(32)))
    assert (tag, dcd, itself) == (0x432000D1, 0, FLASH + 0x1000)
    begin, length, plugin = struct.unpack("<3I", bytes(flashed[boot + k] for k in range(12)))
    assert (begin, length, plugin) == (FLASH, max(flashed) + 1 - FLASH, 0)
    assert FLASH + 0x1000 < entry < FLASH + 0x2000


def test_code_and_data_lie_in_tightly_coupled_memory(images):
    with images("pi").elf.open("rb") as file:
        elf = elf_file(file)
        table = elf.get_section_by_name(".symtab")
        places = {symbol.name: symbol["st_value"] for symbol in table.iter_symbols()}
        vectors = elf.get_section_by_name(".data").data()[: 4 * 174]
    numbers = struct.unpack("<174I", vectors)
    assert places["vectors"] % 1024 == 0 and numbers[0] == places["stack_top"] == 0x20000000 + 8192
    handlers = {25: "port_interrupt", 122: "tick_interrupt"}
    for k, name in handlers.items():
        assert numbers[16 + k] | 1 == places[name] | 1 and 32 <= numbers[16 + k] < 0x20000
    # The handlers of ticks and of the port are not the one of faults, all others are.
    assert [k for k in range(2, 174) if numbers[k] != numbers[3]] == [16 + 25, 16 + 122]
    assert places["flexram_banks"] == 0xAAAAAAAB  # one bank of 32 KB for code, fifteen for data
    assert 0 < places["itcm_end"] <= 32 * 1024


def test_an_image_keeps_to_its_budget(images):
    image = images("filtered_pi")
    assert image.flash_bytes <= 40 * 1024
    assert image.ram_bytes <= 56 * 1024


def test_the_map_names_what_takes_room(images):
    rows = [line.split() for line in images("pi").map.read_text().splitlines()]
    assert "fl_built_parameters" in {name for _, size, name in rows if int(size) == 8 * word_count()}
    assert sorted((int(size) for _, size, _ in rows), reverse=True) == [int(size) for _, size, _ in rows]


def test_the_same_words_make_the_same_image(images, law_words, tmp_path):
    again = build("teensy41", law_words["pi"].tolist(), board_law(LAWS["pi"]), tmp_path, rate_hz=5000)
    assert again.hex.read_text() == images("pi").hex.read_text()


@pytest.mark.parametrize(
    "symbol", ["__aeabi_dadd", "__aeabi_dcmplt", "__aeabi_i2d", "__divdf3", "fma", "sqrtf", "malloc"]
)
def test_an_image_that_calculates_doubles_in_software_is_refused(images, tmp_path, symbol):
    """Its symbol table names what it calls; conversions of 64-bit whole numbers have no instruction."""
    elf = images("pi").elf
    with elf.open("rb") as file:
        strings = elf_file(file).get_section_by_name(".strtab")
        names, at = strings.data(), strings["sh_offset"]
    assert b"__aeabi_l2d" in names and b"__aeabi_d2lz" in names
    old = next(name for name in names.split(b"\0") if len(name) >= len(symbol))
    content = bytearray(elf.read_bytes())
    place = at + names.index(b"\0" + old + b"\0") + 1
    content[place : place + len(symbol) + 1] = symbol.encode() + b"\0"
    (tmp_path / "spoilt.elf").write_bytes(content)
    check(elf, teensy=True)
    with pytest.raises(FrictionloopError, match=rf"must be without (soft floating point|a heap): {symbol}$"):
        check(tmp_path / "spoilt.elf", teensy=True)


@pytest.mark.parametrize("old", [b"FCFB", struct.pack("<2I", FLASH + 0x1020, FLASH + 0x1000)])
def test_an_image_that_the_rom_would_not_start_is_refused(old, images, tmp_path):
    """Without the flash's tag; with boot data that do not say where the image begins."""
    content = images("pi").elf.read_bytes()
    assert content.count(old) == 1
    spoilt = tmp_path / "spoilt.elf"
    spoilt.write_bytes(content.replace(old, old[:1] + b"\xff" + old[2:]))
    with pytest.raises(FrictionloopError, match=r"spoilt\.elf: is no image of a Teensy 4\.1"):
        check(spoilt, teensy=True)


def test_the_hex_file_holds_what_the_elf_file_loads(images):
    """zig's objcopy against our reader, and pyelftools beside it."""
    image = images("pi")
    in_hex, in_elf = ({at + k: byte for at, part in parts for k, byte in enumerate(part)}
                      for parts in (read_hex(image.hex), loaded(image.elf)))  # fmt: skip
    assert in_hex == in_elf and len(in_hex) > 10_000


def test_a_file_of_another_board_is_no_image_of_this(tmp_path):
    """Records as the specification has them: 16 bytes at 0x0100, an upper half of the address, an end."""
    path = tmp_path / "other.hex"
    path.write_text(
        ":10010000214601360121470136007EFE09D2190140\n:020000021200EA\n:0400300061626364 42\n".replace(" ", "")
        + ":020000040800F2\n:0101000021DD\n:00000001FF\n"
    )
    assert read_hex(path) == [
        (0x100, bytes.fromhex("214601360121470136007EFE09D21901")), (0x12030, b"abcd"), (0x08000100, b"!"),
    ]  # fmt: skip
    with pytest.raises(FrictionloopError, match=r"^other\.hex: is no image of a Teensy 4\.1"):
        check_teensy(path.name, read_hex(path))
