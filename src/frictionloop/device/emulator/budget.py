"""What the cycles of a tick period go to: traced on an image, and held against what there is."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce

from frictionloop.device.codec import encode
from frictionloop.device.emulator.corpus import SESSION, TICK_HZ, edges, heartbeat, opening, strokes
from frictionloop.device.emulator.costs import OTHERWISE, Waits
from frictionloop.device.emulator.serial_port import QUEUE
from frictionloop.device.emulator.teensy import BACKGROUND, PORT, TICK, TeensyEmulator
from frictionloop.device.emulator.trace import NOTHING, CycleTrace, Spent
from frictionloop.quantities.schema import schema

SAMPLES, FLOODED = 400, 200
BEAT = TICK_HZ * schema()["protocol"]["beat_ms"] // 1000
LINE_BYTES = 40
"""What the line takes in a tick, either way: 2 Mbaud."""
PROMPT = 4
"""Bytes at which the port asks for its interrupt; twice as many wait where something kept it waiting."""


@dataclass(frozen=True)
class Budget:
    """What an image was seen to take.

    Attributes
    ----------
    ticks, backgrounds
        Each tick's interrupt, and the background until the next, while everything is told at every tick.
    interrupts
        Each of the port's, while besides the host never stops to ask.
    ports, floods
        All interrupts of the port and the background of each tick, likewise.
    effects
        Each tick's interrupt again, with the effect that takes longest in the place of a set-point table.
    """

    ticks: list[Spent]
    backgrounds: list[Spent]
    interrupts: list[Spent]
    ports: list[Spent]
    floods: list[Spent]
    effects: list[Spent]

    @property
    def worst(self) -> Spent:
        """The tick that takes the most cycles."""
        return max(self.ticks, key=lambda spent: spent.cycles)

    def rows(self, waits: Waits) -> dict[str, int]:
        """Return the cycles of a tick period by what they go to.

        The longest tick, the most that a full line interrupts in a tick, the background on average: what it does not
        get to in a period it does in the next. ``flood`` is what the background would take while the host never stops
        to ask; ``longest_interrupt`` is what a tick may have to wait for; ``effect`` is the longest tick of any effect.
        """
        tick, port, longest = (_most(part, waits) for part in (self.ticks, self.ports, self.interrupts))
        effect = _most(self.effects, waits)
        background, flood = (_mean(part, waits) for part in (self.backgrounds, self.floods))
        whole = tick + port + background
        return {
            "tick": tick, "interrupts": port, "background": background, "sum": whole, "flood": flood,
            "longest_interrupt": longest, "effect": effect,
        }  # fmt: skip

    def table(self) -> dict[str, dict[str, int]]:
        """Return `rows` for each of the waits of `OTHERWISE`."""
        return {name: self.rows(waits) for name, waits in OTHERWISE.items()}


def traced(image_path: str | os.PathLike[str]) -> Budget:
    """Run an image of a Teensy on strokes of a finger and on edges, then on a line that is full both ways.

    Raises
    ------
    FrictionloopError
        As `TeensyEmulator`, and without capstone.
    """
    interrupts, ports, floods = _flooded(image_path, PROMPT)
    longest = _told(image_path, effect=True)[0]
    return Budget(*_told(image_path), interrupts + _flooded(image_path, QUEUE)[0], ports, floods, longest)


def _most(part: list[Spent], waits: Waits) -> int:
    return max(round(spent.under(waits)) for spent in part)


def _mean(part: list[Spent], waits: Waits) -> int:
    return round(sum(spent.under(waits) for spent in part) / len(part))


def _told(image_path: str | os.PathLike[str], effect: bool = False) -> tuple[list[Spent], list[Spent]]:
    """Return what ticks take, and the background: slow and quick strokes, and edges among them, in a closed loop."""
    trace = CycleTrace(emulator := TeensyEmulator(image_path))
    emulator.receive(opening(effect=effect))
    samples = [*strokes(SAMPLES, seed=1), *strokes(SAMPLES, seed=1, speed_mm_s=80.0)]
    samples[50::37] = edges(len(samples[50::37]), seed=1)
    ticks, backgrounds = [], []
    for k, (force, load, position) in enumerate(samples):
        if k % BEAT == BEAT - 1:
            emulator.receive(heartbeat(9 + k))
        parts = trace.parts(force, load, position)
        ticks += parts[TICK]
        backgrounds.append(reduce(Spent.plus, parts[BACKGROUND], NOTHING))
    return ticks, backgrounds


def _flooded(image_path: str | os.PathLike[str], burst: int) -> tuple[list[Spent], list[Spent], list[Spent]]:
    """Return what the port and the background take while all is told at every tick and the host never stops."""
    trace = CycleTrace(emulator := TeensyEmulator(image_path))
    emulator.bursts(burst)
    emulator.receive(opening())
    asked, waiting = _requests(), bytearray()
    interrupts, ports, floods = [], [], []
    for k, (force, load, position) in enumerate(strokes(FLOODED + 50, seed=2)):
        if k >= 20:
            while len(waiting) < LINE_BYTES:
                waiting += next(asked)
            emulator.receive(bytes(waiting[:LINE_BYTES]))
            del waiting[:LINE_BYTES]
        parts = trace.parts(force, load, position)
        if k >= 50:
            interrupts += parts.get(PORT, [])
            ports.append(reduce(Spent.plus, parts.get(PORT, []), NOTHING))
            floods.append(reduce(Spent.plus, parts[BACKGROUND], NOTHING))
    return interrupts, ports, floods


def _requests() -> Iterator[bytes]:
    """Yield the shortest frames that are answered, and now and then one that is answered at length."""
    for sequence in range(100, 2**16):
        name, fields = ("get", {"first": 0, "count": 64}) if sequence % 16 == 0 else ("heartbeat", {})
        yield encode(name, sequence, SESSION, **fields)
