"""The image as it would be flashed."""

import pytest

from frictionloop import FrictionloopError
from frictionloop.control.laws import LAWS
from frictionloop.firmware.board_law import board_law
from frictionloop.firmware.image import build
from frictionloop.firmware.image_files import check, check_teensy, elf_file, loaded, read_hex
from frictionloop.quantities.schema import word_count


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
    assert max(flashed) + 1 == image.flash_bytes


def test_an_image_keeps_to_its_budget(images):
    image = images("filtered_pi")
    assert image.flash_bytes <= 32 * 1024
    assert image.ram_bytes <= 24 * 1024


def test_the_map_names_what_takes_room(images):
    rows = [line.split() for line in images("pi").map.read_text().splitlines()]
    assert "fl_built_parameters" in {name for _, size, name in rows if int(size) == 8 * word_count()}
    assert sorted((int(size) for _, size, _ in rows), reverse=True) == [int(size) for _, size, _ in rows]


def test_the_same_words_make_the_same_image(images, law_words, tmp_path):
    again = build("mps2", law_words["pi"].tolist(), board_law(LAWS["pi"]), tmp_path, rate_hz=5000)
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
    check(elf)
    with pytest.raises(FrictionloopError, match=rf"must be without (soft floating point|a heap): {symbol}$"):
        check(tmp_path / "spoilt.elf")


def test_the_hex_file_holds_what_the_elf_file_loads(images):
    """zig's objcopy against our reader, and pyelftools beside it."""
    image = images("pi")
    in_hex, in_elf = ({at + k: byte for at, part in parts for k, byte in enumerate(part)}
                      for parts in (read_hex(image.hex), loaded(image.elf)))  # fmt: skip
    assert in_hex == in_elf and len(in_hex) > 10_000


def test_an_image_of_another_board_is_no_teensys(tmp_path):
    """Records as the specification has them: 16 bytes at 0x0100, an upper half of the address, an end."""
    path = tmp_path / "other.hex"
    path.write_text(
        ":10010000214601360121470136007EFE09D2190140\n:020000021200EA\n:0400300061626364 42\n".replace(" ", "")
        + ":020000040800F2\n:0101000021DD\n:00000001FF\n"
    )
    assert read_hex(path) == [
        (0x100, bytes.fromhex("214601360121470136007EFE09D21901")), (0x12030, b"abcd"), (0x08000100, b"!"),
    ]  # fmt: skip
    with pytest.raises(FrictionloopError, match=r"^other\.hex: is no Teensy image"):
        check_teensy(path.name, read_hex(path))
