"""``frictionloop effect import``: a picture, a recording or a file of haptics as an effect of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.rendering.effect import Effect

ARGUMENTS = "FILE --out EFFECT.toml [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop effect import leaf.png --mm-per-pixel 0.1 --polarity dark --out leaf.toml
  frictionloop effect import cloth.csv --column 0 --rate-hz 10000 --scale 0.001 --speed-mm-s 40 --out cloth.toml
  frictionloop effect import cloth.csv --rate-hz 10000 --scale 0.001 --speed-mm-s 40 --order 16 --out model.toml
  frictionloop effect import click.ahap --full-n 0.2 --out click.toml
  frictionloop effect import pattern.hjif --out pattern.toml
"""
PICTURES, RECORDINGS = (".png", ".tif", ".tiff"), (".wav", ".csv", ".tsv", ".txt", ".h5", ".hdf5", ".nc", ".mat")
ENVELOPES, HAPTICS = (".haptic", ".ahap"), (".hjif",)
File = Annotated[Path, Parameter(name="FILE", help="Picture, recording, envelope or hjif.", group=flags.SYSTEM)]


def command(
    file: File,
    /,
    *,
    out: flags.Result[Path],
    mm_per_pixel: flags.Run[float | None] = None,
    polarity: flags.Run[Literal["bright", "dark"] | None] = None,
    low_n: flags.Run[float] = 0.3,
    high_n: flags.Run[float] = 0.6,
    column: flags.Run[str] = "0",
    rate_hz: flags.Run[float | None] = None,
    scale: flags.Run[float | None] = None,
    offset_n: flags.Run[float] = 0.0,
    speed_mm_s: flags.Run[float | None] = None,
    order: flags.Run[int | None] = None,
    full_n: flags.Run[float | None] = None,
    heights: flags.Run[flags.Flag] = False,
    json: flags.Json = False,
) -> None:
    """Make an effect of a picture (.png, .tiff), a recording, an envelope (.haptic, .ahap) or an .hjif file.

    Parameters
    ----------
    out
        The effect (.toml).
    mm_per_pixel
        Of a picture: size of a pixel in mm.
    polarity
        Of a picture: what is most friction, bright or dark pixels.
    low_n, high_n
        Of a picture: forces at both ends of grey in N.
    column
        Of a recording: name or number of the column.
    rate_hz
        Of a recording: its rate, if the file does not say it.
    scale
        Of a recording: newtons per unit.
    offset_n
        Of a recording: added after scaling, in N.
    speed_mm_s
        Of a recording: speed of the finger in mm/s; it is then played by place, else over time.
    order
        Of a recording played by place: fit a model with so many coefficients, and write that.
    full_n
        Of an envelope: force that the full amplitude stands for, in N.
    heights
        Of a picture: greys are heights, --low-n and --high-n in mm; their slope is added to 0.45 N.
    """
    checks.check_output("out", out, checks.SYSTEMS)
    checks.check_new("out", out)

    from frictionloop.cli.effect_text import described
    from frictionloop.rendering.files import write_effect

    ending = file.suffix.lower()
    given = {
        "mm_per_pixel": mm_per_pixel, "polarity": polarity, "heights": heights or None, "rate_hz": rate_hz,
        "scale": scale, "speed_mm_s": speed_mm_s, "order": order, "full_n": full_n,
    }  # fmt: skip
    _check_belongs(ending, [name for name, value in given.items() if value is not None])
    told = ""
    if ending in PICTURES:
        from frictionloop.rendering.images import read_image

        picture = read_image(file, mm_per_pixel=mm_per_pixel, polarity=polarity, low_n=low_n, high_n=high_n)
        effect: Effect = _raised(picture.map) if heights else picture.map
        told = picture.told
    elif ending in RECORDINGS:
        effect = _recorded(file, column, rate_hz, scale, offset_n, speed_mm_s)
        told = _recording_told(effect, scale, ending)
        if order is not None:
            effect = _fitted(effect, order)
    elif ending in (*ENVELOPES, *HAPTICS):
        effect, left = _haptics(file, ending, full_n)
        told = f"not carried over: {', '.join(left)}" if left else "all of it carried over"
    else:
        known = " ".join((*PICTURES, *RECORDINGS, *ENVELOPES, *HAPTICS))
        raise FrictionloopError(f"{file}: format {ending!r} is unknown; accepted: {known}")
    write_effect(effect, out)
    if json:
        screen.show_json({"effect": effect.model_dump(), "told": told, "saved": {"effect": out}})
        return
    screen.show(screen.columns([("effect", described(effect)), ("file", told or str(file))]), f"saved effect as {out}")


BELONG = {
    PICTURES: ("mm_per_pixel", "polarity", "heights"),
    RECORDINGS: ("rate_hz", "scale", "speed_mm_s", "order"),
    ENVELOPES: ("full_n",),
    HAPTICS: (),
}
"""What may be given with each kind of file, of what has no value by itself."""


def _check_belongs(ending: str, given: list[str]) -> None:
    for endings, names in BELONG.items():
        for name in given if ending in endings else ():
            if name not in names:
                owner = next(" ".join(each) for each, own in BELONG.items() if name in own)
                raise FrictionloopError(f"{name}: says nothing about a {ending} file; it goes with {owner}")


def _recording_told(effect: Effect, scale: float | None, ending: str) -> str:
    """Return how a recording was read, in words."""
    from frictionloop.rendering.tables import Map, Wave

    brought = "by the scale in the file" if ending == ".wav" else "taken for N, or by the unit in the file"
    words = brought if scale is None else f"{scale:g} N per unit"
    if isinstance(effect, Map):
        return f"{words}; {len(effect.values_n[0])} values {effect.pitch_mm:g} mm apart, over and over"
    assert isinstance(effect, Wave)
    return f"{words}; {effect.duration_s:.4g} s at {effect.rate_hz:g} values per second, once, then 0 N"


def _raised(height: Effect) -> Effect:
    from frictionloop.rendering.conditions import Relief
    from frictionloop.rendering.library import CARRIER_N

    return CARRIER_N + Relief(height=height)


def _fitted(effect: Effect, order: int) -> Effect:
    from frictionloop.rendering.resynthesis import fit_texture
    from frictionloop.rendering.tables import Map

    if not isinstance(effect, Map):
        raise FrictionloopError(f"order = {order}: goes with --speed-mm-s, a recording that is played by place")
    return fit_texture(effect.values_n[0], effect.pitch_mm, order)


def _recorded(
    file: Path, column: str, rate_hz: float | None, scale: float | None, offset_n: float, speed_mm_s: float | None
) -> Effect:
    from frictionloop.parameters import Recording
    from frictionloop.rendering.sounds import read_texture, read_wave

    recording = Recording(path=str(file), column=column, rate_hz=rate_hz, scale=scale, offset_n=offset_n)
    return read_wave(recording, rate_hz or 5000.0) if speed_mm_s is None else read_texture(recording, speed_mm_s)


def _haptics(file: Path, ending: str, full_n: float | None) -> tuple[Effect, tuple[str, ...]]:
    from frictionloop.rendering.envelopes import read_envelope
    from frictionloop.rendering.hjif import read_hjif

    if ending in HAPTICS:
        return read_hjif(file)
    if full_n is None:
        raise FrictionloopError(f"{file}: full_n is missing: must be the force in N that the full amplitude stands for")
    return read_envelope(file, full_n)
