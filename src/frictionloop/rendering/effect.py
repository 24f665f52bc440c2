"""What an effect is: the force asked for at a place, at a speed, under a load, some time after it began.

Friction exists only under sliding, so what an effect asks for is a level of friction, never a push:

- at rest it asks for what its place asks for;
- forth and back ask for the same, but for what depends on the direction, which is that of the last speed above
  ``TURNS_MM_S``: a reversal alone changes nothing in a map;
- in the air the last force is held; at landing the place decides at once;
- beyond the edge of a map the value of its edge goes on, or the map repeats.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from frictionloop.parameters.block import Block, Kinded, Kinds, Number

TURNS_MM_S = 2.0
"""Speed above which the direction of an effect is that of the motion (assumed: as ``touch.load.least_speed_mm_s``)."""
TOUCHES_N = 0.02
"""Load from which a finger touches (assumed: as ``touch.load.touch_n``)."""


class Touch(NamedTuple):
    """A finger at one time: numbers, or arrays of one shape."""

    x_mm: Any = 0.0
    """Place along the plate, from its middle."""
    y_mm: Any = 0.0
    """Place across it."""
    speed_mm_s: Any = 0.0
    """Speed along the path, negative on the way back."""
    load_n: Any = 0.5
    """Normal force."""
    time_s: Any = 0.0
    """Time since the effect, or what triggered it, began."""
    heading_deg: Any = 0.0
    """Direction of the path against x."""

    @property
    def direction(self) -> Any:
        """1 on the way forth and at rest, -1 on the way back."""
        return np.where(np.asarray(self.speed_mm_s) < 0.0, -1.0, 1.0)


class Effect(Kinded):
    """A friction force over place, time and touch.

    ``a + b``, ``a * b`` and ``a.max(b)`` mix two; ``mask``, ``at``, ``rotate``, ``scale`` and ``repeat`` place one.
    """

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N, of the shape of the touch."""
        raise NotImplementedError(f"{type(self).__name__}.force_of(touch) is missing")

    def force_n(self, touch: Touch) -> float:
        """Return the force asked for in N.

        Parameters
        ----------
        touch : Touch
            Where the finger is, how fast it goes and how hard it presses. A trigger is on where its condition holds,
            and its wave began ``time_s`` before.
        """
        return float(self.force_of(touch))

    @property
    def parts(self) -> Iterator[Effect]:
        """Return the effects that this one is made of."""
        for name in type(self).model_fields:
            value = getattr(self, name)
            yield from (each for each in (value if isinstance(value, tuple) else (value,)) if isinstance(each, Effect))

    @property
    def is_static(self) -> bool:
        """Whether the force depends on the place alone."""
        return all(part.is_static for part in self.parts)

    @property
    def period_mm(self) -> float | None:
        """Way along x after which a static effect repeats: 0 for one that is the same everywhere, None without."""
        return None

    def __add__(self, other: Any) -> Effect:
        """Return the sum of the forces; a number is a constant force."""
        return _mixed("sum", self, other)

    __radd__ = __add__

    def __mul__(self, other: Any) -> Effect:
        """Return the product of the forces, each counted in N; a number is a factor."""
        return _mixed("product", self, other)

    __rmul__ = __mul__

    def max(self, other: Any) -> Effect:
        """Return the larger force at each place."""
        return _mixed("max", self, other)

    def mask(self, where: Effect, outside: Effect | float = 0.0) -> Effect:
        """Return this effect where ``where`` is 1 and ``outside`` where it is 0, in proportion between."""
        return _made("mask", effect=self, where=where, outside=_effect(outside))

    def at(self, x_mm: float, y_mm: float = 0.0) -> Effect:
        """Return this effect moved so that its origin is there."""
        return _made("at", effect=self, x_mm=x_mm, y_mm=y_mm)

    def rotate(self, angle_deg: float) -> Effect:
        """Return this effect turned anticlockwise about the origin."""
        return _made("rotate", effect=self, angle_deg=angle_deg)

    def scale(self, factor: float = 1.0, stretch: float = 1.0) -> Effect:
        """Return this effect with its force times ``factor`` and its lengths times ``stretch``."""
        return _made("scale", effect=self, factor=factor, stretch=stretch)

    def repeat(self, every_mm: float, count: int = 0) -> Effect:
        """Return what this effect is from x = 0 to ``every_mm`` again and again, ``count`` times (0: without end)."""
        return _made("repeat", effect=self, every_mm=every_mm, count=count)


class EffectKinds(Kinds):
    """The kinds of effects; a text names one of the library, or a TOML file with one."""

    def sampled(self, value: Any) -> Mapping[str, Any]:
        """Return the tree of a named effect."""
        if isinstance(value, (str, os.PathLike)):
            from frictionloop.rendering.effect_toml import find

            return find(value).model_dump()
        return super().sampled(value)

    def accepted(self) -> str:
        """Return the kinds there are, in words."""
        return f"accepted: {', '.join(map(repr, sorted(self.names)))}"


_HOME = {
    "effect_composition": "sum:Sum product:Product max:Largest mask:Mask directed:Directed trigger:Trigger "
    "relief:Relief at:At rotate:Rotate scale:Scale repeat:Repeat",
    "effects_from_recordings": "resynthesis:Resynthesis",
    "force_tables": "map:Map wave:Wave",
    "shapes": "constant:Constant gradient:Gradient edge:Edge grating:Grating chirp:Chirp ridge:Ridge detents:Detents "
    "texture:Texture dots:Dots viscous:Viscous",
}
"""Where each kind of effect stands, as kind:Class; a file is imported when its kind is used."""
EFFECTS = EffectKinds(
    Effect,
    beside={
        kind: f"frictionloop.rendering.{file}:{name}"
        for file, kinds in _HOME.items()
        for kind, name in (each.split(":") for each in kinds.split())
    },
)
AnyEffect = Annotated[Effect, EFFECTS]


def _made(kind: str, **values: Any) -> Effect:
    effect: Any = EFFECTS[kind]
    return effect(**values)


def _effect(value: Any) -> Effect:
    return value if isinstance(value, Effect) else _made("constant", level_n=value)


def _mixed(kind: str, first: Effect, second: Any) -> Effect:
    """Return a mix; what is of that kind already gives its parts, so that a sum of three is one sum."""
    both = first, _effect(second)
    flat = tuple(each for part in both for each in (part.parts if part.kind == kind else (part,)))
    return _made(kind, of=flat)


class Track(Block):
    """Where the stroke of a finger runs over an effect: a straight line."""

    x_mm: Number = 0.0
    """Place of the middle of the stroke along the plate."""
    y_mm: Number = 0.0
    """Place of the middle of the stroke across the plate."""
    heading_deg: Number = 0.0
    """Direction of the stroke against x."""

    def touch(self, along_mm: Any, speed_mm_s: Any = 0.0, load_n: Any = 0.5, time_s: Any = 0.0) -> Touch:
        """Return the touch at a way along the path from the middle of the stroke."""
        c, s = math.cos(math.radians(self.heading_deg)), math.sin(math.radians(self.heading_deg))
        x, y = self.x_mm + c * np.asarray(along_mm, float), self.y_mm + s * np.asarray(along_mm, float)
        return Touch(x, y, speed_mm_s, load_n, time_s, self.heading_deg)
