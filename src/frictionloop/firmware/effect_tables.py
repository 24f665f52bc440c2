"""An effect as a device plays it: steps, and tables of 16 bit, in one store of words, and as a file.

The steps are those of `rendering.effect_program`. What a device has no room for is sampled more coarsely.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictionloop.findings import Finding
from frictionloop.quantities import must_be, replacing
from frictionloop.quantities.protocol_schema import named, schema
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_program import MOST_TRIGGERS, Do, Program
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.rendering.force_tables import Map

TOLERANCE_N = 5e-5
"""Difference from the simulator's table at which no more values are spent (assumed: a quarter of the 0.2 mN that C and
Python may differ by)."""
GROWTH = 1.2
"""From one number of values that is tried to the next."""


class Piece(NamedTuple):
    """A table over place (mm) or over time (s)."""

    values: np.ndarray
    """Forces in N; of one that repeats, the first again at the end."""
    start: float
    per: float
    """Values per mm, or per s."""
    nearest: bool = False
    repeats: bool = False

    @property
    def values_count(self) -> int:
        """Values without the one that closes a period."""
        return len(self.values) - self.repeats

    @property
    def least(self) -> int:
        """The fewest values it can have."""
        return 2

    def trimmed(self, reach: float) -> Piece:
        """Return it without values beyond a distance from 0, nor those that only hold an end."""
        if self.repeats or self.nearest:
            return self
        at = self.start + np.arange(len(self.values)) / self.per
        moves = np.flatnonzero(np.diff(self.values))
        first, last = (moves[0], moves[-1] + 1) if moves.size else (0, 1)
        first = max(first, int(np.searchsorted(at, -reach, "right")) - 1)
        last = min(last, int(np.searchsorted(at, reach)))
        first = min(first, len(at) - 2)
        last = max(last, first + 1)
        return self._replace(values=self.values[first : last + 1], start=float(at[first]))

    def resampled(self, size: int) -> Piece:
        """Return it with so many values in all; as it is where it has no more."""
        if size >= len(self.values):
            return self
        at = np.linspace(0.0, len(self.values) - 1.0, size)
        values = self.values[np.rint(at).astype(int)] if self.nearest else self._at(at)
        return self._replace(values=values, per=self.per * (size - 1.0) / (len(self.values) - 1.0))

    def error_n(self, size: int) -> float:
        """Return the largest difference that so many values make."""
        few = self.resampled(size)
        at = np.arange(len(self.values)) * (few.per / self.per)
        if self.nearest:
            return float(np.max(np.abs(few.values[np.floor(at + 0.5).astype(int)] - self.values)))
        return float(np.max(np.abs(np.interp(at, np.arange(size), few.values) - self.values)))

    def needs(self, most: int) -> int:
        """Return the fewest values, at most so many, with which it differs by no more than the tolerance."""
        size = self.least
        while size < min(most, len(self.values)):
            if self.error_n(size) <= TOLERANCE_N:
                return size
            size = max(int(size * GROWTH), size + 1)
        return min(most, len(self.values))

    def _at(self, at: np.ndarray) -> np.ndarray:
        return np.interp(at, np.arange(len(self.values)), self.values)


def shared(needs: Sequence[int], room: int) -> list[int]:
    """Return how many values each piece gets of a room: what it needs, or an even share of what the others leave."""
    given, left = [0] * len(needs), room
    for rank, k in enumerate(sorted(range(len(needs)), key=lambda k: needs[k])):
        given[k] = min(needs[k], left // (len(needs) - rank))
        left -= given[k]
    return given


FULL = 32767
"""Largest value of 16 bits."""
FORMATS = {"u8": "u1", "u16": "<u2", "f64": "<f8"}
STEP = np.dtype([(field["name"], FORMATS[field["format"]]) for field in schema()["effect_step"]])
"""A step as it is sent."""
STEPS: int = schema()["protocol"]["effect_steps"]
HEAD = 4
"""Words before the steps."""
TICK_HZ: float = schema()["protocol"]["tick_hz"]
STORE = 1024
"""Words of the store of the firmware here."""


class EffectTables(NamedTuple):
    """What a device is given of an effect."""

    words: np.ndarray
    """int16: how many steps, whether at the predicted place, the steps, the values."""
    program: Program
    """What these words stand for: `rendering.Player.of` runs it."""
    findings: tuple[Finding, ...]
    """What is sampled more coarsely than in the simulator."""
    error_n: float
    """Largest difference of a table from the simulator's, N; at a step of force half of it, over one pitch."""


def effect_tables(source: EffectSource, length_mm: float, rate_hz: float = TICK_HZ, most: int = STORE) -> EffectTables:
    """Return an effect as words for a device.

    Parameters
    ----------
    source
        The effect, its track, and which position it is asked at. A device without y has the row under the track.
    length_mm
        Length of the plate in mm.
    rate_hz
        Of the ticks.
    most
        Words that the device has room for.

    Raises
    ------
    FrictionloopError
        For more steps or triggers than a device has.
    """
    program = source.program(length_mm)
    if len(program.code) > STEPS:
        raise must_be("effect", len(program.code), f"at most {STEPS} on a device", "steps")
    reach = 0.5 * length_mm
    pieces = {k: _piece(program, step, reach, rate_hz) for k, step in enumerate(program.code) if step[0] <= Do.WAVE}
    room = most - HEAD - len(program.code) * STEP.itemsize // 2
    sizes = shared([piece.needs(room) for piece in pieces.values()], room)
    if any(size < 2 for size in sizes):
        raise must_be("effect", len(pieces), f"at most {room // 2} on a device", "tables")
    fewer = {k: piece.resampled(size) for (k, piece), size in zip(pieces.items(), sizes, strict=True)}
    found, errors = list[Finding](), [program.error_n]
    for (k, piece), size in zip(pieces.items(), sizes, strict=True):
        rounded_n = 0.5 * float(np.max(np.abs(piece.values))) / FULL
        errors.append((piece.error_n(size) if size < len(piece.values) else 0.0) + rounded_n)
        if size < piece.needs(len(piece.values)):
            found.append(_coarser(k, piece, fewer[k], errors[-1]))
    small = _program(program, fewer)
    if rows := _rows(source.effect):
        found.append(Finding("EFFECT-ROW", value=rows))
    words, rounded = _words(small, source.position == "predicted", rate_hz)
    return EffectTables(words, rounded, tuple(found), max(errors))


def _rows(effect: Effect) -> int:
    """Return the rows of the largest map of an effect, 0 without one of several rows."""
    own = len(effect.values_n) if isinstance(effect, Map) and len(effect.values_n) > 1 else 0
    return max([own, *(_rows(part) for part in effect.parts)])


def _piece(program: Program, step: Sequence[float], reach_mm: float, tick_hz: float) -> Piece:
    if step[0] == Do.TABLE:
        _, first, count, start_mm, per_mm, nearest, repeats = step
        values = program.values[int(first) : int(first + count + repeats)]
        if repeats:  # the period that begins nearest to 0
            start_mm -= count / per_mm * round(start_mm * per_mm / count)
        return Piece(values, start_mm, per_mm, bool(nearest), bool(repeats)).trimmed(reach_mm)
    _, first, count, rate_hz, loops, *_ = step
    piece = Piece(program.values[int(first) : int(first + count + loops)], 0.0, rate_hz, False, bool(loops))
    if rate_hz > tick_hz:
        piece = piece.resampled(max(math.floor((len(piece.values) - 1) * tick_hz / rate_hz) + 1, 2))
    return piece


def _coarser(step: int, piece: Piece, fewer: Piece, error_n: float) -> Finding:
    unit = "mm" if piece.start or fewer.per < 1e3 else "s"
    more = {"step": step, "apart": 1.0 / fewer.per, "error": 1e3 * error_n}
    return Finding("EFFECT-COARSER", value=len(fewer.values), unit=unit, limit=len(piece.values), more=more)


def _program(program: Program, pieces: dict[int, Piece]) -> Program:
    """Return the program with these tables."""
    code, tables, first = [], [np.zeros(0)], 0
    for k, step in enumerate(program.code):
        piece = pieces.get(k)
        if piece is None:
            code.append(step)
            continue
        head = step[0], float(first), float(piece.values_count)
        rest = (piece.start, piece.per, *step[5:]) if step[0] == Do.TABLE else (piece.per, *step[4:])
        code.append((*head, *rest))
        tables.append(piece.values)
        first += len(piece.values)
    values = np.concatenate(tables)
    return program._replace(code=tuple(code), tables=(values if values.size else np.zeros(1)).tobytes())


def _words(program: Program, predicted: bool, tick_hz: float) -> tuple[np.ndarray, Program]:
    """Return the words of a program, and the program with the values that these hold."""
    steps = np.zeros(len(program.code), STEP)
    from_word = HEAD + len(steps) * STEP.itemsize // 2
    points, held = np.zeros(int(program.values.size), "<i2"), program.values.copy()
    size = 0
    for step, given in zip(steps, program.code, strict=True):
        fields = _fields(given, tick_hz)
        if given[0] <= Do.WAVE:
            first, count = int(given[1]), int(given[2] + fields["repeats"])
            values = program.values[first : first + count]
            scale = (float(np.max(np.abs(values))) or 1.0) * 2**15 / FULL
            points[first : first + count] = np.rint(values * 2**15 / scale)
            held[first : first + count] = scale * 2.0**-15 * points[first : first + count]
            size = max(size, first + count)
            fields |= {"first": from_word + first, "scale": scale}
        for name, value in fields.items():
            step[name] = value
        step["what"] = int(given[0])
    head = np.array([len(steps), predicted, 0, 0], "<i2")
    words = np.concatenate([head, steps.view("<i2"), points[:size]]).astype(np.int16)
    return words, program._replace(tables=held.tobytes())


def _fields(given: Sequence[float], tick_hz: float) -> dict[str, Any]:
    do, *numbers = given
    if do == Do.TABLE:
        _, count, start_mm, per_mm, nearest, repeats = numbers
        return {"count": int(count), "start": start_mm, "per": per_mm, "nearest": nearest, "repeats": repeats}
    if do == Do.WAVE:
        _, count, rate_hz, loops, trigger, is_on = numbers
        number = MOST_TRIGGERS if trigger < 0 else int(trigger)
        per = rate_hz / tick_hz
        return {"count": int(count), "number": number, "nearest": is_on, "repeats": loops, "per": per}
    if do == Do.TRIGGER:
        which, kind, on, off, dead_s = numbers[:5]
        dead = math.ceil(dead_s * tick_hz - 1e-6)
        return {"number": int(which), "first": int(kind), "start": on, "per": off, "scale": dead}
    return {"scale": numbers[0]} if do in (Do.SPEED, Do.SCALED) else {}


def tables_tree(tables: EffectTables) -> dict[str, Any]:
    """Return the steps by name with their fields, the values in N, and all words as they are sent."""
    size = STEP.itemsize // 2
    count = len(tables.program.code)
    steps = tables.words[HEAD : HEAD + count * size].copy().view(STEP)
    names, fields = named("steps"), (STEP.names or ())[1:]
    return {
        "steps": [{"what": names[int(step["what"])]} | {name: step[name].item() for name in fields} for step in steps],
        "values_n": tables.program.values.tolist(),
        "words": tables.words.tolist(),
        "error_n": tables.error_n,
        "findings": [each.to_dict() for each in tables.findings],
    }


def write_tables(tables: EffectTables, path: Path) -> None:
    """Write these as JSON; the old file stays whole until the new one is complete.

    Raises
    ------
    FrictionloopError
        For a file that cannot be written.
    """
    with replacing(path) as beside:
        beside.write_text(json.dumps(tables_tree(tables)), encoding="utf-8")
