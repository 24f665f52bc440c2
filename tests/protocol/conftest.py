"""The C framing as a library on this machine, and a board made of Python, for the tests beside it."""

from __future__ import annotations

import importlib.util
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cffi import FFI

from frictionloop.firmware.host_compiler import FLAGS, compiler, shared_library
from frictionloop.quantities.protocol_schema import firmware_folder, schema_path

SOURCES = "fl_frame.c", "fl_crc.c"
DECLARED = """
typedef struct {
    uint8_t frame[281]; uint16_t count; uint8_t begun, left, zero, too_long; uint32_t whole, broken;
} fl_decoder;
size_t fl_frame_encode(uint8_t *out, size_t room, const uint8_t *frame, size_t count);
int fl_decode(fl_decoder *decoder, uint8_t byte);
uint16_t fl_crc16(uint16_t crc, const uint8_t *bytes, size_t count);
uint32_t fl_crc32(uint32_t crc, const uint8_t *bytes, size_t count);
"""


Build = Callable[..., Path]


@pytest.fixture(scope="session")
def build(tmp_path_factory: pytest.TempPathFactory) -> Build:
    """Return what compiles the framing of a folder with some more sources or flags and returns the file."""

    def built(name: str, *extra: str | Path, core: Path | None = None) -> Path:
        folder = core or firmware_folder() / "core"
        sources = [folder / source for source in SOURCES]
        target = tmp_path_factory.mktemp("core") / name
        subprocess.run([*compiler(), *FLAGS, f"-I{folder}", *sources, *extra, "-o", target], check=True)
        return target

    return built


class Core:
    """The C framing, called from Python."""

    def __init__(self, path: Path) -> None:
        self.ffi = FFI()
        self.ffi.cdef(DECLARED)
        self.lib: Any = self.ffi.dlopen(str(path))

    def encoded(self, frame: bytes, room: int = 300) -> bytes:
        """Return what C makes of a frame."""
        out = self.ffi.new("uint8_t[]", room)
        return bytes(self.ffi.buffer(out, self.lib.fl_frame_encode(out, room, frame, len(frame))))

    def decoded(self, stream: bytes) -> tuple[list[bytes], int]:
        """Return the frames that C finds and how many were broken."""
        decoder = self.ffi.new("fl_decoder *")
        found = []
        for byte in stream:
            if length := self.lib.fl_decode(decoder, byte):
                found.append(bytes(self.ffi.buffer(decoder.frame, length)))
        assert decoder.whole == len(found)
        return found, decoder.broken


@pytest.fixture(scope="session")
def core() -> Core:
    """Return the C framing as a library."""
    folder = firmware_folder() / "core"
    return Core(shared_library("frames", [folder / source for source in SOURCES], [folder]))


@pytest.fixture
def page(monkeypatch: pytest.MonkeyPatch) -> str:
    """Return docs/protocol.md as it is read, its tables filled in."""
    docs = schema_path().parents[1] / "docs"
    monkeypatch.syspath_prepend(str(docs / "_tools"))
    import protocol_tables

    text = (docs / "protocol.md").read_text(encoding="utf-8")
    filled = {f"protocol_{name}": value for name, value in protocol_tables.texts().items()}
    for name in ("protocol_tables", "tables"):
        del sys.modules[name]
    return re.sub(r"\{\{ (\w+) \}\}", lambda found: filled[found[1]], text)


@pytest.fixture(scope="session")
def boards() -> Any:
    """Return the module board.py: `Board`, `Line`, `BadLine`."""
    spec = importlib.util.spec_from_file_location("board", Path(__file__).with_name("board.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
