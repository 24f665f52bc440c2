"""Where an effect is: moved, turned, scaled, repeated."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from frictionloop.parameters.block import Number, Positive, Whole
from frictionloop.rendering.effect import AnyEffect, Effect, Touch


class Placed(Effect):
    """An effect in coordinates of its own."""

    effect: AnyEffect
    """What is placed."""

    def inside(self, touch: Touch) -> Touch:
        """Return the touch as the effect that is placed sees it."""
        raise NotImplementedError

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        return self.effect.asked(self.inside(touch))


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

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        return self.factor * super().asked(touch)


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
