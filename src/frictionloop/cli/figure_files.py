"""Figures written into the folder that a person names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from frictionloop.quantities import replacing
from frictionloop.quantities.units import FrictionloopError


def write_figures(option: str, folder: Path, figures: Mapping[str, str]) -> None:
    """Write figures, SVG text by name, into a folder that is made if it is not there; errors name the option."""
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise FrictionloopError(f"{option} = {str(folder)!r}: cannot be created ({error.strerror})") from None
    for name, text in figures.items():
        with replacing(folder / f"{name}.svg") as beside:
            beside.write_text(text, encoding="utf-8")
