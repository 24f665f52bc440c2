"""What travels over the socket in binary: frames of channels and maps of effects to the page, pointer events from it.

All numbers are little endian. The page reads them in ``static/link.js``.
"""

from __future__ import annotations

import struct
from typing import NamedTuple

import numpy as np

from frictionloop.live.live_session import Block
from frictionloop.quantities import FrictionloopError, must_be

FRAME, MAP, CROWD_FRAME = 1, 2, 3
HEAD = struct.Struct("<IIddfHH")
"""Kind, number of the frame, time of its first row (s), page time of its newest pointer event (ms), time between rows
(s), rows, channels; then float32 by channel."""
MAP_HEAD = struct.Struct("<IIIffffff")
"""Kind, columns, rows, left, right, bottom and top (mm), least and largest force (N); then a byte for each place."""
EVENT = 4
"""Numbers of a pointer event: page time (ms), x and y (mm), load (N); float64."""
MOST_EVENTS = 256
"""Events in one message: one second of a 240 Hz pen."""


class Frame(NamedTuple):
    """A stretch of the session as it travels."""

    number: int
    time_s: float
    reached_ms: float
    spacing_s: float
    rows: np.ndarray
    """Shape (channels, rows), float32."""


def pack(frame: Frame, kind: int = FRAME) -> bytes:
    """Return a frame as bytes: of the session, or of a crowd under its stroke."""
    channels, rows = frame.rows.shape
    head = HEAD.pack(kind, frame.number % 2**32, frame.time_s, frame.reached_ms, frame.spacing_s, rows, channels)
    return head + np.ascontiguousarray(frame.rows, "<f4").tobytes()


def frame_of(block: Block, number: int, rate_hz: float, every: int) -> Frame:
    """Return a block as a frame of one row in so many ticks."""
    first_s = (block.first_tick + every) / rate_hz
    return Frame(number, first_s, block.reached_ms, every / rate_hz, block.rows[:, every - 1 :: every])


def unpack(data: bytes) -> Frame:
    """Return the frame that bytes hold."""
    if len(data) < HEAD.size or data[0] != FRAME:
        raise FrictionloopError(f"frame: {len(data)} bytes that are no frame")
    _, number, time_s, reached_ms, spacing_s, rows, channels = HEAD.unpack_from(data)
    if len(data) != HEAD.size + 4 * rows * channels:
        raise FrictionloopError(f"frame: {len(data)} bytes for {channels} channels of {rows} rows")
    values = np.frombuffer(data, "<f4", offset=HEAD.size).reshape(channels, rows)
    return Frame(number, time_s, reached_ms, spacing_s, values)


def pack_map(force_n: np.ndarray, left: float, right: float, bottom: float, top: float) -> bytes:
    """Return the map of an effect as bytes: force in N, shape (rows, columns), the first row at the bottom."""
    low, high = float(np.min(force_n)), float(np.max(force_n))
    share = (force_n - low) / (high - low) if high > low else np.zeros(force_n.shape)
    rows, columns = force_n.shape
    head = MAP_HEAD.pack(MAP, columns, rows, left, right, bottom, top, low, high)
    return head + np.round(255 * share).astype(np.uint8).tobytes()


def events_in(data: bytes) -> np.ndarray:
    """Return the pointer events of a message, shape (events, 4); load is NaN where the pointer has none."""
    if not data or len(data) % (8 * EVENT) or len(data) > 8 * EVENT * MOST_EVENTS:
        raise must_be("pointer", len(data), f"1 to {MOST_EVENTS} events of {8 * EVENT}", "bytes")
    events = np.frombuffer(data, "<f8").reshape(-1, EVENT)
    if not np.isfinite(events[:, :3]).all() or (events[:, 3] < 0).any() or (events[:, 3] > 20.0).any():
        raise must_be("pointer", events.tolist(), "finite, load_n 0 to 20")
    return events
