"""An effect as a file of whatever kind its name says."""

from __future__ import annotations

from pathlib import Path

from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.files import write_effect
from frictionloop.rendering.hjif import write_hjif
from frictionloop.rendering.images import rasterise, write_image
from frictionloop.rendering.shapes import Constant, Grating
from frictionloop.rendering.sounds import write_wave
from frictionloop.rendering.tables import Map, Wave

WIDTH_MM, HEIGHT_MM, PITCH_MM = 60.0, 20.0, 0.25
"""Of a map that is made of an effect for a file (assumed: a stroke of the bench)."""
ENDINGS = (".toml", ".png", ".wav", ".hjif")


def write(effect: Effect, path: Path) -> None:
    """Write an effect: all of it as .toml, a map around the origin as .png or .hjif, a wave as .wav.

    Raises
    ------
    FrictionloopError
        For another ending, what a kind of file does not hold, or a file that cannot be written.
    """
    ending = path.suffix.lower()
    if ending == ".toml":
        write_effect(effect, path)
    elif ending == ".png":
        write_image(effect if isinstance(effect, Map) else rasterise(effect, WIDTH_MM, HEIGHT_MM, PITCH_MM), path)
    elif ending == ".hjif":
        whole = isinstance(effect, Constant | Grating) or (isinstance(effect, Map) and len(effect.values_n) == 1)
        write_hjif(effect if whole else rasterise(effect, WIDTH_MM, 0.0, 0.05), path)
    elif ending == ".wav":
        if not isinstance(effect, Wave):
            raise FrictionloopError(f"{path}: a WAV file holds a wave over time; effect.kind is {effect.kind!r}")
        write_wave(effect, path)
    else:
        raise FrictionloopError(f"{str(path)!r}: must end in {', '.join(ENDINGS)}")
