"""Who takes part in which comparison, and whether they compute the same thing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from importlib.util import find_spec
from typing import Any

import numpy as np

import diagrams
import ours
import peers
import peers_jax
import solvers
from build import Reference
from paper import Array, Paper, gain_grid, ramps
from timing import Contender

PERIODS = 50_000  # 10 s at 5 kHz
KP, KI = 10.0, 2.0
NOISY = Paper()
QUIET = replace(NOISY, noise_rms=0.0)
OURS, C, C_JUMP, C_LANES = "frictionloop", "C", "C, clamp branch", "C, a System per lane"
C_ENDS = "C, rule of the two ends"
GRID_ROUNDS = 25  # two threads are slowed by any third: the shortest of few is seldom undisturbed
CHAOS_KP = 15.0  # above, rounding alone changes traces; R2 is compared below

Trace = Callable[[Paper, float, float, int], Array]
"""(paper, kp, ki, periods) -> f_a"""


def present(module: str) -> bool:
    return find_spec(module) is not None


def one_run(c: Reference, quick: bool) -> tuple[list[Contender], dict[str, float]]:
    """One run of 10 s with traces; and each contender's largest difference from the tight solver's or C's f_a in N."""
    full, some, few = (1.0, 0.2, 0.04) if quick else (1.0, 1.0, 0.2)
    entries: list[tuple[str, Trace, int, float]] = [
        (C, lambda p, kp, ki, n: c.one(p, kp, ki, n)[1], 15, full),
        (C_JUMP, lambda p, kp, ki, n: c.one(p, kp, ki, n, jump=True)[1], 15, full),
        ("Numba, scalar loop", peers.NumbaScalar().one, 7, full),
        ("pure Python", peers.python_loop, 3, full),
        ("SciPy odeint per period", solvers.scipy_odeint, 2, some),
        ("SciPy solve_ivp per period", solvers.scipy_solve_ivp, 2, few),
    ]
    if ours.version():
        entries.insert(0, (OURS, _ours, 15, full))
    if present("jax"):
        entries.insert(3, ("JAX scan", peers_jax.Jax().one, 7, full))
    if present("diffrax"):
        entries.insert(4, ("diffrax Tsit5", peers_jax.Diffrax(), 3, full))
    if present("control"):
        entries.append(("python-control, discrete update", solvers.control_discrete, 2, some))
        entries.append(("python-control, continuous plant", solvers.control_continuous, 2, few / 2))
    if present("pydrake"):
        entries.append(("Drake", diagrams.drake, 2, some))
    if present("pathsim"):
        entries.append(("PathSim", diagrams.pathsim, 2, few / 4))
    timed = [
        Contender(name, partial(run, NOISY, KP, KI, round(PERIODS * part)), min(rounds, 5 if quick else rounds), part)
        for name, run, rounds, part in entries
    ]
    return timed, _trace_differences(c, entries, 300 if quick else 1000)


def _ours(p: Paper, kp: float, ki: float, periods: int) -> Array:
    return ours.one(kp, ki, periods / p.rate_hz, noise=p.noise_rms > 0)


def _trace_differences(c: Reference, entries: list[tuple[str, Trace, int, float]], periods: int) -> dict[str, float]:
    """Without noise: C against the tight solver over the first periods, the others against C."""
    exact = c.one(QUIET, KP, KI, PERIODS)[1]
    differences = {C: float(np.max(np.abs(exact[:periods] - solvers.tight(QUIET, KP, KI, periods))))}
    for name, run, _, part in entries:
        if name != C:
            over = round(PERIODS * min(part, 1.0)) if part == 1.0 else periods
            differences[name] = float(np.max(np.abs(run(QUIET, KP, KI, over) - exact[:over])))
    return differences


def grid(c: Reference, threads: int, quick: bool) -> tuple[list[Contender], dict[str, float]]:
    """32 x 32 gains, metrics only, without and with noise; and the largest difference in R2 below the chaotic gains."""
    kp_axis, ki_axis = gain_grid()
    kp, ki = (axis.ravel() for axis in np.meshgrid(kp_axis, ki_axis, indexing="ij"))
    own = {"kp": kp, "ki": ki}
    entries: list[tuple[str, Callable[[], Any], int, int]] = []

    def add(name: str, call: Callable[[], Any], rounds: int, on: int) -> None:
        entries.append((f"{name}, {on} thread{'s' * (on > 1)}", call, rounds, on))

    for on in sorted({1, threads}):
        if ours.version():
            add(OURS, partial(ours.grid, kp_axis, ki_axis, on), GRID_ROUNDS, on)
            add(f"{OURS}, noise, common", partial(ours.grid, kp_axis, ki_axis, on, noise=True), GRID_ROUNDS, on)
            add(f"{OURS}, noise, 1024 seeds", partial(ours.seeds, kp.size, on), GRID_ROUNDS, on)
        add(C, lambda on=on: c.grid(QUIET, kp, ki, PERIODS, on)[:, 0], GRID_ROUNDS, on)
        add(C_ENDS, lambda on=on: c.grid(QUIET, kp, ki, PERIODS, on, ends=True)[:, 0], GRID_ROUNDS, on)
        add(
            f"{C_ENDS}, noise, 1024 seeds",
            lambda on=on: c.grid(NOISY, kp, ki, PERIODS, on, np.arange(kp.size), ends=True)[:, 0],
            GRID_ROUNDS,
            on,
        )
        add(f"{C}, noise, common", lambda on=on: c.grid(NOISY, kp, ki, PERIODS, on)[:, 0], GRID_ROUNDS, on)
        add(
            f"{C}, noise, 1024 seeds",
            lambda on=on: c.grid(NOISY, kp, ki, PERIODS, on, np.arange(kp.size))[:, 0],
            GRID_ROUNDS,
            on,
        )
        add(C_LANES, lambda on=on: c.lanes(QUIET, own, PERIODS, on)[:, 0], GRID_ROUNDS, on)
        add(
            f"{C_LANES}, noise, 1024 seeds",
            lambda on=on: c.lanes(NOISY, own, PERIODS, on, np.arange(kp.size))[:, 0],
            GRID_ROUNDS,
            on,
        )
        if present("jax"):
            jax = peers_jax.Jax(on)
            add("JAX vmap", partial(jax.grid, QUIET, kp, ki, PERIODS), 4, on)
            jax = peers_jax.Jax(on, ramps)
            add("JAX vmap, 10 substeps", partial(jax.grid, QUIET, kp, ki, PERIODS), 4, on)
    add("Numba, scalar loop, prange", partial(peers.NumbaScalar().grid, QUIET, kp, ki, PERIODS), 3, threads)
    add("NumPy batch", partial(peers.numpy_batch, QUIET, kp, ki, PERIODS), 3, 1)
    add("NumPy batch, 10 substeps", partial(peers.numpy_batch, QUIET, kp, ki, PERIODS, ramps), 3, 1)
    timed = [
        Contender(name, call, min(rounds, 3 if quick else rounds), threads=on) for name, call, rounds, on in entries
    ]
    exact, calm = c.grid(QUIET, kp, ki, PERIODS, threads)[:, 0], kp < CHAOS_KP
    differences = {
        name: float(np.max(np.abs(np.asarray(call()) - exact)[calm]))
        for name, call, *_ in entries
        if "noise" not in name
    }
    return timed, differences
