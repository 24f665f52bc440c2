"""How a controller holds where the bench is not as it was modelled: stability and Ms over a grid of plants."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.design.noise_model import NoiseModel
from frictionloop.design.plant_grid import GAIN, RESONANCE, SPEED_MM_S, Controller, PlantGrid
from frictionloop.parameters import System


def robustness(
    system: System,
    controller: Controller,
    *,
    resonance: Sequence[float] = RESONANCE,
    gain: Sequence[float] = GAIN,
    contact: Sequence[str] = ("dahl", "slider"),
    speed_mm_s: Sequence[float] = SPEED_MM_S,
    force_n: float | None = None,
    noise: NoiseModel | None = None,
    integrators: int = 1,
) -> xr.Dataset:
    """Return Ms and stability of a controller over plants it may meet.

    Parameters
    ----------
    system
        The bench; its own controller gives rate and delay, not the law.
    controller
        C at frequencies in Hz, stable but for its integrators, e.g. ``design.Cascade.response`` or
        ``lambda f: kp + ki * ts / np.expm1(2j * np.pi * f * ts)``.
    resonance
        Shares by which the sensor's resonance is off; only 0 for a sensor without springs.
    gain
        Factors on the loop gain, above 0.
    contact
        Contact laws of the skin; those without a skin are all alike.
    speed_mm_s
        Speeds of the strokes in mm/s, which move the contact's pole s0 v/Fc.
    force_n
        Operating point as friction force in N; None as in `linearise`.
    noise
        Disturbance whose residual is wanted as well, as if it were the same everywhere.
    integrators
        Poles of C at z = 1.

    Returns
    -------
    xarray.Dataset
        ``sensitivity_peak`` (infinite where unstable; to 0.5 %, up to 10), ``stable``, and with
        ``noise`` also ``residual_rms_n`` from 1
        to 500 Hz, over resonance, gain, contact and speed_mm_s.

    Raises
    ------
    FrictionloopError
        A value out of range, or a point that cannot be reached.
    """
    grid = PlantGrid.of(system, resonance, gain, contact, speed_mm_s, force_n)
    return grid.judged(controller, noise, integrators)


def worst(table: xr.Dataset, **within: float) -> dict[str, Any]:
    """Return the largest Ms of a table and where it is; ``resonance=0.05`` looks no further off than 5 %."""
    peaks = table["sensitivity_peak"]
    if "resonance" in within:
        peaks = peaks.sel(resonance=np.abs(peaks["resonance"]) <= within["resonance"] + 1e-9)
    place = peaks.argmax(...)
    at = peaks.isel(place)
    return {"sensitivity_peak": float(at), **{str(name): at[name].item() for name in peaks.dims}}
