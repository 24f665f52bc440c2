"""Plain strokes of a whole population: each finger at the constant amplitude that gives a level on average.

An amplitude is commanded through the open loop, u = f_r = f0 e^(-tau a^2) of the controller's model. Forces fall nearly
as e^(-tau a^2) of the finger, so from the mean of one sweep the next amplitude follows; the third sweep is the result.
Its residual is f_a less its own mean: a constant disturbance, which an open loop does not see, takes the set-point's
place. A drift slower than a stroke is left in; the filter of the index passes little below 1 Hz
(`loop.reference_runs.relative_index` takes a line out of each stroke).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.operating import law_at
from frictionloop.parameters import Constant, FingerFriction, System
from frictionloop.physics.fingers import Fingers
from frictionloop.physics.friction import is_gaussian
from frictionloop.quantities import must_be

CORRECTIONS = 2
Sweep = Callable[[System, Fingers, Sequence[str]], xr.Dataset]
"""Runs a population on a system for some metrics, dim ``finger`` alone."""


def plain_strokes(system: System, people: Fingers, level_n: float, occluded: float, run: Sweep) -> xr.Dataset:
    """Return ``perceptual_index``, ``mean_force`` and ``scored_periods`` of plain strokes over ``finger``.

    A finger that no amplitude brings to the level slides at the nearest.

    Parameters
    ----------
    system
        The bench at one speed, with one contact.
    people
        Fingers as overrides.
    level_n
        Mean force wanted, N.
    occluded
        Occlusion in the middle of a run, 0 to 1, for the first guess.
    run
        What sweeps.
    """
    model = system.controller.model
    most = min(system.plate.max_amplitude_um, model.max_amplitude_um) ** 2
    bench = system.evolve({"controller.kind": "lookup", "setpoint": Constant(), "disturbance": Constant()})
    laws = [law_at(bench.evolve(each), occluded) for each in people]
    tau = np.array([law.susceptibility_per_um2 for law in laws if is_gaussian(law)])
    if tau.size < len(laws):
        raise must_be("friction.kind", system.friction.kind, '"finger", the law of equation (1)')
    square = np.clip(np.log([law.nominal_n / level_n for law in laws]) / tau, 0.0, most)
    mean = np.zeros(len(people))
    for _ in range(CORRECTIONS):
        mean = run(bench, _commanded(people, model, square, np.zeros(len(people))), ["mean_force"])["mean_force"].values
        # A finger that is never scored has no mean; it keeps its amplitude.
        better = np.clip(square + np.nan_to_num(np.log(mean / level_n)) / tau, 0.0, most)
        mean = mean * np.exp(tau * (square - better))
        square = better
    found = run(bench, _commanded(people, model, square, mean), ["perceptual_index", "mean_force", "scored_periods"])
    return found.assign(mean_force=found["mean_force"] - _offsets(model, square, mean))


def _commanded(people: Fingers, model: Any, square: np.ndarray, mean: np.ndarray) -> Fingers:
    """Return the fingers under amplitudes sqrt(square) in um, the residual counted from ``mean`` in N, 0 is off."""
    command = _command(model, square)
    offsets = np.nan_to_num(_offsets(model, square, mean))
    signals = zip(people, command.tolist(), offsets.tolist(), strict=True)
    return Fingers({**each, "setpoint.offset_n": u, "disturbance.offset_n": d} for each, u, d in signals)


def _command(model: Any, square: np.ndarray) -> np.ndarray:
    return np.asarray(model.nominal_n * np.exp(-model.susceptibility_per_um2 * square))


def _offsets(model: Any, square: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return d with f_a + d - f_r = f_a - mean; none where no mean is given."""
    return np.where(mean > 0.0, _command(model, square) - mean, 0.0)


def occluded_at(system: System, time_s: float) -> float:
    """Return w = 1 - e^(-t/T), how far occlusion has come so long after landing; 0 where nothing is occluded."""
    friction = system.friction
    return -math.expm1(-time_s / friction.occlusion_s) if isinstance(friction, FingerFriction) else 0.0
