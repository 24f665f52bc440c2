"""Pictures as maps of friction, and maps as pictures with their scale. Grey is taken as it is: gamma is ignored.

Colours are weighed as the eye does (ITU-R BT.601), on white where they are transparent.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError, check_known, must_be, replacing
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.value_checks import ABOVE_0, number
from frictionloop.rendering.effect import Effect, Touch
from frictionloop.rendering.force_tables import MOST_CELLS, Map

Polarity = Literal["bright", "dark"]
POLARITIES = ("bright", "dark")
"""What is asked for most: the bright pixels (electroadhesion's convention) or the dark ones (ink that one feels)."""
MODES = {"L": 255, "I;16": 65535, "I;16B": 65535, "I;16L": 65535, "I": 65535, "1": 1}
"""Greys that are read, with their white."""
COLOURS = ("RGB", "RGBA", "P", "LA", "PA")
"""What is turned to grey."""
WHITE_IS_0 = {262: 0}
"""Entry of a TIFF whose 0 is white; of 16 bits Pillow leaves it to others."""
MOST_PIXELS = 100_000_000
"""Pixels of a picture that is opened (assumed: a few hundred megabytes)."""
TEXT = "frictionloop"
"""Entry of a PNG that holds the scale of a map."""


class Picture(NamedTuple):
    """A map made of a picture."""

    map: Map
    reduced: int
    """Pixels along each side that one value is the mean of; 1: the picture as it is."""
    pixels: tuple[int, int]
    """Width and height of the picture."""
    coloured: bool = False
    """Whether it had colours."""


def read_image(
    path: str | os.PathLike[str],
    *,
    mm_per_pixel: float | None = None,
    polarity: Polarity | None = None,
    low_n: float = 0.3,
    high_n: float = 0.6,
    most_cells: int = MOST_CELLS,
) -> Picture:
    """Return a picture as a map of force, its middle at the origin, its upper edge at the largest y.

    Parameters
    ----------
    path : path
        PNG or TIFF of 8 or 16 bits, turned as it says of itself. One that `write_image` wrote brings its own scale.
    mm_per_pixel : float
        Size of a pixel in mm.
    polarity : str
        ``"bright"`` if white is ``high_n`` and black ``low_n``, ``"dark"`` the other way round.
    low_n, high_n : float
        Forces at both ends of grey, N. To use a picture as heights in mm, give those and wrap it: ``Relief``.
    most_cells : int
        Values of the map; a larger picture is reduced by the mean of squares of pixels.

    Raises
    ------
    FrictionloopError
        For a picture that cannot be read or has too many pixels, and without a scale or a polarity.
    """
    grey, coloured, own = _opened(Path(path))
    given = mm_per_pixel is not None or polarity is not None
    scale: dict[str, Any] = {"mm_per_pixel": mm_per_pixel, "polarity": polarity} if given else own
    if not scale or scale.get("mm_per_pixel") is None:
        raise must_be(f"{path}: mm_per_pixel", None, "above 0", "mm")
    if scale.get("polarity") is None:
        raise must_be(f"{path}: polarity", None, "bright or dark")
    check_known("polarity", [str(scale["polarity"])], POLARITIES)
    pitch = number("mm_per_pixel", scale["mm_per_pixel"], "mm", ABOVE_0)
    low, high = (float(scale.get(name, own)) for name, own in (("low_n", low_n), ("high_n", high_n)))
    if not low <= high:
        raise must_be("low_n", low, f"at most {high:g}")
    factor = 1
    while -(-grey.shape[0] // factor) * -(-grey.shape[1] // factor) > most_cells:
        factor += 1
    rows = _reduced(grey, factor)[::-1]
    share = rows if scale["polarity"] == "bright" else 1.0 - rows
    pitch *= factor
    start = [-0.5 * pitch * (count - 1) for count in share.shape]
    start_x, start_y = float(scale.get("start_mm", start[1])), float(scale.get("start_y_mm", start[0]))
    values = low + share * (high - low)
    if values.shape[1] < 2:
        raise must_be(f"{path}: width", values.shape[1], "at least 2", "pixels")
    rules = {name: scale[name] for name in ("between", "beyond") if name in scale}
    made = Map(values_n=values.tolist(), pitch_mm=pitch, start_mm=start_x, start_y_mm=start_y, **rules)
    return Picture(made, factor, (grey.shape[1], grey.shape[0]), coloured)


def _opened(path: Path) -> tuple[np.ndarray, bool, dict[str, Any]]:
    """Return the greys of a picture from black 0 to white 1, whether it had colours, and the scale it brings."""
    import json
    import warnings

    image_module: Any = needed("PIL.Image", "Pillow", "rendering")
    if not path.is_file():
        raise FrictionloopError(f"{path}: no such file")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", image_module.DecompressionBombWarning)
            # From a stream: a file that Pillow maps has its rows mixed up where a TIFF is turned (13.0).
            with path.open("rb") as stream, image_module.open(stream) as image:
                width, height = image.size
                if width * height > MOST_PIXELS:
                    raise _too_many(path, width * height, f"{width} x {height}")
                own = json.loads(image.text[TEXT]) if TEXT in getattr(image, "text", {}) else {}
                return _greys(path, image), image.mode in COLOURS, own
    except FrictionloopError:
        raise
    except image_module.DecompressionBombError as error:  # it has the number of pixels first
        raise _too_many(path, int("".join(c for c in str(error).split(")")[0] if c.isdigit()))) from None
    except Exception as error:  # on a damaged picture the library raises anything
        reason = (str(error) or type(error).__name__).splitlines()[0]
        raise FrictionloopError(f"{path}: is no picture ({reason:.120})") from None


def _greys(path: Path, image: Any) -> np.ndarray:
    image_module: Any = needed("PIL.Image", "Pillow", "rendering")
    upside_down = image.mode.startswith("I") and WHITE_IS_0.items() <= dict(getattr(image, "tag_v2", {})).items()
    image = needed("PIL.ImageOps", "Pillow", "rendering").exif_transpose(image)
    if image.mode in COLOURS:
        full = image.convert("RGBA")
        image = image_module.alpha_composite(image_module.new("RGBA", full.size, "white"), full).convert("L")
    if image.mode not in MODES:
        raise must_be(f"{path}: mode", image.mode, f"grey, {', '.join(COLOURS)}")
    grey, white = np.asarray(image, dtype=float), MODES[image.mode]
    if (wrong := grey[(grey < 0) | (grey > white)]).size:
        raise must_be(f"{path}: greys", float(wrong[0]), f"0 to {white}")
    return 1.0 - grey / white if upside_down else grey / white


def _too_many(path: Path, pixels: int, said: str = "") -> FrictionloopError:
    factor = int(np.ceil(np.sqrt(pixels / MOST_PIXELS)))
    said = said or f"{pixels:,}"
    return FrictionloopError(f"{path}: has {said} pixels: must be at most {MOST_PIXELS:,}; reduce it by {factor}")


def _reduced(grey: np.ndarray, factor: int) -> np.ndarray:
    """Return the means of squares of pixels; those at the edges are made whole by repeating the last pixels."""
    if factor == 1:
        return grey
    room = [(0, -count % factor) for count in grey.shape]
    padded = np.pad(grey, room, mode="edge")
    rows, columns = (count // factor for count in padded.shape)
    return np.asarray(padded.reshape(rows, factor, columns, factor).mean(axis=(1, 3)))


def write_image(made: Map, path: str | os.PathLike[str], polarity: Polarity = "bright") -> None:
    """Write a map as a PNG of 16 bits that carries its scale; `read_image` gives it back to 1/65535 of its range.

    Raises
    ------
    FrictionloopError
        For what is no map, or a file that cannot be written.
    """
    import json

    if not isinstance(made, Map):
        raise must_be("map", made, "a Map")
    check_known("polarity", [polarity], POLARITIES)
    image_module: Any = needed("PIL.Image", "Pillow", "rendering")
    info: Any = needed("PIL.PngImagePlugin", "Pillow", "rendering").PngInfo()
    table = made.table[::-1]
    low, high = float(table.min()), float(table.max())
    share = (table - low) / (high - low) if high > low else 0.0 * table
    share = share if polarity == "bright" else 1.0 - share
    scale: dict[str, Any] = {"mm_per_pixel": made.pitch_mm, "polarity": polarity, "low_n": low, "high_n": high}
    scale |= {"start_mm": made.start_mm, "start_y_mm": made.start_y_mm}
    scale |= {"between": made.between, "beyond": made.beyond}
    info.add_text(TEXT, json.dumps(scale))
    with replacing(path) as beside:
        image_module.fromarray(np.round(65535 * share).astype(np.uint16)).save(beside, format="PNG", pnginfo=info)


def rasterise(effect: Effect, width_mm: float, height_mm: float = 0.0, pitch_mm: float = 0.25) -> Map:
    """Return an effect of place as a map around the origin; of one that depends on the touch, what it asks forth."""
    number("pitch_mm", pitch_mm, "mm", ABOVE_0)
    columns, rows = round(width_mm / pitch_mm) + 1, round(height_mm / pitch_mm) + 1
    if not (columns >= 2 and columns * rows <= MOST_CELLS):
        accepted = f"must give 2 to {MOST_CELLS} values, not {columns} x {rows}"
        raise FrictionloopError(f"pitch_mm = {pitch_mm:g} mm: {accepted}")
    if effect.period_mm and effect.period_mm < 2.0 * pitch_mm:
        raise must_be("pitch_mm", pitch_mm, f"at most {0.5 * effect.period_mm:g}", "mm")
    x = pitch_mm * (np.arange(columns) - 0.5 * (columns - 1))
    y = pitch_mm * (np.arange(rows) - 0.5 * (rows - 1))
    grid = np.meshgrid(x, y)
    force = np.broadcast_to(effect.force_of(Touch(grid[0], grid[1], 20.0, 0.5, 1e6)), grid[0].shape)
    return Map(values_n=force.tolist(), pitch_mm=pitch_mm, start_mm=float(x[0]), start_y_mm=float(y[0]))


def text_map(text: str, height_mm: float = 8.0, low_n: float = 0.3, high_n: float = 0.6, pitch_mm: float = 0.25) -> Map:
    """Return a text as a map: letters of ``high_n`` on a surface of ``low_n``, ``height_mm`` high.

    Raises
    ------
    FrictionloopError
        For an empty text, or one that has no room in a map.
    """
    image_module: Any = needed("PIL.Image", "Pillow", "rendering")
    draw_module: Any = needed("PIL.ImageDraw", "Pillow", "rendering")
    font_module: Any = needed("PIL.ImageFont", "Pillow", "rendering")
    if not text.strip():
        raise must_be("text", text, "one letter or more")
    font = font_module.load_default(size=max(height_mm / pitch_mm, 6.0))
    left, top, right, bottom = font.getbbox(text)
    image = image_module.new("L", (int(right - left) + 4, int(bottom - top) + 4), 0)
    draw_module.Draw(image).text((2 - left, 2 - top), text, fill=255, font=font)
    share = np.asarray(image, dtype=float)[::-1] / 255.0
    if share.size > MOST_CELLS:
        raise must_be("text: values", share.size, f"at most {MOST_CELLS}")
    start = [-0.5 * pitch_mm * (count - 1) for count in share.shape]
    values = (low_n + share * (high_n - low_n)).tolist()
    return Map(values_n=values, pitch_mm=pitch_mm, start_mm=start[1], start_y_mm=start[0])
