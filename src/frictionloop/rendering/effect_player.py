"""An effect compiled along a path, and played one control period after the other."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, Self

import numpy as np

from frictionloop.parameters.block import Block
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect import TOUCHES_N, Effect, Touch, Track
from frictionloop.rendering.effect_composition import (
    At,
    Directed,
    Largest,
    Mask,
    Placed,
    Product,
    Relief,
    Scale,
    Sum,
    Trigger,
)
from frictionloop.rendering.effect_program import FAR_S, KEPT, MOST_TRIGGERS, STACK, WIDTH, Do, Program, build_play
from frictionloop.rendering.force_tables import Map, Wave
from frictionloop.rendering.shapes import Detents, Ridge, Viscous

POINTS, PERIOD_POINTS = 32768, 2048
"""Values of a table over the whole plate, and over one period of what repeats."""

Chart = Callable[[Touch], Touch]


@lru_cache(maxsize=256)
def program_of(effect: Effect, path: Track, length_mm: float) -> Program:
    """Return an effect compiled for a path whose middle is the middle of a plate of this length.

    Raises
    ------
    FrictionloopError
        For more triggers, or a deeper tree, than a program has room for.
    """
    compiler = _Compiler(path, length_mm)
    compiler.lower(effect, lambda touch: touch, 0)
    if compiler.triggers > MOST_TRIGGERS:
        raise must_be("effect: triggers", compiler.triggers, f"at most {MOST_TRIGGERS}")
    if compiler.deepest > STACK:
        raise must_be("effect: depth", compiler.deepest, f"at most {STACK}")
    values = np.concatenate(compiler.tables) if compiler.tables else np.zeros(1)
    return Program(
        tuple(compiler.code), values.tobytes(), compiler.triggers, compiler.error_n, float(values.min()),
        float(values.max()),
    )  # fmt: skip


class _Compiler:
    def __init__(self, path: Track, length_mm: float) -> None:
        self.path, self.length_mm = path, length_mm
        self.code: list[tuple[float, ...]] = []
        self.tables: list[np.ndarray] = []
        self.size, self.triggers, self.deepest, self.error_n = 0, 0, 0, 0.0

    def emit(self, do: Do, *numbers: float) -> None:
        self.code.append((float(do), *map(float, numbers), *[0.0] * (WIDTH - 1 - len(numbers))))

    def lower(self, effect: Effect, chart: Chart, depth: int) -> None:
        """Add what leaves the force of an effect on the stack, on which ``depth`` numbers are."""
        self.deepest = max(self.deepest, depth + 1)
        if effect.is_static:
            self.table(effect, effect.force_of, chart)
        elif isinstance(effect, Sum | Product | Largest):
            self.mix(effect, chart, depth)
        elif isinstance(effect, Scale):
            self.lower(effect.effect, _then(chart, effect), depth)
            self.emit(Do.SCALED, effect.factor)
        elif isinstance(effect, Placed):
            self.lower(effect.effect, _then(chart, effect), depth)
        elif isinstance(effect, Mask):
            self.select(depth, lambda: self.lower(effect.where, chart, depth), effect.effect, effect.outside, chart)
        elif isinstance(effect, Directed):
            self.select(depth, lambda: self.emit(Do.DIRECTION), effect.forth, effect.back, chart)
        elif isinstance(effect, Ridge | Detents | Relief):
            self.table(effect, lambda touch: effect.force_of(touch._replace(speed_mm_s=0.0)), chart)
            self.emit(Do.DIRECTION)
            self.emit(Do.MULTIPLY)
            self.deepest = max(self.deepest, depth + 2)
        elif isinstance(effect, Viscous):
            self.emit(Do.SPEED, 1e-3 * effect.per_speed_n_s_m)
        elif isinstance(effect, Wave):
            self.wave(effect, -1, True)
        elif isinstance(effect, Trigger):
            self.trigger(effect, chart, depth)
        else:
            raise must_be("effect.kind", effect.kind, "of place alone")

    def mix(self, effect: Sum | Product | Largest, chart: Chart, depth: int) -> None:
        """Add the parts, those of place alone as one table."""
        do = {"sum": Do.ADD, "product": Do.MULTIPLY, "max": Do.LARGER}[effect.kind]
        still = tuple(part for part in effect.of if part.is_static)
        rest = [part for part in effect.of if not part.is_static]
        together: list[Effect] = [type(effect)(of=still)] if len(still) > 1 else list(still)
        for number, part in enumerate([*together, *rest]):
            self.lower(part, chart, depth + (number > 0))
            if number:
                self.emit(do)

    def select(self, depth: int, push: Callable[[], None], one: Effect, other: Effect, chart: Chart) -> None:
        push()
        self.lower(one, chart, depth + 1)
        self.lower(other, chart, depth + 2)
        self.emit(Do.MIX)

    def trigger(self, effect: Trigger, chart: Chart, depth: int) -> None:
        from frictionloop.rendering.shapes import Constant

        number, self.triggers = self.triggers, self.triggers + 1
        quantity, on, off = effect.condition
        if quantity == "x":
            on, off = self.along(on, chart), self.along(off, chart)
        kind = {"load": 0.0, "speed": 1.0, "x": 2.0}[quantity]
        nothing = Constant(level_n=0.0)
        self.select(
            depth,
            lambda: self.emit(Do.TRIGGER, number, kind, on, off, effect.dead_s),
            effect.then or nothing,
            effect.otherwise or nothing,
            chart,
        )
        for wave, is_on in ((effect.starts, True), (effect.ends, False)):
            if isinstance(wave, Wave):
                self.deepest = max(self.deepest, depth + 2)
                self.wave(wave, number, is_on)
                self.emit(Do.ADD)

    def along(self, x_mm: float, chart: Chart) -> float:
        """Return the way along the path at which the effect's own x is this."""
        at = np.array([-0.5, 0.0, 0.5]) * self.length_mm
        x = np.asarray(chart(self.path.touch(at)).x_mm, float)
        slope = (x[2] - x[0]) / (at[2] - at[0])
        if not abs(slope) > 1e-6 or not math.isclose(x[1], 0.5 * (x[0] + x[2]), abs_tol=1e-9 * self.length_mm):
            raise FrictionloopError("trigger.on_x_mm: must be crossed once, not inside repeat")
        return float(at[0] + (x_mm - x[0]) / slope)

    def table(self, effect: Effect, asked: Callable[[Touch], object], chart: Chart) -> None:
        """Add a table of what an effect of place asks for along the path."""
        grid = _grid(effect, chart, self.path, self.length_mm)
        path, start, pitch = self.path, grid.start_mm, grid.pitch_mm

        def force(at: np.ndarray) -> np.ndarray:
            return np.broadcast_to(np.asarray(asked(chart(path.touch(at))), float), at.shape)

        at = start + pitch * np.arange(grid.values)
        values = force(at)
        beside = np.append(values, values[:1]) if grid.repeats else values
        if not grid.nearest:
            middle = force((at + 0.5 * pitch)[: beside.size - 1])
            self.error_n = max(self.error_n, float(np.max(np.abs(middle - 0.5 * (beside[1:] + beside[:-1])))))
        self.emit(Do.TABLE, self.size, values.size, start, 1.0 / pitch, grid.nearest, grid.repeats)
        self.add(beside)

    def wave(self, wave: Wave, trigger: int, is_on: bool) -> None:
        values = np.array([*wave.values_n, *wave.values_n[:1]] if wave.loops else wave.values_n)
        count = values.size - wave.loops
        self.emit(Do.WAVE, self.size, count, wave.rate_hz, wave.loops, trigger, is_on)
        self.add(values)

    def add(self, values: np.ndarray) -> None:
        self.tables.append(values)
        self.size += values.size


class _Grid(NamedTuple):
    start_mm: float
    pitch_mm: float
    values: int
    nearest: bool
    repeats: bool


def _grid(effect: Effect, chart: Chart, path: Track, length_mm: float) -> _Grid:
    """Return where an effect of place is sampled: where its own table has values, over a period, or over the plate."""
    ends = chart(path.touch(np.array([0.0, 1.0])))
    (x0, x1), per = np.broadcast_to(ends.x_mm, 2), 0.0
    flat, per = np.ptp(np.broadcast_to(ends.y_mm, 2)) == 0.0, float(x1 - x0)
    offset, inner = 0.0, effect
    while isinstance(inner, At):
        offset, inner = offset + inner.x_mm, inner.effect
    if isinstance(inner, Map) and flat and per == 1.0:
        start = inner.start_mm + offset - float(x0)
        nearest, repeats = inner.between == "nearest", inner.beyond == "repeat"
        return _Grid(start, inner.pitch_mm, len(inner.values_n[0]), nearest, repeats)
    period = effect.spacing_mm if isinstance(effect, Detents) else effect.period_mm
    if period == 0.0:
        return _Grid(0.0, 1.0, 2, False, False)
    if period is not None and flat and per != 0.0:
        period /= abs(per)
        if period <= length_mm:
            points = max(PERIOD_POINTS, math.ceil(POINTS * period / length_mm))
            return _Grid(0.0, period / points, points, False, True)
    return _Grid(-0.5 * length_mm, length_mm / (POINTS - 1), POINTS, False, False)


def _then(chart: Chart, placed: Placed) -> Chart:
    return lambda touch: placed.inside(chart(touch))


PLATE_MM = 255.0
"""Length of the plate (paper, Sec. 4.1)."""


class Player:
    """An effect along a path: give it where the finger is, get the force that is asked for.

    >>> from frictionloop.rendering import Grating, Player
    >>> player = Player(Grating(spacing_mm=2.0), band_n=(0.1, 0.8))
    >>> round(player.tick(along_mm=0.5, speed_mm_s=20.0, load_n=0.5, dt=2e-4), 3)
    0.6

    Parameters
    ----------
    effect : Effect
        What is played.
    track : Track
        Where the stroke runs over it; along x by default.
    band_n : (float, float)
        Least and largest force that is asked for: whatever an effect says is limited to it.
    length_mm : float
        Length of the plate.
    """

    def __init__(
        self,
        effect: Effect,
        track: Track | None = None,
        band_n: tuple[float, float] = (0.0, math.inf),
        length_mm: float = PLATE_MM,
    ) -> None:
        if not isinstance(effect, Block) or not isinstance(effect, Effect):
            raise must_be("effect", effect, "an effect")
        if not band_n[0] <= band_n[1]:
            raise must_be("band_n", band_n, "two rising forces")
        self._begin(program_of(effect, track or Track(), length_mm), band_n)

    @classmethod
    def of(cls, program: Program, band_n: tuple[float, float] = (0.0, math.inf)) -> Self:
        """Return the player of a program, such as that of the tables which a device is given."""
        player = cls.__new__(cls)
        player._begin(program, band_n)
        return player

    def _begin(self, program: Program, band_n: tuple[float, float]) -> None:
        self.band_n, self.touches_n = band_n, TOUCHES_N
        self._play = build_play(lambda function: function, 1, plain=False)
        self._numbers = program.numbers.tolist()
        self.reset()

    def reset(self) -> None:
        """Begin anew."""
        self.time_s, self._begins = 0.0, True
        self.clamped_n = 0.0
        """How much the last force was limited, above 0 where more was asked for."""
        self._state = [0.0] * (KEPT - MOST_TRIGGERS) + [FAR_S] * MOST_TRIGGERS + [0.0] * STACK

    def tick(self, along_mm: float, speed_mm_s: float, load_n: float, dt: float) -> float:
        """Return the force in N for where the finger is, and go on by a control period.

        Parameters
        ----------
        along_mm
            Way along the path from its middle, mm.
        speed_mm_s
            Speed along it, mm/s.
        load_n
            Normal force, N; below 0.02 N the finger is in the air, and the force is held.
        dt
            Control period in s.
        """
        touch = along_mm, speed_mm_s, load_n, self.touches_n
        when = self.time_s, self._begins, dt
        force_n, self.clamped_n = self._play(self._state, 0, KEPT, self._numbers, *touch, self.band_n, *when)
        self.time_s, self._begins = self.time_s + dt, False
        return float(force_n)
