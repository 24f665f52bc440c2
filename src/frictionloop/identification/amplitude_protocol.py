"""What to play while a finger strokes the plate in open loop, so that tau and f0 can be told from the recording."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from frictionloop.parameters import System, check_system
from frictionloop.parameters.plant import Friction
from frictionloop.parameters.sources import ColouredNoise, Signal, Sine, Steps
from frictionloop.physics.friction import friction_force
from frictionloop.quantities import must_be
from frictionloop.quantities.checks import number

LEVELS = 7
DWELL_S = 0.7
"""Time at each level: longer than a turn of the finger, and no part of a stroke of 3 s (assumed)."""
SWEEP_HZ, NOISE_HZ = 0.31, 2.0
"""Slow for the skin, and not in step with strokes; noise ends where the skin no longer follows (assumed)."""


def amplitude_protocol(
    system: System, form: Literal["steps", "sweep", "noise"] = "steps", duration_s: float = 60.0, seed: int = 0
) -> Signal:
    """Return a set-point that, in open loop, drives the plate through all its amplitudes.

    In open loop the lookup table turns the set-point u into the amplitude a = sqrt(ln(f0/u)/tau) by
    ``controller.model``, so u = f0 exp(-tau a^2) commands any a, whatever the finger's own f0 and tau are. Steps take
    seven levels, even in a^2 from 0 to the largest, in random order; sweep is a slow sine of the force; noise is that
    of the force, mostly below 2 Hz.

    Parameters
    ----------
    system : System
        Its ``controller.model`` and the plate's largest amplitude.
    form : str
        "steps", "sweep" (the one that a device plays exactly, with its table of 1024 points) or "noise".
    duration_s : float
        Time in s, at least 5.
    seed : int
        Seed of the order of the steps.

    Raises
    ------
    FrictionloopError
        For another form or a time too short.
    """
    check_system(system)
    number("duration_s", duration_s, "s", 5.0)
    model = system.controller.model
    law = Friction(nominal_n=model.nominal_n, susceptibility_per_um2=model.susceptibility_per_um2)
    largest = min(model.max_amplitude_um, system.plate.max_amplitude_um)
    low = float(friction_force(largest, law))
    middle, half = (law.nominal_n + low) / 2, (law.nominal_n - low) / 2
    if form == "steps":
        count = math.ceil(duration_s / DWELL_S)
        rng = np.random.default_rng(seed)
        order = np.concatenate([rng.permutation(LEVELS) for _ in range(math.ceil(count / LEVELS))])[:count]
        forces = friction_force(largest * np.sqrt(order / (LEVELS - 1)), law)
        return Steps(times_s=tuple((DWELL_S * np.arange(count)).tolist()), levels_n=tuple(forces.tolist()))
    if form == "sweep":
        return Sine(offset_n=middle, amplitude_n=half, frequency_hz=SWEEP_HZ)
    if form == "noise":
        return ColouredNoise(offset_n=middle, rms_n=half / 2, exponent=2.0, low_hz=0.2, high_hz=NOISE_HZ)
    raise must_be("form", form, "'steps', 'sweep' or 'noise'")
