"""Effects with a formula: what most patterns are made of."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from frictionloop.parameters.block import NotNegative, Number, Positive, Whole
from frictionloop.quantities import must_be
from frictionloop.quantities.counter_noise import normals
from frictionloop.rendering.effect import Effect, Touch

TEXTURE_STREAM = 30
"""Stream of the counter-based noise that rough textures are drawn from."""
WAVES = 512
"""Waves of a rough texture at most."""


class Constant(Effect):
    """f = level."""

    kind: Literal["constant"] = "constant"
    level_n: Number = 0.45
    """Force."""

    @property
    def period_mm(self) -> float | None:
        """The same everywhere."""
        return 0.0

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return self.level_n + 0.0 * np.asarray(touch.x_mm)


class Gradient(Effect):
    """A force that goes from one level to another on a line, and stays there."""

    kind: Literal["gradient"] = "gradient"
    from_n: Number = 0.3
    """Force up to x = -length/2."""
    to_n: Number = 0.6
    """Force from x = length/2 on."""
    length_mm: Positive = 40.0
    """Way in which it changes."""

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        share = np.clip(np.asarray(touch.x_mm) / self.length_mm + 0.5, 0.0, 1.0)
        return self.from_n + share * (self.to_n - self.from_n)


class Edge(Effect):
    """A gradient with a smooth start and end: (1 + sin(pi x / width)) / 2 of the step."""

    kind: Literal["edge"] = "edge"
    from_n: Number = 0.3
    """Force before x = -width/2."""
    to_n: Number = 0.6
    """Force after x = width/2."""
    width_mm: Positive = 1.0
    """Way in which it changes."""

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        x = np.clip(np.asarray(touch.x_mm) / self.width_mm, -0.5, 0.5)
        return self.from_n + 0.5 * (1.0 + np.sin(np.pi * x)) * (self.to_n - self.from_n)


class Grating(Effect):
    """f = offset + amplitude w(x / period), w a wave from -1 to 1 that starts upwards at x = 0."""

    kind: Literal["grating"] = "grating"
    shape: Literal["sine", "square", "triangle"] = "sine"
    """Shape of w."""
    offset_n: Number = 0.45
    """Mean force."""
    amplitude_n: NotNegative = 0.15
    """Zero-to-peak amplitude."""
    spacing_mm: Positive = 2.0
    """Period in space."""

    @property
    def period_mm(self) -> float | None:
        """The spacing."""
        return self.spacing_mm

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        turns = np.asarray(touch.x_mm) / self.spacing_mm
        return self.offset_n + self.amplitude_n * _wave(turns - np.floor(turns), self.shape)


def _wave(turns: Any, shape: str) -> Any:
    if shape == "sine":
        return np.sin(2.0 * np.pi * turns)
    if shape == "square":
        return np.where(turns < 0.5, 1.0, -1.0)
    return 1.0 - 4.0 * np.abs(np.mod(turns + 0.25, 1.0) - 0.5)


class Chirp(Effect):
    """f = offset + amplitude sin(phase), a sine whose spacing goes from one value to another at equal way per octave.

    The phase is 2 pi L/(a ln(a/b)) ((a/b)^(x/L) - 1) from x = 0 to L, with spacings a and b; beyond, the force is held.
    """

    kind: Literal["chirp"] = "chirp"
    offset_n: Number = 0.45
    """Mean force."""
    amplitude_n: NotNegative = 0.15
    """Zero-to-peak amplitude."""
    from_mm: Positive = 8.0
    """Spacing at x = 0."""
    to_mm: Positive = 1.0
    """Spacing at the end."""
    length_mm: Positive = 60.0
    """Way in which the spacing changes."""

    def _check(self) -> None:
        if self.from_mm == self.to_mm:
            raise ValueError("from_mm and to_mm must differ")

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        x, ratio = np.clip(np.asarray(touch.x_mm), 0.0, self.length_mm), math.log(self.from_mm / self.to_mm)
        turns = self.length_mm / (self.from_mm * ratio) * np.expm1(ratio * x / self.length_mm)
        return self.offset_n + self.amplitude_n * np.sin(2.0 * np.pi * turns)


class Ridge(Effect):
    """The lateral force of a bump or a hole, to be added to a carrier: f = load (dh/dx) in the direction of motion.

    h = height (1 + cos(2 pi x / width)) / 2 from x = -width/2 to width/2; uphill resists, downhill eases. A force alone
    is felt as a shape: Robles-De-La-Torre and Hayward, "Force can overcome object geometry in the perception of shape
    through active touch", Nature 412, 2001. From foot to top the force integrates to load times height.
    """

    kind: Literal["ridge"] = "ridge"
    height_mm: Number = 0.5
    """Height of a bump, negative for a hole."""
    width_mm: Positive = 6.0
    """From foot to foot."""
    load_n: Positive = 0.5
    """Load that the slope is counted with: the force does not follow the finger's own."""

    @property
    def is_static(self) -> bool:
        """Its sign is that of the motion."""
        return False

    def slope_n(self, x_mm: Any) -> Any:
        """Return load times slope on the way forth along x, N."""
        x = np.clip(np.asarray(x_mm) / self.width_mm, -0.5, 0.5)
        return -self.load_n * self.height_mm * np.pi / self.width_mm * np.sin(2.0 * np.pi * x)

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        along = np.cos(np.radians(touch.heading_deg))
        return along * self.slope_n(touch.x_mm) * touch.direction


class Detents(Effect):
    """Notches that hold a finger, to be added to a carrier: the ridges between them, one every spacing, as `Ridge`.

    The notches are at x = 0, spacing, 2 spacing, ...: the force rises on the way out of one and eases into the next.
    """

    kind: Literal["detents"] = "detents"
    amplitude_n: NotNegative = 0.15
    """Largest force."""
    spacing_mm: Positive = 8.0
    """From notch to notch."""

    @property
    def is_static(self) -> bool:
        """Its sign is that of the motion."""
        return False

    def slope_n(self, x_mm: Any) -> Any:
        """Return the force on the way forth along x, N."""
        return self.amplitude_n * np.sin(2.0 * np.pi * np.asarray(x_mm) / self.spacing_mm)

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        along = np.cos(np.radians(touch.heading_deg))
        return along * self.slope_n(touch.x_mm) * touch.direction


class Texture(Effect):
    """A rough surface: f = offset + rms n(x), n Gaussian with a spectrum 1/wavenumber^exponent, fixed in space.

    n is a sum of sines with wavelengths length/k, from ``longest_mm`` to ``shortest_mm``; it repeats after the length.
    """

    kind: Literal["texture"] = "texture"
    offset_n: Number = 0.45
    """Mean force."""
    rms_n: NotNegative = 0.05
    """Standard deviation."""
    exponent: Annotated[Number, Field(ge=0, le=4)] = 1.0
    """Of the power spectrum over wavenumber: 0 white, 1 pink."""
    longest_mm: Positive = 10.0
    """Longest wavelength."""
    shortest_mm: Positive = 0.5
    """Shortest wavelength."""
    length_mm: Positive = 64.0
    """Way after which it repeats."""
    seed: Annotated[Whole, Field(ge=0, lt=2**31)] = 0
    """The same seed gives the same surface."""

    def _check(self) -> None:
        first, last = _orders(self)
        if not (self.shortest_mm <= self.longest_mm <= self.length_mm and first <= last):
            raise ValueError("must have shortest_mm <= length_mm/k <= longest_mm")
        if last - first >= WAVES:
            raise must_be("waves", last - first + 1, f"at most {WAVES}")

    @property
    def period_mm(self) -> float | None:
        """The length."""
        return self.length_mm

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        first, last = _orders(self)
        in_phase, quarter = _drawn(self.seed, first, last, self.exponent)
        turns = np.multiply.outer(np.arange(first, last + 1), np.asarray(touch.x_mm, float) / self.length_mm)
        waves = np.tensordot(in_phase, np.cos(2 * np.pi * turns), 1) + np.tensordot(
            quarter, np.sin(2 * np.pi * turns), 1
        )
        return self.offset_n + self.rms_n * waves


def _orders(texture: Texture) -> tuple[int, int]:
    """Return the smallest and the largest k of its waves."""
    ratio = texture.length_mm / texture.longest_mm, texture.length_mm / texture.shortest_mm
    return math.ceil(ratio[0] - 1e-9), math.floor(ratio[1] + 1e-9)


@lru_cache(maxsize=64)
def _drawn(seed: int, first: int, last: int, exponent: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes of cosines and sines, so that their sum has a standard deviation of 1 over the length."""
    orders = np.arange(first, last + 1, dtype=float)
    drawn = normals(seed, TEXTURE_STREAM, 0, 2 * orders.size).reshape(2, -1) * orders ** (-0.5 * exponent)
    drawn /= math.sqrt(0.5 * np.sum(drawn**2))
    return drawn[0], drawn[1]


class Dots(Effect):
    """Raised dots as in braille: round spots of another friction on a plain surface."""

    kind: Literal["dots"] = "dots"
    offset_n: Number = 0.3
    """Force between the dots."""
    height_n: Number = 0.3
    """Force added at the middle of a dot."""
    diameter_mm: Positive = 1.6
    """Diameter, its rim half the height (braille: 1.5 to 1.6 mm)."""
    at_mm: tuple[tuple[Number, Number], ...] = ((0.0, 0.0), (2.5, 0.0))
    """Middle of each dot, x and y (braille: 2.5 mm apart, 6 mm from cell to cell)."""

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N: (1 + cos) / 2 of the distance, 0 from a diameter on."""
        x, y = np.asarray(touch.x_mm, float), np.asarray(touch.y_mm, float)
        raised = 0.0 * (x + y)
        for dot_x, dot_y in self.at_mm:
            away = np.minimum(np.hypot(x - dot_x, y - dot_y) / self.diameter_mm, 1.0)
            raised = np.maximum(raised, 0.5 * (1.0 + np.cos(np.pi * away)))
        return self.offset_n + self.height_n * raised


class Viscous(Effect):
    """A force that grows with the speed, f = per_speed times its magnitude, to be added to a carrier."""

    kind: Literal["viscous"] = "viscous"
    per_speed_n_s_m: NotNegative = 2.0
    """Force per speed: 2 N s/m is 0.2 N at 100 mm/s."""

    @property
    def is_static(self) -> bool:
        """It depends on the speed."""
        return False

    def force_of(self, touch: Touch) -> Any:
        """Return the force in N."""
        return 1e-3 * self.per_speed_n_s_m * np.abs(np.asarray(touch.speed_mm_s))
