"""A texture fitted to a recording: an autoregressive model over place, driven by noise, for any speed and length."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from frictionloop.parameters.block import NotNegative, Number, Positive, Whole
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import numbers, whole
from frictionloop.quantities.normals import normals
from frictionloop.rendering.effect import Effect, Touch

RESYNTHESIS_STREAM = 31
"""Stream of the counter-based noise that drives it."""


class Resynthesis(Effect):
    """f = offset + n, n[k] = a1 n[k-1] + a2 n[k-2] + ... + noise: the spectrum of a recording, not its waveform.

    Culbertson and others fit such models to tapped and dragged tools (World Haptics 2013); here it runs over place.
    """

    kind: Literal["resynthesis"] = "resynthesis"
    offset_n: Number = 0.45
    """Mean force."""
    coefficients: Annotated[tuple[Number, ...], Field(min_length=1, max_length=64)] = (0.9,)
    """a1, a2, ...; the model must be stable."""
    noise_n: NotNegative = 0.02
    """Standard deviation of the noise."""
    pitch_mm: Positive = 0.1
    """Distance from value to value."""
    values: Annotated[Whole, Field(ge=64, le=32768)] = 2048
    """Values after which it repeats."""
    seed: Annotated[Whole, Field(ge=0, lt=2**31)] = 0
    """The same seed gives the same surface."""

    @model_validator(mode="after")
    def _is_stable(self) -> Self:
        largest = float(np.max(np.abs(np.roots([1.0, *(-each for each in self.coefficients)])), initial=0.0))
        if not largest < 1.0:
            raise ValueError(f"coefficients: grow by {largest:.4g} a value; must be below 1")
        return self

    @property
    def period_mm(self) -> float | None:
        """The way after which it repeats."""
        return self.values * self.pitch_mm

    def asked(self, touch: Touch) -> Any:
        """Return the force in N, linear between values."""
        table = _made(self.coefficients, self.noise_n, self.values, self.seed)
        u = np.asarray(touch.x_mm, float) / self.pitch_mm
        u = u - self.values * np.floor(u / self.values)
        return self.offset_n + np.interp(u, np.arange(self.values + 1), np.append(table, table[0]))


@lru_cache(maxsize=64)
def _made(coefficients: tuple[float, ...], noise_n: float, values: int, seed: int) -> np.ndarray:
    """Return a period of it, by its spectrum: what begins where it ends has no transient."""
    white = np.fft.rfft(normals(seed, RESYNTHESIS_STREAM, 0, values))
    shape = np.fft.rfft(np.concatenate([[1.0], -np.array(coefficients)]), values)
    white[0] = 0.0
    return np.asarray(noise_n * np.fft.irfft(white / shape, values))


def fit_texture(values_n: Any, pitch_mm: float, order: int = 12, seed: int = 0) -> Resynthesis:
    """Return the model of a recording over place: its mean, and the coefficients by the Yule-Walker equations.

    Parameters
    ----------
    values_n
        Forces in N, ``pitch_mm`` apart: of a map from `read_texture`, ``map.values_n[0]``.
    pitch_mm : float
        Distance from value to value, mm.
    order : int
        Number of coefficients, 1 to 64.
    seed : int
        Seed of the surface.

    Raises
    ------
    FrictionloopError
        For fewer values than four times the order, what is no number, or values that do not vary.
    """
    from scipy.linalg import solve_toeplitz

    force = numbers("values_n", values_n, "N").ravel()
    order = whole("order", order, 1, 64)
    if force.size < 4 * order:
        raise FrictionloopError(f"values_n: {force.size} values; must be at least {4 * order}")
    mean = float(force.mean())
    centred = force - mean
    products = np.array([centred[: force.size - lag] @ centred[lag:] for lag in range(order + 1)]) / force.size
    if not products[0] > 1e-18:
        raise FrictionloopError("values_n: must vary")
    coefficients = solve_toeplitz(products[:-1], products[1:])
    noise = float(np.sqrt(max(products[0] - coefficients @ products[1:], 0.0)))
    return Resynthesis(offset_n=mean, coefficients=coefficients.tolist(), noise_n=noise, pitch_mm=pitch_mm, seed=seed)
