"""Which firmware it is: told by the image, and held against the sources here when the emulator refuses it."""

from __future__ import annotations

import re
import shutil
import zlib
from pathlib import Path

import pytest

from frictionloop.device.bench_boards import Emulated
from frictionloop.firmware import built_in
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.schema import firmware_folder


@pytest.fixture
def sources(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a copy of the C sources that stands in their place."""
    copy = Path(shutil.copytree(firmware_folder(), tmp_path / "firmware"))
    monkeypatch.setattr(built_in, "firmware_folder", lambda: copy)
    built_in.revision_here.cache_clear()
    yield copy
    built_in.revision_here.cache_clear()


def test_it_is_the_version_and_eight_digits_and_fits_its_field():
    told = built_in.revision_here()
    assert re.fullmatch(r"[\w.+]+\+[0-9a-f]{8}", told)
    assert len(told) <= built_in.REVISION_BYTES


def test_a_long_version_gives_way_to_the_checksum(monkeypatch, sources):
    monkeypatch.setattr(built_in, "package_version", lambda: "10.20.30.dev4")
    assert built_in.revision_here().startswith("10.20.3+")
    assert len(built_in.revision_here()) == 16


def test_the_checksum_is_the_crc_of_names_and_contents(sources):
    files = sorted(
        str(path.relative_to(sources).as_posix()) for path in sources.rglob("*") if path.suffix in (".c", ".h")
    )
    joined = b"".join(name.encode() + b"\0" + (sources / name).read_bytes() + b"\0" for name in files)
    assert built_in.revision_here().endswith(f"+{zlib.crc32(joined):08x}")


@pytest.mark.parametrize("change", ["content", "name", "line ends"])
def test_what_changes_it(sources, change):
    before = built_in.revision_here()
    built_in.revision_here.cache_clear()
    file = sources / "core" / "laws.c"
    if change == "content":
        file.write_bytes(file.read_bytes() + b"\n")
    elif change == "name":
        file.rename(file.with_name("laws_2.c"))
    else:
        file.write_bytes(file.read_bytes().replace(b"\n", b"\r\n"))
    assert (built_in.revision_here() == before) == (change == "line ends")


def test_an_image_tells_it(images):
    assert built_in.revision_of(images("pi").elf) == built_in.revision_here()
    assert built_in.other_sources(images("pi").elf) == ""


def test_a_file_without_one_says_nothing(tmp_path):
    (tmp_path / "a.elf").write_bytes(b"no ELF file")
    assert built_in.other_sources(tmp_path / "a.elf") == ""
    assert built_in.other_sources(tmp_path / "none.elf") == ""


@pytest.mark.parametrize("other", [False, True])
def test_an_image_that_the_model_refuses_says_when_it_is_of_other_sources(images, monkeypatch, other):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    from frictionloop.device.emulator import teensy

    image = images("pi").elf
    if other:
        monkeypatch.setattr(built_in, "revision_here", lambda: "0.1.0+00000000")

    def refuse(self):
        raise FrictionloopError("image writes 0x40000000, 4 bytes: no register")

    monkeypatch.setattr(teensy.Watchdog, "check_started", refuse)
    with pytest.raises(FrictionloopError, match="no register") as raised:
        Emulated(image, 2.5)
    assert (": build anew" in str(raised.value)) == other
    assert "\n" not in str(raised.value)
