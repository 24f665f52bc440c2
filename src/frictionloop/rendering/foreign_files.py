"""An effect from a picture, a recording, an envelope or a file of haptics, and to a file of the kind its name says."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from frictionloop.findings import Finding, Result
from frictionloop.findings.shown import between
from frictionloop.parameters import Recording
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.recordings.file_opening import READERS
from frictionloop.recordings.force_channel import scaled
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_composition import Relief
from frictionloop.rendering.effect_toml import write_effect
from frictionloop.rendering.effects_from_recordings import (
    fit_texture,
    read_envelope,
    read_texture,
    read_wave,
    write_wave,
)
from frictionloop.rendering.force_tables import Map, Wave
from frictionloop.rendering.hjif import read_hjif, write_hjif
from frictionloop.rendering.images import Picture, Polarity, rasterise, read_image, write_image
from frictionloop.rendering.library import CARRIER_N, range_n, summary
from frictionloop.rendering.shapes import Constant, Grating

PICTURES, RECORDINGS = (".png", ".tif", ".tiff"), tuple(READERS)
ENVELOPES, HAPTICS = (".haptic", ".ahap"), (".hjif",)
BELONG: Mapping[tuple[str, ...], tuple[str, ...]] = {
    PICTURES: ("mm_per_pixel", "polarity", "heights"),
    RECORDINGS: ("rate_hz", "scale", "speed_mm_s", "order"),
    ENVELOPES: ("full_n",),
    HAPTICS: (),
}
"""What may be given with each kind of file, of what has no value by itself."""
RATE_HZ = 5000.0
"""Of a recording that is played over time and whose file says none: that of the bench's controller."""


class ImportedEffect(Result, schema="rendering.import_effect/1"):
    """An effect that was made of a file."""

    file: str
    effect: Effect
    least_n: float
    largest_n: float
    pixels: tuple[int, int] | None = None
    """Width and height of a picture."""
    not_carried: tuple[str, ...] = ()
    """What of the file no effect holds."""

    def rows(self) -> list[tuple[str, str]]:
        """Return the effect and its forces."""
        picture = [("picture", "{} x {} pixels".format(*self.pixels))] if self.pixels else []
        return [
            ("effect", summary(self.effect)),
            ("asks for", between(self.least_n, self.largest_n, "N")),
            *picture,
        ]


def import_effect(
    file: str | os.PathLike[str],
    *,
    mm_per_pixel: float | None = None,
    polarity: Polarity | None = None,
    low_n: float = 0.3,
    high_n: float = 0.6,
    heights: bool = False,
    column: str = "0",
    rate_hz: float | None = None,
    scale: float | None = None,
    offset_n: float | None = None,
    speed_mm_s: float | None = None,
    order: int | None = None,
    full_n: float | None = None,
) -> ImportedEffect:
    """Return an effect made of a picture, a recording, an envelope (.haptic, .ahap) or an .hjif file.

    Parameters
    ----------
    file
        The file.
    mm_per_pixel, polarity, low_n, high_n
        Of a picture, as of `read_image`.
    heights
        Of a picture: its greys are heights, both ends in mm; their slope is added to 0.45 N.
    column, rate_hz, scale, offset_n
        Of a recording: column, values per s, newtons per unit, and what is added to that in N: if not given 0, or what
        carries one that goes below 0, as no friction does.
    speed_mm_s
        Of a recording: speed of the finger in mm/s; it is then played by place, else over time.
    order
        Of a recording played by place: coefficients of a model that is fitted to it and takes its place.
    full_n
        Of an envelope: force of the full amplitude, N.

    Raises
    ------
    FrictionloopError
        For another ending, what says nothing of such a file, or a file that cannot be read.
    """
    path = Path(file)
    ending = path.suffix.lower()
    given = {
        "mm_per_pixel": mm_per_pixel, "polarity": polarity, "heights": heights or None, "rate_hz": rate_hz,
        "scale": scale, "speed_mm_s": speed_mm_s, "order": order, "full_n": full_n,
    }  # fmt: skip
    _check_belongs(path, ending, [name for name, value in given.items() if value is not None])
    left, findings = tuple[str, ...](), list[Finding]()
    pixels = None
    if ending in PICTURES:
        picture = read_image(path, mm_per_pixel=mm_per_pixel, polarity=polarity, low_n=low_n, high_n=high_n)
        effect: Effect = CARRIER_N + Relief(height=picture.map) if heights else picture.map
        pixels = picture.pixels
        findings += _reduced(picture)
        left = ("colours, in grey",) * picture.coloured
    elif ending in RECORDINGS:
        recording = Recording(path=str(path), column=column, rate_hz=rate_hz, scale=scale, offset_n=offset_n or 0.0)
        taken = scaled(recording)
        findings += taken.findings
        if offset_n is None and taken.force.min() < 0.0:
            recording = recording.model_copy(update={"offset_n": CARRIER_N})
            findings += [Finding("TAKEN-FOR", value=CARRIER_N, unit="N", more={"path": "offset_n"})]
        effect = read_wave(recording, rate_hz or RATE_HZ) if speed_mm_s is None else read_texture(recording, speed_mm_s)
        effect = effect if order is None else _fitted(effect, order)
        findings += [Finding("SCALE-TAKEN", value=path.name)] if scale is None and ending != ".wav" else []
    elif ending in HAPTICS:
        effect, left = read_hjif(path)
    else:
        if full_n is None:
            raise must_be(f"{file}: full_n", None, "a force", "N")
        effect, left = read_envelope(path, full_n)
    findings += [Finding("EFFECT-LEFT", value=", ".join(left))] if left else []
    low, high = range_n(effect)
    return ImportedEffect(
        file=str(file), effect=effect, least_n=low, largest_n=high, pixels=pixels, not_carried=left,
        findings=tuple(findings),
    )  # fmt: skip


def _check_belongs(path: Path, ending: str, given: list[str]) -> None:
    accepted = {each: names for endings, names in BELONG.items() for each in endings}
    if ending not in accepted:
        raise FrictionloopError(f"{path}: format {ending!r} is unknown; accepted: {' '.join(accepted)}", "UNKNOWN-NAME")
    for name in given:
        if name not in accepted[ending]:
            owner = next(" ".join(each) for each, own in BELONG.items() if name in own)
            raise FrictionloopError(f"{name}: goes with {owner}, not {ending}")


def _reduced(picture: Picture) -> Iterator[Finding]:
    if picture.reduced > 1:
        yield Finding("PICTURE-REDUCED", value=picture.reduced, unit="pixels", limit=picture.map.pitch_mm)


def _fitted(effect: Effect, order: Any) -> Effect:
    if not isinstance(effect, Map):
        raise FrictionloopError(f"order = {order}: goes with speed_mm_s")
    return fit_texture(effect.values_n[0], effect.pitch_mm, order)


WIDTH_MM, HEIGHT_MM, PITCH_MM = 60.0, 20.0, 0.25
"""Of a map that is made of an effect for a file (assumed: a stroke of the bench)."""
ENDINGS = (".toml", ".png", ".wav", ".hjif")


def write(effect: Effect, path: Path) -> tuple[str, ...]:
    """Write an effect: all of it as .toml, a map around the origin as .png or .hjif, a wave as .wav.

    Returns what the file does not carry, a line each.

    Raises
    ------
    FrictionloopError
        For another ending, what a kind of file does not hold, or a file that cannot be written.
    """
    ending = path.suffix.lower()
    if ending == ".toml":
        write_effect(effect, path)
        return ()
    if ending == ".png":
        write_image(effect if isinstance(effect, Map) else rasterise(effect, WIDTH_MM, HEIGHT_MM, PITCH_MM), path)
        return () if isinstance(effect, Map) else (f"{_what(effect)}; {WIDTH_MM:g} x {HEIGHT_MM:g} mm of it",)
    if ending == ".hjif":
        if isinstance(effect, Constant | Grating) or (isinstance(effect, Map) and len(effect.values_n) == 1):
            return write_hjif(effect, path)
        return (f"{_what(effect)}; {WIDTH_MM:g} mm of it", *write_hjif(rasterise(effect, WIDTH_MM, 0.0, 0.05), path))
    if ending == ".wav":
        if not isinstance(effect, Wave):
            raise must_be(f"{path}: effect.kind", effect.kind, "wave")
        write_wave(effect, path)
        return ("that it loops",) if effect.loops else ()
    raise FrictionloopError(f"{str(path)!r}: must end in {', '.join(ENDINGS)}")


def _what(effect: Effect) -> str:
    """Return what a map of an effect leaves out."""
    return "what is beyond the map" if effect.is_static else "other touches than forth at 20 mm/s"
