"""Effects by name, ready to be felt, listed and changed: each is plain data."""

from __future__ import annotations

from frictionloop.rendering.conditions import Directed, Trigger
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.shapes import (
    Chirp,
    Constant,
    Detents,
    Dots,
    Edge,
    Gradient,
    Grating,
    Ridge,
    Texture,
    Viscous,
)
from frictionloop.rendering.tables import Wave

CARRIER_N = 0.45
"""Force that bumps and notches are added to: in the middle of what most fingers reach (assumed)."""


def _click(force_n: float) -> Wave:
    """Return a pulse of force of 20 ms that fades out (a step of at most 5 ms is felt as a click)."""
    return Wave(values_n=(0.0, force_n, 0.6 * force_n, 0.2 * force_n, 0.0), rate_hz=200.0)


def _button() -> Effect:
    """Return a fall of friction while pressed, with a click at press and a weaker one at release."""
    return Trigger(
        on_load_n=0.8, off_load_n=0.5, then=Constant(level_n=0.3), otherwise=Constant(level_n=0.55),
        starts=_click(-0.15), ends=_click(0.08),
    )  # fmt: skip


def _switch() -> Effect:
    """Return two levels: pushed past 3 mm it clicks over to the lower, and stays until it is pushed back past -3 mm."""
    return Trigger(
        on_x_mm=3.0, off_x_mm=-3.0, then=Constant(level_n=0.35), otherwise=Constant(level_n=0.55),
        starts=_click(-0.15), ends=_click(0.15),
    )  # fmt: skip


def _slider() -> Effect:
    """Return a track of 60 mm with notches every 10 mm and walls at its ends."""
    rail = Constant(level_n=0.4) + Detents(amplitude_n=0.12, spacing_mm=10.0)
    return rail + _wall().at(30.0) + _wall().rotate(180.0).at(-30.0)


def _wall() -> Effect:
    """Return a rise of friction that a finger runs into."""
    return Edge(from_n=0.0, to_n=0.35, width_mm=2.0)


def _braille() -> Effect:
    """Return the cell of the letter r (dots 1, 2, 3, 5) again and again, read along its middle row."""
    cell = Dots(at_mm=((1.75, 2.5), (1.75, 0.0), (1.75, -2.5), (4.25, 0.0)))
    return cell.repeat(6.0)


LIBRARY: dict[str, Effect] = {
    "constant": Constant(level_n=CARRIER_N),
    "gradient": Gradient(),
    "grating": Grating(),
    "square": Grating(shape="square", spacing_mm=4.0),
    "triangle": Grating(shape="triangle", spacing_mm=4.0),
    "chirp": Chirp().at(-30.0),
    "edge": Edge(),
    "bump": Constant(level_n=CARRIER_N) + Ridge(),
    "hole": Constant(level_n=CARRIER_N) + Ridge(height_mm=-0.5),
    "detents": Constant(level_n=CARRIER_N) + Detents(),
    "button": _button(),
    "switch": _switch(),
    "slider": _slider(),
    "wall": Constant(level_n=0.3) + _wall().at(10.0),
    "rough": Texture(),
    "velvet": Directed(forth=Constant(level_n=0.35), back=Constant(level_n=0.5))
    + Grating(offset_n=0.0, amplitude_n=0.02, spacing_mm=1.0),
    "liquid": Constant(level_n=0.25) + Viscous(per_speed_n_s_m=2.0),
    "rubber": Constant(level_n=0.6) + Texture(offset_n=0.0, rms_n=0.03, exponent=2.0, longest_mm=8.0),
    "braille": _braille(),
}
"""Ready-made effects; velvet has a mean by direction and a ripple of 1 mm (Bueno 2014); other numbers are assumed."""
