"""One run of the loop, with traces: whether it can be run, how many control periods it has, and what it leaves."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.loop.input_findings import warn_of_signals
from frictionloop.loop.kernel.loop import Tile
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.record import to_dataset
from frictionloop.parameters import System, check_system
from frictionloop.physics.vibration import GAUSSIAN, vibration_of
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.counter_noise import BLOCK
from frictionloop.quantities.outside_errors import place
from frictionloop.quantities.value_checks import whole

if TYPE_CHECKING:
    import xarray as xr


def is_finite(value: Any) -> bool:
    """Return whether a value is one finite number (a bool is none)."""
    try:
        return not isinstance(value, (bool, np.bool_)) and math.isfinite(value)
    except (TypeError, OverflowError):
        return False


def periods_in(system: System, duration_s: float) -> int:
    """Return the number of control periods in ``duration_s``, a whole number of them.

    Raises ``FrictionloopError`` when the duration is not positive, not whole, or longer than a swept signal.
    """
    check_system(system)
    rate = system.controller.rate_hz
    if not (is_finite(duration_s) and duration_s > 0):
        raise must_be("duration_s", duration_s, "a positive number", "s")
    if duration_s * rate > 2**53:
        raise must_be("duration_s", duration_s, f"at most {2**53 / rate:g}", "s")
    periods = round(duration_s * rate)
    if periods < 1 or abs(periods - duration_s * rate) > 1e-6 * max(periods, 1):
        near = max(periods, 1) / rate
        raise must_be("duration_s", duration_s, f"whole periods of controller.rate_hz = {rate:g} Hz, as {near}", "s")
    for name in ("setpoint", "disturbance"):
        source = getattr(system, name)
        longest, field = source.longest_s, "sweep_s" if source.kind == "log_sweep" else "longest_s"
        if duration_s > longest * (1 + 1e-12):
            raise must_be("duration_s", duration_s, f"at most {name}.{field} = {longest:g}", "s")
    return periods


def check_seed(seed: Any) -> int:
    """Return a seed of the noise, refusing what is not a whole number of 64 bits."""
    return whole("seed", seed, 0, 2**64 - 1)


def check_memory(needed_bytes: int, what: str) -> None:
    """Refuse work that would not fit into this machine's free memory, saying how much it needs."""
    if sys.platform != "linux":  # no other system tells so
        return
    free = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    if needed_bytes > free:
        raise FrictionloopError(f"{what}: {needed_bytes / 1e9:.1f} GB needed, {free / 1e9:.1f} free")


CHUNK = 2048 * BLOCK
"""Control periods per call of the kernel: Ctrl-C is answered between chunks."""
PLACES = 101
"""Amplitudes at which a friction law is looked at, from 0 to the plate's largest."""


def run_tile(tile: Tile, periods: int) -> None:
    """Run a tile from t = 0 for some control periods; its slab then holds the sums."""
    for start in range(0, periods, CHUNK):
        stop = min(start + CHUNK, periods)
        tile.advance(start, stop, tile.setpoint(start, stop), tile.disturbance(start, stop), start)


def traced(
    systems: Sequence[System], seeds: Sequence[int], duration_s: float, command_um: float | None = None
) -> Iterator[xr.Dataset]:
    """Yield the runs of systems that can share a tile, each with its seed; under a constant command if one is given."""
    periods, seeds = periods_in(systems[0], duration_s), [check_seed(seed) for seed in seeds]
    names, width = traces_of(systems[0]), 1 if len(systems) == 1 else LANES
    check_memory((1 + width) * 8 * len(names) * periods, f"{len(systems)} runs of {duration_s:g} s")
    traces = np.empty((len(names), periods, width))
    tile = lower(systems, seeds, traces=traces.reshape(-1), external=command_um is not None)
    if command_um is not None:
        tile.slab.view("command")[:] = command_um
    run_tile(tile, periods)
    lost = set(lanes_without_number(tile).tolist())
    for lane, (system, seed) in enumerate(zip(systems, seeds, strict=True)):
        check_numbers(system, traces[names.index("u"), :, lane], lane in lost)
        yield to_dataset(traces[:, :, lane], system, seed)


def simulate(system: System, duration_s: float = 10.0, seed: int = 0) -> xr.Dataset:
    """Simulate the closed loop and return its traces.

    Parameters
    ----------
    system : System
        What to simulate, e.g. ``fl.paper()``.
    duration_s : float
        Duration in s, a whole number of control periods, not past the end of a swept or recorded signal.
    seed : int
        Seed of all noise, 0 to 2**64 - 1; the same seed gives the same bits.

    Returns
    -------
    xarray.Dataset
        Over ``time`` (s), one row per control period, row k before the update at t_k: ``f_r`` set-point, ``f_a``
        friction force, ``f_m`` measured force, ``u`` force command (all N), ``a`` amplitude (um), ``d`` disturbance
        (N), ``saturated``. Attributes carry the System, seed and version.

    Raises
    ------
    FrictionloopError
        For what is not a System, a bad seed, a duration that does not fit the control rate, the signals or the
        memory, and for a law or a friction law (``fl.register``) that gives no number, or less than no friction.

    Warns
    -----
    SignalWarning
        For a recorded signal or an array that is probably read wrongly, with what was probably meant.

    """
    (run,) = traced([system], [seed], duration_s)
    warn_of_signals(system)
    return run


def check_numbers(system: System, u: np.ndarray, lost: bool) -> None:
    """Refuse a run if its force command is no number somewhere, or a friction law (``fl.register``) gave none."""
    wrong = np.flatnonzero(np.isnan(u))
    if wrong.size or lost:
        period = wrong[0] if wrong.size else u.size
        raise no_number(system, f"at {period / system.controller.rate_hz:g} s")


def lanes_without_number(tile: Tile) -> np.ndarray:
    """Return which lanes of a tile that has run are left with a reading or a command that is no number.

    What gets into the sensor stays there: the last period tells of all.
    """
    rows = [tile.slab.view("u"), tile.slab.view("measurement")[:1], tile.slab.view("suspension")]
    return np.flatnonzero(np.isnan(np.concatenate(rows)).any(axis=0))


def no_number(system: System, where: str) -> FrictionloopError:
    """Return the error of a run whose force is no number; ``where`` is a time, or the point of a sweep."""
    friction, c = system.friction, system.controller
    law = vibration_of(friction)
    if law is not GAUSSIAN:
        given = law.coefficients_of(friction)
        for a in np.linspace(0.0, system.plate.max_amplitude_um, PLACES).tolist():
            for occluded in (0.0, 1.0):
                share = float(law.step(a, occluded, given))
                if math.isnan(share) or share < 0.0:
                    return FrictionloopError(
                        f'friction law "{friction.kind}": {place(law.step)}: {share:g} at {a:g} um {where}; not 0 to 1'
                    )
    return FrictionloopError(f'law "{c.kind}": command is no number {where}')
