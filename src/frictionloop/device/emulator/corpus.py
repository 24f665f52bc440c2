"""What a tick is fed for measuring it: strokes of a finger, and what no finger does."""

from __future__ import annotations

import zlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionloop.device.codec import encode
from frictionloop.firmware.effect_tables import HEAD, STEP, STEPS
from frictionloop.quantities.schema import schema
from frictionloop.rendering.program import Do

TICK_HZ = 5000
NONCE = 77
SESSION = NONCE + 1
"""Of the first hello since reset."""
LEAST, LARGEST = -32768, 32767


class Counts(NamedTuple):
    """What the converters give."""

    force: tuple[int, int]
    load: int
    position: int


def strokes(count: int, seed: int = 0, speed_mm_s: float = 20.0) -> Iterator[Counts]:
    """Yield samples of a finger under 0.5 N: there and back, a lift a second, noise, drifting friction."""
    rng = np.random.default_rng(seed)
    for k in range(count):
        phase = k % TICK_HZ
        way = phase if phase < TICK_HZ // 2 else TICK_HZ - phase
        direction = 1 if phase < TICK_HZ // 2 else -1
        touching = not 2000 <= phase < 2200
        force = direction * (8000 + 3000 * np.sin(k / 40)) if touching else 0.0
        load = 3277 if touching else 0
        noise = np.rint(rng.normal(0, (40, 40, 20, 3))).astype(int)
        yield Counts(
            (int(force) + int(noise[0]), int(noise[1])),
            load + int(noise[2]),
            round(speed_mm_s / 5.0 * (way - 1250)) + int(noise[3]),
        )


def edges(count: int, seed: int = 0) -> Iterator[Counts]:
    """Yield samples that jump between the ends of the converters, 0, and anywhere."""
    rng = np.random.default_rng(seed)
    ends = np.array([LEAST, LEAST + 1, -1, 0, 1, LARGEST - 1, LARGEST])
    for _ in range(count):
        anywhere, chosen = rng.integers(LEAST, LARGEST + 1, 4), rng.choice(ends, 4)
        force, across, load, position = (int(x) for x in np.where(rng.random(4) < 0.5, anywhere, chosen))
        yield Counts((force, across), load, position)


def opening(state: str = "closed", effect: bool = False) -> bytes:
    """Return the frames of a host that asks for the most: a table over position, all telemetry, the loop closed.

    With an effect it is the one that takes longest in the place of the table.
    """
    points = costliest() if effect else np.rint(6000 + 2000 * np.sin(np.arange(128) / 5)).astype("<i2")
    source = schema()["sources"]["effect" if effect else "position"]
    play = {"source": source, "loops": not effect, "count": len(points), "step": 2**20, "start_um": 0}
    channels = 2 ** len(schema()["channel"]) - 1
    return b"".join(
        (
            hello(),
            encode("waveform", 1, SESSION, first=0, values=points[:128]),
            encode("waveform", 2, SESSION, first=len(points[:-64]), values=points[-64:]),
            encode("play", 3, SESSION, **play, crc=zlib.crc32(points.tobytes())),
            encode("stream", 4, SESSION, decimation=1, mask=channels),
            encode("mode", 5, SESSION, state=schema()["states"][state]),
        )
    )


def costliest() -> np.ndarray:
    """Return the words of an effect of as many steps as there may be, most of them of the kind that takes longest."""
    steps = np.zeros(STEPS, STEP)
    first = HEAD + STEPS * STEP.itemsize // 2
    tables = {"what": Do.TABLE, "nearest": 1, "repeats": 1, "first": first, "count": 32, "start": 2**20}
    tables |= {"per": 2**29 + 1, "per_shift": 34, "scale": 2**28 + 1}
    tables_first = (2 * STEPS + 1) // 3
    mixes = STEPS - tables_first - 1
    shape = [Do.TABLE] * tables_first + [Do.MIX] * mixes + [Do.ADD]
    for step, do in zip(steps, shape, strict=True):
        for name, value in (tables if do == Do.TABLE else {"what": do}).items():
            step[name] = value
    values = np.rint(20000 * np.cos(np.arange(33) / 5))
    return np.concatenate([np.array([STEPS, 1]), steps.view("<i2"), values]).astype("<i2")


def hello() -> bytes:
    """Return the first frame of a host; its session is then `SESSION`, where no host was before."""
    return encode("hello", 0, major=schema()["protocol"]["major"], nonce=NONCE)


def heartbeat(sequence: int, session: int = SESSION) -> bytes:
    """Return the frame that keeps the loop closed."""
    return encode("heartbeat", sequence, session)
