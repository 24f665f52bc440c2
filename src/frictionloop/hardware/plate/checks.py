"""Refusals that the files about the plate share."""

from __future__ import annotations

import math

from frictionloop.quantities import FrictionloopError, unit_of


def check_positive(**values: float) -> None:
    """Refuse a value that is not a finite number above zero, by the name it is passed under."""
    for name, value in values.items():
        if not (isinstance(value, (int, float)) and math.isfinite(value) and value > 0):
            unit = f" {unit_of(name)}" if unit_of(name) else ""
            raise FrictionloopError(f"{name} = {value!r}{unit}: must be a finite number above 0")


def check_mode(nodal_lines: int, side_mm: float, thickness_mm: float) -> None:
    """Refuse a mode that the plate cannot have: fewer lines than bending needs, or shorter than the glass is thick."""
    check_positive(side_mm=side_mm, thickness_mm=thickness_mm)
    if not thickness_mm < side_mm / 1.5:
        raise FrictionloopError(
            f"thickness_mm = {thickness_mm:g}: must be below {side_mm / 1.5:g} for a plate of {side_mm:g} mm, "
            "two thirds of the side along which the wave runs"
        )
    most = most_lines(side_mm, thickness_mm)
    if int(nodal_lines) != nodal_lines or not 2 <= nodal_lines <= most:
        raise FrictionloopError(
            f"nodal_lines = {nodal_lines}: must be a whole number from 2 to {most}, where half a wavelength on "
            f"{side_mm:g} mm is as short as the glass is thick, {thickness_mm:g} mm"
        )


def most_lines(side_mm: float, thickness_mm: float) -> int:
    """Return the most nodal lines at which half a wavelength, L/(N - 1/2), is not shorter than the thickness."""
    return math.floor(side_mm / thickness_mm * (1 + 1e-12) + 0.5)
