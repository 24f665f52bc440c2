"""``frictionloop effect import``: a picture, a recording or a file of haptics as an effect of one's own."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen

ARGUMENTS = "FILE --out EFFECT.toml [OPTIONS]"
EXAMPLES = (
    "leaf.png --mm-per-pixel 0.1 --polarity dark --out leaf.toml",
    "cloth.csv --column 0 --rate-hz 10000 --scale 0.001 --speed-mm-s 40 --out cloth.toml",
    "click.ahap --full-n 0.2 --out click.toml",
    "pattern.hjif --out pattern.toml",
)
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
    offset_n: flags.Run[float | None] = None,
    speed_mm_s: flags.Run[float | None] = None,
    order: flags.Run[int | None] = None,
    full_n: flags.Run[float | None] = None,
    heights: flags.Run[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
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
        Of a recording: added after scaling, in N; if not given 0.45 where the recording goes below 0.
    speed_mm_s
        Of a recording: speed of the finger in mm/s; it is then played by place, else over time.
    order
        Of a recording played by place: fit a model with so many coefficients, and write that.
    full_n
        Of an envelope: force that the full amplitude stands for, in N.
    heights
        Of a picture: greys are heights, --low-n and --high-n in mm; their slope is added to 0.45 N.
    """
    file_arguments.check_output("out", out, file_arguments.SYSTEMS)
    file_arguments.check_new("out", out)
    found = fl.rendering.import_effect(
        file, mm_per_pixel=mm_per_pixel, polarity=polarity, low_n=low_n, high_n=high_n, heights=heights, column=column,
        rate_hz=rate_hz, scale=scale, offset_n=offset_n, speed_mm_s=speed_mm_s, order=order, full_n=full_n,
    )  # fmt: skip
    fl.rendering.write_effect(found.effect, out)
    shown.show(found, saved={"effect": out})
