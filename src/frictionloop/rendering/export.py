"""An effect as a file of whatever kind its name says."""

from __future__ import annotations

from pathlib import Path

from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.files import write_effect
from frictionloop.rendering.hjif_out import write_hjif
from frictionloop.rendering.images import rasterise, write_image
from frictionloop.rendering.shapes import Constant, Grating
from frictionloop.rendering.sounds import write_wave
from frictionloop.rendering.tables import Map, Wave

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
            raise FrictionloopError(f"{path}: effect.kind = {effect.kind!r}: must be wave")
        write_wave(effect, path)
        return ("that it loops",) if effect.loops else ()
    raise FrictionloopError(f"{str(path)!r}: must end in {', '.join(ENDINGS)}")


def _what(effect: Effect) -> str:
    """Return what a map of an effect leaves out."""
    return "what is beyond the map" if effect.is_static else "other touches than forth at 20 mm/s"
