"""Recordings as textures played by place, or as waves played over time; waves as WAV files with their scale."""

from __future__ import annotations

import os
import struct
from pathlib import Path

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.checks import ABOVE_0, number
from frictionloop.recordings.read import read_recording
from frictionloop.rendering.tables import MOST_CELLS, Map, Wave

COMMENT = b"newtons_per_unit="
"""What a WAV file of this package has as its comment: the scale, and the offset behind a space."""


def read_texture(recording: Recording, speed_mm_s: float, pitch_mm: float = 0.05) -> Map:
    """Return a recording of a finger that slid at one speed as a map that repeats: x is the speed times the time.

    At another speed its frequencies are those of the place. What this loses: whatever was of the time and not of the
    place (tremor, the finger's own resonance), what changes with speed and load, and the transient at both ends.

    Parameters
    ----------
    recording : Recording
        File and column, with its scale in N; ``offset_n`` and ``remove_mean`` set the level.
    speed_mm_s : float
        Speed at which it was recorded, mm/s.
    pitch_mm : float
        Distance from value to value of the map, mm; the recording is resampled band-limited.

    Raises
    ------
    FrictionloopError
        As ``read_recording``, for a speed or a pitch that is not above 0, and for a recording with no scale.
    """
    speed, pitch = number("speed_mm_s", speed_mm_s, "mm/s", ABOVE_0), number("pitch_mm", pitch_mm, "mm", ABOVE_0)
    force = _read(recording, speed / pitch)
    return Map(values_n=force.tolist(), pitch_mm=pitch, beyond="repeat")


def read_wave(recording: Recording, rate_hz: float) -> Wave:
    """Return a recording as a wave over time, at a rate in Hz.

    Raises
    ------
    FrictionloopError
        As `read_texture`.
    """
    return Wave(values_n=_read(recording, rate_hz).tolist(), rate_hz=rate_hz)


def _read(recording: Recording, rate_hz: float) -> np.ndarray:
    if recording.path.lower().endswith(".wav") and recording.scale is None and recording.unit is None:
        scale, offset = _scale_in(Path(recording.path))
        recording = recording.model_copy(update={"scale": scale, "offset_n": recording.offset_n + offset})
    force = read_recording(recording, rate_hz)
    if force.size > MOST_CELLS:
        raise FrictionloopError(f"{recording.path}: {force.size} values; at most {MOST_CELLS}")
    return force


def _scale_in(path: Path) -> tuple[float, float]:
    """Return the scale and the offset that a WAV file of this package brings."""
    content = path.read_bytes() if path.is_file() else b""
    at = content.rfind(COMMENT)
    if at < 0:
        raise FrictionloopError(f"{path}: scale is missing, in N")
    words = content[at + len(COMMENT) :].split(b"\0")[0].split()
    return float(words[0]), float(words[1])


def write_wave(wave: Wave, path: str | os.PathLike[str]) -> None:
    """Write a wave as a WAV of 16 bits that carries its scale; ``read_wave`` gives it back to 1/65534 of its range.

    Raises
    ------
    FrictionloopError
        For what is no wave, a rate that is not whole, or a file that cannot be written.
    """
    if not isinstance(wave, Wave):
        raise FrictionloopError(f"wave = {wave!r:.60}: must be a Wave")
    if wave.rate_hz != round(wave.rate_hz):
        raise FrictionloopError(f"wave.rate_hz = {wave.rate_hz:g} Hz: must be whole")
    values = np.array(wave.values_n)
    offset = 0.5 * float(values.max() + values.min())
    scale = 0.5 * float(values.max() - values.min()) * 32768 / 32767 or 1.0
    samples = np.round((values - offset) / scale * 32768).astype("<i2").tobytes()
    rate = round(wave.rate_hz)
    comment = COMMENT + f"{scale!r} {offset!r}".encode() + b"\0"
    comment += b"\0" * (len(comment) % 2)
    info = b"INFO" + _chunk(b"ICMT", comment)
    body = _chunk(b"fmt ", struct.pack("<HHIIHH", 1, 1, rate, 2 * rate, 2, 16))
    body += _chunk(b"data", samples) + _chunk(b"LIST", info)
    with replacing(path) as beside:
        beside.write_bytes(_chunk(b"RIFF", b"WAVE" + body))


def _chunk(name: bytes, content: bytes) -> bytes:
    return name + struct.pack("<I", len(content)) + content
