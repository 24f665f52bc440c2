"""What the instructions of a tick period go to: strokes and edges counted on an image."""

from __future__ import annotations

import os
import zlib
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from frictionloop.device.codec import encode
from frictionloop.device.emulator.instruction_counts import InstructionTrace, Spent
from frictionloop.device.emulator.teensy import BACKGROUND, PORT, TICK, TeensyEmulator
from frictionloop.firmware.effect_tables import HEAD, STEP, STEPS
from frictionloop.quantities.protocol_schema import schema
from frictionloop.rendering.effect_program import Do

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
    tables = {"what": Do.TABLE, "nearest": 1, "repeats": 1, "first": first, "count": 32, "start": 0.3}
    tables |= {"per": 8.7, "scale": 1.1}
    tables_first = (2 * STEPS + 1) // 3
    mixes = STEPS - tables_first - 1
    shape = [Do.TABLE] * tables_first + [Do.MIX] * mixes + [Do.ADD]
    for step, do in zip(steps, shape, strict=True):
        for name, value in (tables if do == Do.TABLE else {"what": do}).items():
            step[name] = value
    values = np.rint(20000 * np.cos(np.arange(33) / 5))
    return np.concatenate([np.array([STEPS, 1, 0, 0]), steps.view("<i2"), values]).astype("<i2")


def hello() -> bytes:
    """Return the first frame of a host; its session is then `SESSION`, where no host was before."""
    return encode("hello", 0, major=schema()["protocol"]["major"], nonce=NONCE)


def heartbeat(sequence: int, session: int = SESSION) -> bytes:
    """Return the frame that keeps the loop closed."""
    return encode("heartbeat", sequence, session)


SAMPLES, FLOODED = 400, 200
BEAT = TICK_HZ * schema()["protocol"]["beat_ms"] // 1000
LINE_BYTES = 40
"""What the line takes in a tick, either way: 2 Mbaud."""


class Instructions(NamedTuple):
    """What an image was seen to take of instructions, in a tick period of 5 kHz.

    Attributes
    ----------
    tick, law
        The most of a tick's interrupt, and of the law with lookup and overdrive in it.
    effect
        The most of a tick with the effect that takes longest in the place of a set-point table.
    interrupts
        The most of all interrupts of the port, while the line is full both ways.
    background
        On average, while everything is told at every tick: what it does not get to in a period it does in the next.
    """

    tick: int
    law: int
    effect: int
    interrupts: int
    background: int


def traced(image_path: str | os.PathLike[str]) -> Instructions:
    """Run an image of a Teensy on strokes of a finger and on edges, then on a line that is full both ways."""
    ticks, backgrounds = _told(image_path)
    longest, _ = _told(image_path, effect=True)
    return Instructions(
        tick=max(spent.instructions for spent in ticks),
        law=max(spent.law for spent in ticks),
        effect=max(spent.instructions for spent in longest),
        interrupts=max(_flooded(image_path)),
        background=round(sum(backgrounds) / len(backgrounds)),
    )


def _told(image_path: str | os.PathLike[str], effect: bool = False) -> tuple[list[Spent], list[int]]:
    """Return what ticks take, and the background: slow and quick strokes, and edges among them, in a closed loop."""
    trace = InstructionTrace(emulator := TeensyEmulator(image_path))
    emulator.receive(opening(effect=effect))
    samples = [*strokes(SAMPLES, seed=1), *strokes(SAMPLES, seed=1, speed_mm_s=80.0)]
    samples[50::37] = edges(len(samples[50::37]), seed=1)
    ticks, backgrounds = [], []
    for k, (force, load, position) in enumerate(samples):
        if k % BEAT == BEAT - 1:
            emulator.receive(heartbeat(9 + k))
        parts = trace.parts(force, load, position)
        ticks += parts[TICK]
        backgrounds.append(sum(spent.instructions for spent in parts[BACKGROUND]))
    return ticks, backgrounds


def _flooded(image_path: str | os.PathLike[str]) -> list[int]:
    """Return what the port takes a tick while all is told at every tick and the host never stops."""
    trace = InstructionTrace(emulator := TeensyEmulator(image_path))
    emulator.receive(opening())
    asked, waiting, ports = _requests(), bytearray(), []
    for k, (force, load, position) in enumerate(strokes(FLOODED + 50, seed=2)):
        if k >= 20:
            while len(waiting) < LINE_BYTES:
                waiting += next(asked)
            emulator.receive(bytes(waiting[:LINE_BYTES]))
            del waiting[:LINE_BYTES]
        parts = trace.parts(force, load, position)
        if k >= 50:
            ports.append(sum(spent.instructions for spent in parts.get(PORT, [])))
    return ports


def _requests() -> Iterator[bytes]:
    """Yield the shortest frames that are answered, and now and then one that is answered at length."""
    for sequence in range(100, 2**16):
        name, fields = ("get", {"first": 0, "count": 32}) if sequence % 16 == 0 else ("heartbeat", {})
        yield encode(name, sequence, SESSION, **fields)
