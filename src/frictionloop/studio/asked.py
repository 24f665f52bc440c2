"""What a page sends along with a command, checked."""

from __future__ import annotations

from typing import Any

from frictionloop.quantities import FrictionloopError


def number(asked: dict[str, Any], name: str, low: float, high: float) -> float:
    """Return a number within its limits."""
    value = asked.get(name)
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not low <= value <= high:
        raise FrictionloopError(f"{name} = {value!r:.40}: must be {low:g} to {high:g}")
    return float(value)


def flag(asked: dict[str, Any], name: str) -> bool:
    """Return yes or no."""
    if not isinstance(value := asked.get(name), bool):
        raise FrictionloopError(f"{name} = {value!r:.40}: must be true or false")
    return value
