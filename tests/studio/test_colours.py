"""Curves and texts of the page by their colours: told apart by people of every colour vision, light and dark."""

from __future__ import annotations

import itertools
import re
from pathlib import Path

import numpy as np
import pytest

import frictionloop.studio

CSS = (Path(frictionloop.studio.__file__).parent / "static" / "studio.css").read_text()
CURVES = "asked", "open", "closed", "measured"
SEEN = {
    "normal": np.eye(3),
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""Linear RGB as people without one kind of cone see it (Machado, Oliveira and Fernandes 2009, severity 1)."""
APART = 20.0
"""Least distance in CIELAB (assumed: nine times what is just noticeable, 2.3)."""
RGB_TO_XYZ = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
WHITE = np.array([0.9505, 1.0, 1.089])


def lab(colour: str, sight: str) -> np.ndarray:
    """Return a colour as somebody sees it, in CIELAB (CIE 15, D65)."""
    coded = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    linear = np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)
    x, y, z = np.array(RGB_TO_XYZ) @ np.clip(np.array(SEEN[sight]) @ linear, 0.0, 1.0) / WHITE
    f = [np.cbrt(t) if t > 0.008856 else 7.787 * t + 16 / 116 for t in (x, y, z)]
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def test_white_and_a_grey_have_the_values_of_the_standard():
    np.testing.assert_allclose(lab("#ffffff", "normal"), [100.0, 0.0, 0.0], atol=0.02)
    np.testing.assert_allclose(lab("#777777", "normal"), [50.03, 0.0, 0.0], atol=0.02)


@pytest.mark.parametrize("sight", SEEN)
@pytest.mark.parametrize("look", ["light", "dark"])
def test_curves_are_told_apart_by_who_sees_colours_otherwise(look, sight):
    part = CSS.split(":root[data-look")[look == "dark"]
    colours = {name: re.search(rf"--{name}: (#[0-9a-f]{{6}})", part)[1] for name in (*CURVES, "card")}
    for a, b in itertools.combinations(colours, 2):
        assert np.linalg.norm(lab(colours[a], sight) - lab(colours[b], sight)) > APART, (a, b)
