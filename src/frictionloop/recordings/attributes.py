"""What the attributes of an HDF5 or NetCDF dataset say of its numbers: their unit, and how they are packed."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities.units import known_unit

UNIT_NAMES = ("units", "unit")
"""Attributes that say the unit, in any case."""


def is_bare_dimension(array: Any) -> bool:
    """Tell what NetCDF keeps for a dimension without coordinates: zeros under its name."""
    return bytes(array.attrs.get("NAME", b"")).startswith(b"This is a netCDF dimension but not")


def unpacked(stored: NDArray[Any], packing: Mapping[str, Any]) -> NDArray[Any]:
    """Undo the packing of the NetCDF conventions: what is missing becomes NaN."""
    values = stored
    if "_FillValue" in packing:
        values = np.where(stored == packing["_FillValue"], np.nan, stored)
    if "scale_factor" in packing:
        values = values * packing["scale_factor"]
    return values + packing["add_offset"] if "add_offset" in packing else values


def attribute_unit(attributes: Mapping[str, Any]) -> str | None:
    """Return what an attribute says of the unit, which some programs write as bytes or as a list of one."""
    lower = {name.lower(): value for name, value in attributes.items()}
    said = np.ravel(next((lower[name] for name in UNIT_NAMES if name in lower), ""))
    text = (
        said[0].decode("utf-8", "replace") if said.size and isinstance(said[0], bytes) else "".join(map(str, said[:1]))
    )
    return known_unit(text) or text.strip() or None
