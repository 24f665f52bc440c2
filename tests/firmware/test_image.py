"""The image as it would be flashed."""

import struct

import pytest

from frictionloop import FrictionloopError
from frictionloop.firmware.image import build
from frictionloop.firmware.image_files import check, check_teensy, loaded, read_hex
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


def test_vectors_and_flash_configuration_are_where_the_chip_looks(images):
    flashed = intel_hex(images("pi").hex.read_text())
    vectors = struct.unpack("<111I", bytes(flashed[k] for k in range(444)))
    assert 0x1FFF8000 < vectors[0] <= 0x20008000
    assert vectors[0] % 8 == 0
    places = [vector for k, vector in enumerate(vectors) if k not in {0, 16 + 45, 16 + 68}]
    assert all(place % 2 == 1 and 0x410 <= place < 0x8000 for place in places)
    # The tick and the port are in the RAM, where instructions do not wait.
    assert all(vectors[k] % 2 == 1 and 0x1FFF8000 <= vectors[k] < 0x1FFFF000 for k in (16 + 45, 16 + 68))
    # The handlers of ticks and of the port are not the one of faults, all others are.
    assert [k for k in range(2, 111) if vectors[k] != vectors[3]] == [16 + 45, 16 + 68]
    assert bytes(flashed[0x400 + k] for k in range(16)).hex() == "ff" * 12 + "def9ffff"


def test_an_image_keeps_to_its_budget(images):
    image = images("filtered_pi")
    assert image.flash_bytes <= 32 * 1024
    assert image.ram_bytes <= 24 * 1024


def test_the_map_names_what_takes_room(images):
    rows = [line.split() for line in images("pi").map.read_text().splitlines()]
    assert "fl_built_parameters" in {name for _, size, name in rows if int(size) == 4 * word_count()}
    assert sorted((int(size) for _, size, _ in rows), reverse=True) == [int(size) for _, size, _ in rows]


def test_the_same_words_make_the_same_image(images, law_words, tmp_path):
    again = build("teensy41", law_words["pi"].tolist(), tmp_path)
    assert again.hex.read_text() == images("pi").hex.read_text()


def test_an_image_that_would_lock_the_chip_is_refused(images, tmp_path):
    content = bytearray(images("pi").elf.read_bytes())
    place = content.index(bytes.fromhex("def9ffff"))
    content[place] = 0xDC  # FSEC: mass erase disabled
    spoilt = tmp_path / "spoilt.elf"
    spoilt.write_bytes(content)
    with pytest.raises(FrictionloopError, match=r"configuration = 'f+dcf9ffff': must be f+def9ffff"):
        check(spoilt, flash_configuration=True)


def test_the_hex_file_holds_what_the_elf_file_loads(images):
    """zig's objcopy against our reader, and pyelftools beside it."""
    image = images("pi")
    in_hex, in_elf = ({at + k: byte for at, part in parts for k, byte in enumerate(part)}
                      for parts in (read_hex(image.hex), loaded(image.elf)))  # fmt: skip
    assert in_hex == in_elf and len(in_hex) > 10_000
    check_teensy("image", read_hex(image.hex))


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
