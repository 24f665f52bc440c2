"""Effects that a page brings along: a picture, a recording, or what was painted on it, each read within limits."""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from frictionloop.parameters.input_signals import Recording
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.optional_libraries import needed
from frictionloop.recordings.file_opening import read_contents
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effects_from_recordings import read_texture, read_wave
from frictionloop.rendering.force_tables import MOST_CELLS, Map
from frictionloop.rendering.images import read_image
from frictionloop.rendering.library import summary
from frictionloop.studio.connections import as_file
from frictionloop.studio.effect_pictures import PAINT_MM, PAINT_MOST_N

MOST_BYTES = 4 * 1024 * 1024
"""Length of what a page may bring (assumed: a picture of the pixels below, or 20 s of sound)."""
MOST_PIXELS = 4_000_000
"""Pixels of a picture (assumed: a hundred times the values of a map; it takes a tenth of a second)."""
PITCH_MM = 0.05
"""Distance of the values of a recording, mm: at 40 mm/s it carries 400 Hz, about what is felt."""
WAVE_HZ = 1000.0
"""Values a second of a recording that is played over time: twice the fastest that touch knows."""


class Brought(NamedTuple):
    """An effect of a page's own, and what was made of it in words."""

    effect: Effect
    told: str


def brought(kind: str, content: bytes, asked: Mapping[str, str]) -> Brought:
    """Return the effect that a page has brought along.

    Parameters
    ----------
    kind : str
        ``"png"``, ``"wav"`` or ``"paint"``.
    content : bytes
        The file, or a byte for each painted place: rows over x, the lowest first.
    asked : mapping
        Of a picture ``mm_per_pixel``, ``polarity``, ``low_n`` and ``high_n``; of a recording ``scale_n``, ``offset_n``,
        whether it is played over ``place`` or over ``time`` (``over``), and for the first ``speed_mm_s``; of a painting
        ``columns`` and ``rows``.
    """
    if kind not in _READERS:
        raise must_be("kind", kind[:40], ", ".join(_READERS))
    if len(content) > MOST_BYTES:
        raise must_be("file", len(content), f"at most {MOST_BYTES}", "bytes")
    return _READERS[kind](content, asked)


def _number(asked: Mapping[str, str], name: str, low: float, high: float) -> float:
    try:
        value = float(asked[name])
    except (KeyError, ValueError):
        raise must_be(name, asked.get(name), f"{low:g} to {high:g}") from None
    if not low <= value <= high:
        raise must_be(name, value, f"from {low:g} to {high:g}")
    return value


def _picture(content: bytes, asked: Mapping[str, str]) -> Brought:
    """Return a picture as a map."""
    pitch, polarity = _number(asked, "mm_per_pixel", 0.01, 50.0), asked.get("polarity", "")
    if polarity not in ("bright", "dark"):
        raise must_be("polarity", polarity[:20], "'bright' or 'dark'")
    low, high = (_number(asked, name, 0.0, 5.0) for name in ("low_n", "high_n"))
    image_module: Any = needed("PIL.Image", "Pillow", "rendering")
    try:
        with image_module.open(io.BytesIO(content), formats=["PNG"]) as image:
            width, height = image.size
            if width * height > MOST_PIXELS:
                raise must_be("picture", f"{width} x {height} pixels", f"at most {MOST_PIXELS}")
    except FrictionloopError:
        raise
    except Exception:  # on a damaged picture the library raises anything
        raise FrictionloopError("picture: is no PNG") from None
    with as_file(content, "picture.png", "picture") as path:
        made = read_image(path, mm_per_pixel=pitch, polarity=polarity, low_n=low, high_n=high)  # type: ignore[arg-type]
    return Brought(made.map, summary(made.map) + ", colours in grey" * made.coloured)


def _recording(content: bytes, asked: Mapping[str, str]) -> Brought:
    over, scale = asked.get("over", ""), _number(asked, "scale_n", 1e-3, 10.0)
    offset = _number(asked, "offset_n", 0.0, 5.0)
    if over not in ("place", "time"):
        raise must_be("over", over[:20], "'place' or 'time'")
    per_s = _number(asked, "speed_mm_s", 1.0, 1000.0) / PITCH_MM if over == "place" else WAVE_HZ
    with as_file(content, "recording.wav", "recording") as path:
        sound = read_contents(path).channels[0]
        length_s = sound.samples.size / next(iter(sound.rates_hz.values()), per_s)
        if length_s > (most_s := MOST_CELLS / per_s):
            raise must_be("recording: length", length_s, f"at most {most_s:.3g} s", "s")
        recording = Recording(path=str(path), column="0", scale=scale, offset_n=offset, remove_mean=True)
        if over == "time":
            wave = read_wave(recording, per_s).model_copy(update={"loops": True})
            return Brought(wave, summary(wave))
        effect = read_texture(recording, per_s * PITCH_MM, PITCH_MM)
    return Brought(effect, summary(effect))


def _painting(content: bytes, asked: Mapping[str, str]) -> Brought:
    columns, rows = (int(_number(asked, name, 2, 2000)) for name in ("columns", "rows"))
    if len(content) != columns * rows:
        raise must_be("painting", len(content), f"{columns * rows}, columns x rows", "bytes")
    force = np.round(PAINT_MOST_N / 255 * np.frombuffer(content, np.uint8).reshape(rows, columns), 4)
    start = [-0.5 * PAINT_MM * (count - 1) for count in (columns, rows)]
    try:
        made = Map(values_n=force.tolist(), pitch_mm=PAINT_MM, start_mm=start[0], start_y_mm=start[1])
    except ValueError as error:
        raise FrictionloopError(f"painting: {columns} x {rows} places are too many") from error
    return Brought(made, summary(made))


_READERS = {"png": _picture, "wav": _recording, "paint": _painting}
