"""How effects are mixed: sum, product, largest, mask."""

from __future__ import annotations

import math
from functools import reduce
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

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

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        return sum(part.asked(touch) for part in self.of)


class Product(_Mix):
    """f = f1 f2 ..., each counted in N: one of them is a force, the others factors."""

    kind: Literal["product"] = "product"

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        return math.prod(part.asked(touch) for part in self.of)


class Largest(_Mix):
    """f = max(f1, f2, ...)."""

    kind: Literal["max"] = "max"

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        return reduce(np.maximum, (part.asked(touch) for part in self.of))


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

    def asked(self, touch: Touch) -> Any:
        """Return the force in N."""
        share = np.clip(self.where.asked(touch), 0.0, 1.0)
        return share * self.effect.asked(touch) + (1.0 - share) * self.outside.asked(touch)


def common(*periods: float | None) -> float | None:
    """Return the one period of several, 0 where nothing varies, None where they differ."""
    found = {period for period in periods if period != 0.0}
    return (found.pop() if found else 0.0) if len(found) <= 1 else None
