"""Effects made of others: mixed, moved, turned, scaled, repeated, or chosen by how one touches."""

from __future__ import annotations

import math
from functools import reduce
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from frictionloop.parameters.block import Number, Positive, Whole
from frictionloop.quantities import must_be
from frictionloop.rendering.effect import AnyEffect, Effect, Touch

Several = Annotated[tuple[AnyEffect, ...], Field(min_length=1)]


class _Mix(Effect):
    of: Several
    """The effects that are mixed."""

    @property
    def period_mm(self) -> float | None:
        """The period that all parts share."""
        return common(*(part.period_mm for part in self.of))


class Sum(_Mix):
    """f = f1 + f2 + ..."""

    kind: Literal["sum"] = "sum"

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return sum(part.force_of(touch) for part in self.of)


class Product(_Mix):
    """f = f1 f2 ..., each counted in N: one of them is a force, the others factors."""

    kind: Literal["product"] = "product"

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return math.prod(part.force_of(touch) for part in self.of)


class Largest(_Mix):
    """f = max(f1, f2, ...)."""

    kind: Literal["max"] = "max"

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return reduce(np.maximum, (part.force_of(touch) for part in self.of))


class Mask(Effect):
    """f = w effect + (1 - w) outside, w limited to 0 to 1."""

    kind: Literal["mask"] = "mask"
    effect: AnyEffect
    """What is felt where ``where`` is 1."""
    where: AnyEffect
    """w, counted in N."""
    outside: AnyEffect
    """What is felt where ``where`` is 0."""

    @property
    def period_mm(self) -> float | None:
        """The period that all parts share."""
        return common(*(part.period_mm for part in self.parts))

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        share = np.clip(self.where.force_of(touch), 0.0, 1.0)
        return share * self.effect.force_of(touch) + (1.0 - share) * self.outside.force_of(touch)


def common(*periods: float | None) -> float | None:
    """Return the one period of several, 0 where nothing varies, None where they differ."""
    found = {period for period in periods if period != 0.0}
    return (found.pop() if found else 0.0) if len(found) <= 1 else None


class Placed(Effect):
    """An effect in coordinates of its own."""

    effect: AnyEffect
    """What is placed."""

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect that is placed sees it."""
        raise NotImplementedError

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return self.effect.force_of(self.inside(touch))


class At(Placed):
    """An effect whose origin is moved."""

    kind: Literal["at"] = "at"
    x_mm: Number = 0.0
    """Where its origin is along the plate."""
    y_mm: Number = 0.0
    """Where it is across."""

    @property
    def period_mm(self) -> float | None:
        """Unchanged."""
        return self.effect.period_mm

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect sees it."""
        return touch._replace(x_mm=touch.x_mm - self.x_mm, y_mm=touch.y_mm - self.y_mm)


class Rotate(Placed):
    """An effect turned anticlockwise about the origin."""

    kind: Literal["rotate"] = "rotate"
    angle_deg: Number = 0.0
    """Angle."""

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect sees it."""
        c, s = math.cos(math.radians(self.angle_deg)), math.sin(math.radians(self.angle_deg))
        x, y = touch.x_mm, touch.y_mm
        return touch._replace(x_mm=c * x + s * y, y_mm=c * y - s * x, heading_deg=touch.heading_deg - self.angle_deg)


class Scale(Placed):
    """An effect with another force and another size."""

    kind: Literal["scale"] = "scale"
    factor: Number = 1.0
    """Factor on the force."""
    stretch: Positive = 1.0
    """Factor on lengths."""

    @property
    def period_mm(self) -> float | None:
        """Stretched."""
        return None if self.effect.period_mm is None else self.effect.period_mm * self.stretch

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect sees it."""
        return touch._replace(x_mm=touch.x_mm / self.stretch, y_mm=touch.y_mm / self.stretch)

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return self.factor * super().force_of(touch)


class Repeat(Placed):
    """What an effect is from x = 0 to ``every_mm``, again and again."""

    kind: Literal["repeat"] = "repeat"
    every_mm: Positive
    """Way after which it begins anew."""
    count: Annotated[Whole, Field(ge=0)] = 0
    """How often, from x = 0 on; 0: without end, in both directions."""

    @property
    def period_mm(self) -> float | None:
        """The way after which it begins anew, if that has no end."""
        return None if self.count else self.every_mm

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect sees it; before the first and after the last as at their ends."""
        turns = np.floor(np.asarray(touch.x_mm) / self.every_mm)
        turns = np.clip(turns, 0, self.count - 1) if self.count else turns
        return touch._replace(x_mm=touch.x_mm - turns * self.every_mm)


class Directed(Effect):
    """One effect on the way forth, another on the way back."""

    kind: Literal["directed"] = "directed"
    forth: AnyEffect
    """Where the speed along the path is positive."""
    back: AnyEffect
    """Where it is negative."""

    @property
    def is_static(self) -> bool:
        """It depends on the direction."""
        return False

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return np.where(touch.direction > 0, self.forth.force_of(touch), self.back.force_of(touch))


class Relief(Effect):
    """The lateral force of a height map, to be added to a carrier: f = load (dh/ds) in the direction of motion.

    As `Ridge`, of any effect of place whose force in N is taken for a height in mm: a picture, dots, a texture.
    """

    kind: Literal["relief"] = "relief"
    height: AnyEffect
    """The height h, counted in mm."""
    load_n: Positive = 0.5
    """Load that the slope is counted with."""
    step_mm: Positive = 0.1
    """Way over which the slope is taken (assumed: finer than a finger feels)."""

    @property
    def is_static(self) -> bool:
        """Its sign is that of the motion."""
        return False

    def _check(self) -> None:
        if not self.height.is_static:
            raise must_be("height.kind", self.height.kind, "of place alone")

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        angle = np.radians(touch.heading_deg)
        dx, dy = 0.5 * self.step_mm * np.cos(angle), 0.5 * self.step_mm * np.sin(angle)
        ends = (touch._replace(x_mm=touch.x_mm + s * dx, y_mm=touch.y_mm + s * dy) for s in (1.0, -1.0))
        ahead, behind = (self.height.force_of(end) for end in ends)
        return self.load_n * (ahead - behind) / self.step_mm * touch.direction


class Trigger(Effect):
    """A condition that starts waves and switches between two effects.

    It turns on where its quantity passes ``on`` and off where it passes ``off`` the other way; ``on`` above ``off``
    means on when high, below it on when low. The difference is its hysteresis.
    """

    kind: Literal["trigger"] = "trigger"
    on_load_n: Number | None = None
    """Load that turns it on."""
    off_load_n: Number | None = None
    """Load that turns it off."""
    on_speed_mm_s: Number | None = None
    """Speed, without its sign, that turns it on."""
    off_speed_mm_s: Number | None = None
    """Speed that turns it off."""
    on_x_mm: Number | None = None
    """Place that turns it on."""
    off_x_mm: Number | None = None
    """Place that turns it off."""
    dead_s: Annotated[Number, Field(ge=0.001, le=10)] = 0.02
    """Time after a change in which nothing changes it (assumed: the skin's strain takes 20 ms to release)."""
    then: AnyEffect | None = None
    """Effect while it is on."""
    otherwise: AnyEffect | None = None
    """Effect while it is off."""
    starts: AnyEffect | None = None
    """Wave added from when it turns on."""
    ends: AnyEffect | None = None
    """Wave added from when it turns off."""

    @property
    def is_static(self) -> bool:
        """It depends on more than the place."""
        return False

    @property
    def condition(self) -> tuple[str, float, float]:
        """Its quantity, ``"load"``, ``"speed"`` or ``"x"``, and the values that turn it on and off."""
        pairs = {name: (getattr(self, on), getattr(self, on.replace("on_", "off_", 1))) for name, on in _PAIRS.items()}
        name, (on, off) = next((name, pair) for name, pair in pairs.items() if pair != (None, None))
        return name, on, off

    def _check(self) -> None:
        given = [on for on in _PAIRS.values() for each in (on, on.replace("on_", "off_", 1)) if self._has(each)]
        if len(given) != 2 or given[0] != given[1]:
            raise ValueError(f"needs one pair of on_* and off_* of {', '.join(_PAIRS.values())}")
        _, on, off = self.condition
        if on == off:
            raise ValueError(f"{given[0]}, {given[0].replace('on_', 'off_', 1)} = {on:g}: must differ")
        for field in ("starts", "ends"):
            wave = getattr(self, field)
            if wave is not None and wave.kind != "wave":
                raise must_be(f"{field}.kind", wave.kind, "wave")

    def _has(self, name: str) -> bool:
        return getattr(self, name) is not None

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N, without hysteresis: on where the quantity is past halfway from off to on."""
        name, on, off = self.condition
        value = {"load": touch.load_n, "speed": np.abs(touch.speed_mm_s), "x": touch.x_mm}[name]
        is_on = (np.asarray(value) - 0.5 * (on + off)) * np.sign(on - off) >= 0.0
        branches = (self.then, self.starts), (self.otherwise, self.ends)
        high, low = (sum(each.force_of(touch) for each in branch if each is not None) for branch in branches)
        return np.where(is_on, high, low)


_PAIRS = {"load": "on_load_n", "speed": "on_speed_mm_s", "x": "on_x_mm"}
