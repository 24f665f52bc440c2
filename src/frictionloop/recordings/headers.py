"""What a header or an attribute says of a column: its name without the unit, the unit, and how numbers are packed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import must_be
from frictionloop.quantities.units import UNITS, known_unit

Array = NDArray[np.float64]
_IN_BRACKETS = re.compile(r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*")
_AFTER_A_MARK = re.compile(r"(.+?)(?:\s*[/,]\s*|\s+(?:in\s+)?)(\S+)")
_AS_SUFFIX = re.compile(r"(.+)_(n|mn|un|kn|v|mv|uv|kgf|gf|kg|g|s|ms|us|[µμ]s|mm)", re.IGNORECASE)
_TIMES = ("time", "t", "timestamp", "zeit", "temps")


OTHERS = {each.lower(): each for each in ("Hz", "kHz", "MHz", "dB", "%", "deg", "°", "rad", "Pa", "kPa", "bar", "rpm")}
"""Units of other things than forces and times: told apart from the name, and never scaled."""
UNIT_NAMES = ("units", "unit")
"""Attributes that say the unit, in any case."""


class Header(NamedTuple):
    """A column's name without its unit, and the unit: one that is known, or what stands in its place."""

    name: str
    unit: str | None


def header(text: str) -> Header:
    """Return what a header says: "Ft [mN]", "Ft (mN)", "Ft/mN", "Ft in mN" and "ft_mn" are all in mN."""
    text = text.strip()
    if match := _IN_BRACKETS.fullmatch(text):
        return Header(match[1].strip(), said_unit(match[2]) or match[2] or None)
    if (match := _AFTER_A_MARK.fullmatch(text)) and said_unit(match[2]):
        return Header(match[1].strip(), said_unit(match[2]))
    if match := _AS_SUFFIX.fullmatch(text):
        lower = {unit.lower(): unit for unit in UNITS}
        return Header(match[1], lower.get(match[2].lower(), "us"))
    return Header(text, None)


def said_unit(text: str) -> str | None:
    """Return how this package spells a unit, also one that it cannot scale; None for what is none."""
    return known_unit(text) or OTHERS.get(text.strip().lower())


def is_time(text: str) -> bool:
    """Return whether a header is that of a column of times."""
    name, unit = header(text)
    return name.lower() in _TIMES and (unit not in UNITS or UNITS[unit][0] == "s")


def scale_of(where: str, given: str | None, found: str | None, wanted: str) -> float:
    """Return the factor from a column's unit to the wanted one; a column that says nothing is in the wanted one."""
    stated = found if given is None else known_unit(given)
    weighed = found in ("g", "kg") and stated == f"{found}f"  # which a scale writes as a mass
    if given is not None and found in UNITS and stated != found and not weighed:
        raise must_be(f"{where}: unit", given, f"{found!r}, as in the file")
    if given is None and found is None:
        return 1.0
    if stated not in UNITS or UNITS[stated][0] != wanted:
        unit = given or found
        force = UNITS[f"{stated}f"][1] if wanted == "N" and stated in ("g", "kg") else 0.0
        known = f', such as {force:g}, or unit = "{stated}f"' if force else ""
        known += "" if given or found in UNITS else f', or unit = "{wanted}"'
        raise must_be(f"{where} in {unit}: scale", None, f"{wanted} per {unit}{known}")
    return UNITS[stated][1]


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
    text = text.partition(" since ")[0]  # NetCDF: nanoseconds since 2024-03-05
    return known_unit(text) or text.strip() or None
