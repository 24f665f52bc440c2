"""Sound files as channels, by their own chunks: recorders leave sizes of 0, chunks of odd length and rates of 0."""

from __future__ import annotations

import struct
from functools import partial
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding
from frictionloop.quantities import must_be
from frictionloop.recordings.contents import Channel, Contents, Samples, Stored, is_large

_ORDERS = {b"RIFF": "<", b"RF64": "<", b"RIFX": ">"}
_PCM, _FLOAT, _EXTENSIBLE = 1, 3, 0xFFFE
_NO_SIZE = (0, 0xFFFFFFFF)
"""What stands in the place of a size where the recorder did not come to write it."""
BY = "the header of the WAV file"
COMMENT = b"newtons_per_unit="
"""What a WAV file of this package has as its comment: the scale, and the offset behind a space."""
TAIL = 1024
"""Bytes at the end of a file in which a comment stands."""


class _Sound(NamedTuple):
    path: Path
    order: str
    kind: int
    bits: int
    width: int
    """Channels."""
    rate_hz: int
    at: int
    """Byte at which the samples begin."""
    rows: int
    promised: int
    """Rows by the header, 0 where it says none."""

    @property
    def dtype(self) -> np.dtype[np.generic]:
        if self.kind == _FLOAT:
            return np.dtype(f"{self.order}f{self.bits // 8}")
        return np.dtype({8: "u1", 24: "u1"}.get(self.bits, f"{self.order}i{self.bits // 8}"))

    def read(self, first: int, stop: int) -> NDArray[np.floating]:
        """Return rows, shape (rows, channels); integers as shares of their full scale, -1 to 1."""
        frame = self.width * self.bits // 8
        count = (stop - first) * frame // self.dtype.itemsize
        raw = np.fromfile(self.path, self.dtype, count, offset=self.at + first * frame)
        if self.kind == _FLOAT:
            return np.asarray(raw.reshape(-1, self.width))
        if self.bits == 24:
            high = raw.reshape(-1, 3)[:, :: -1 if self.order == ">" else 1]
            raw = np.concatenate([np.zeros((len(high), 1), np.uint8), high], axis=1).view("<i4")
        zero = 128.0 if self.bits == 8 else 0.0
        return np.asarray((raw.reshape(-1, self.width) - zero) / 2.0 ** (8 * raw.dtype.itemsize - 1))


def wav_contents(path: Path) -> Contents:
    """Return the channels of a WAV file: of 8 to 32 bits, or of floating point, as numbers of its channels."""
    with open(path, "rb") as stream:
        sound = _sound(path, stream)
    rates = {BY: float(sound.rate_hz)} if sound.rate_hz else {}
    full = None if sound.kind == _FLOAT else 1.0
    if is_large(path, sound.rows * sound.width, sound.bits // 8):
        told = sound.read(0, 1).dtype
        lines: list[Samples] = [Stored(sound.rows, told, partial(_line, sound, k)) for k in range(sound.width)]
    else:
        lines = list(sound.read(0, sound.rows).T)
    newtons = _newtons(path)
    channels = (Channel(str(k), line, None, full, newtons, rates, number=k) for k, line in enumerate(lines))
    findings: list[Finding] = []
    if not sound.promised and sound.rows:
        findings.append(Finding("TAKEN-FOR", value=sound.rows, unit="samples", more={"path": "size of the data"}))
    elif sound.promised > sound.rows:
        lost, where = sound.promised - sound.rows, Condition(channel=path.name)
        findings.append(Finding("DATA-GAPS", value=lost, where=where, more={"row": sound.rows - 1}))
    return Contents(tuple(channels), tuple(findings))


def _newtons(path: Path) -> tuple[float, float] | None:
    """Return the scale and the offset that a file of this package brings."""
    with open(path, "rb") as stream:
        stream.seek(max(path.stat().st_size - TAIL, 0))
        _, found, said = stream.read().rpartition(COMMENT)
    scale, offset = map(float, said.split(b"\0")[0].split()) if found else (0.0, 0.0)
    return (scale, offset) if found else None


def _line(sound: _Sound, k: int, first: int, stop: int) -> NDArray[np.floating]:
    return sound.read(first, stop)[:, k]


def _sound(path: Path, stream: BinaryIO) -> _Sound:
    order = _ORDERS.get(stream.read(4))
    stream.seek(8)
    if order is None or stream.read(4) != b"WAVE":
        raise ValueError("no WAV file")
    end, said, long = path.stat().st_size, b"", 0
    while len(head := stream.read(8)) == 8:
        name, size = head[:4], struct.unpack(f"{order}I", head[4:])[0]
        if name == b"data":
            return _of_format(path, order, said, (stream.tell(), long if size == _NO_SIZE[1] and long else size, end))
        content = stream.read(size)
        if name == b"fmt ":
            said = content
        elif name == b"ds64":
            long = struct.unpack(f"{order}Q", content[8:16])[0]
        if size % 2 and stream.read(1) != b"\0":  # a recorder that does not pad
            stream.seek(-1, 1)
    raise ValueError("no samples")


def _of_format(path: Path, order: str, said: bytes, data: tuple[int, int, int]) -> _Sound:
    kind, width, rate_hz, _, _, bits = struct.unpack(f"{order}HHIIHH", said[:16])
    if kind == _EXTENSIBLE:
        kind = struct.unpack(f"{order}H", said[24:26])[0]
    if (kind, bits) not in {(_PCM, 8), (_PCM, 16), (_PCM, 24), (_PCM, 32), (_FLOAT, 32), (_FLOAT, 64)} or not width:
        raise must_be(f"{path}: format of samples", kind, "uncompressed: PCM of 8 to 32 bits, or floating point")
    at, size, end = data
    frame = width * bits // 8
    there = (end - at) // frame
    promised = 0 if size in _NO_SIZE and there else size // frame
    return _Sound(path, order, kind, bits, width, rate_hz, at, min(there, promised) if promised else there, promised)
