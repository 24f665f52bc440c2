"""Values of set-points and disturbances over time: in closed form, or sampled once per control period."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from frictionloop.parameters import ColouredNoise, Constant, LogSweep, Recording, Signal, Sine, Steps
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.outside_errors import place, theirs

Sampler = Callable[[int, int], np.ndarray]
"""(start, stop) -> values at control periods start to stop, both included; called with rising, adjoining chunks."""


def sweep_turns(sweep: LogSweep) -> tuple[float, float]:
    """Return (turns, octaves_per_s) of phi(t) / 2 pi = turns (2^(octaves_per_s t) - 1)."""
    ratio = sweep.stop_hz / sweep.start_hz
    return sweep.start_hz * sweep.sweep_s / math.log(ratio), math.log2(ratio) / sweep.sweep_s


def evaluate(source: Constant | Sine | LogSweep | Steps, time_s: np.ndarray | float) -> np.ndarray:
    """Return the force in N of a source that has a formula, at times in s of any shape."""
    t = np.asarray(time_s, dtype=float)
    if isinstance(source, Constant):
        return np.full_like(t, source.offset_n)
    if isinstance(source, Sine):
        return source.offset_n + source.amplitude_n * np.sin(2 * np.pi * source.frequency_hz * t)
    if isinstance(source, LogSweep):
        turns, octaves_per_s = sweep_turns(source)
        return source.offset_n + source.amplitude_n * np.sin(2 * np.pi * turns * (np.exp2(octaves_per_s * t) - 1.0))
    index = np.searchsorted(source.times_s, t, side="right") - 1
    return np.asarray(source.levels_n)[index]


def highest_hz(source: Signal) -> float:
    """Return the highest frequency of a formula in Hz (0 for what is sampled: it is linear between samples)."""
    if isinstance(source, Sine):
        return source.frequency_hz
    return max(source.start_hz, source.stop_hz) if isinstance(source, LogSweep) else 0.0


def sampler(source: Signal, rate_hz: float, seed: int, stream: int) -> Sampler | None:
    """Return the sampler of a source that is defined at control periods only, None for one that has a formula.

    A recording is resampled to ``rate_hz``; coloured noise is drawn for (seed, stream); a step lands on the first
    control period at or after its time.
    """
    if isinstance(source, Steps):
        starts = np.ceil(np.asarray(source.times_s) * rate_hz - 1e-6)
        levels = np.asarray(source.levels_n)
        return lambda start, stop: levels[np.searchsorted(starts, np.arange(start, stop + 1), side="right") - 1]
    if isinstance(source, Recording):
        return _recorded(source, rate_hz)
    if isinstance(source, ColouredNoise):
        return _drawn(source, rate_hz, seed, stream)
    if isinstance(source, Constant | Sine | LogSweep):
        return None
    return _computed(source, rate_hz)


def _computed(source: Signal, rate_hz: float) -> Sampler:
    """Return the sampler of a signal that has a function of its own."""
    what = f'signal "{source.kind}"'
    where = place(type(source).force_n)

    def take(start: int, stop: int) -> np.ndarray:
        times = np.arange(start, stop + 1) / rate_hz
        try:
            forces = np.asarray(source.force_n(times), dtype=float)
        except Exception as error:
            raise theirs(what, type(source).force_n, error) from error
        if forces.shape != times.shape:
            raise FrictionloopError(f"{what}: {where}: force_n has shape {forces.shape}, times {times.shape}")
        if not np.all(np.isfinite(forces)):
            wrong = int(np.flatnonzero(~np.isfinite(forces))[0])
            raise FrictionloopError(
                f"{what}: {where}: force_n returned {forces[wrong]} at {times[wrong]:g} s; must be finite"
            )
        return forces

    return take


def _recorded(recording: Recording, rate_hz: float) -> Sampler:
    from frictionloop.recordings.force_channel import read_held

    samples = read_held(recording, rate_hz)

    def take(start: int, stop: int) -> np.ndarray:
        if stop >= samples.size:
            raise FrictionloopError(
                f"{recording.path}: duration_s must be at most {(samples.size - 1) / rate_hz:.9g} s"
            )
        return samples[start : stop + 1]

    return take


def _drawn(noise: ColouredNoise, rate_hz: float, seed: int, stream: int) -> Sampler:
    from frictionloop.physics.coloured_noise import colour, shaping_filter, stationary_state
    from frictionloop.quantities.counter_noise import normals

    sos = shaping_filter(noise, rate_hz)
    # The filter's start takes the first draws of the stream, the samples those after them.
    lead = 2 * len(sos)
    state = stationary_state(sos, normals(seed, stream, 0, lead))
    last = np.empty(0)
    drawn_to = 0

    def take(start: int, stop: int) -> np.ndarray:
        nonlocal state, last, drawn_to
        white = normals(seed, stream, lead + drawn_to, lead + stop + 1)
        samples, state = colour(sos, white, state)
        overlap = last[-1:] if drawn_to > start else last[:0]
        drawn_to, last = stop + 1, samples
        return noise.offset_n + noise.rms_n * np.concatenate([overlap, samples])

    return take
