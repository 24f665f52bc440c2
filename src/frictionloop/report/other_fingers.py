"""Beyond the chosen finger: other lookup tables, a population, what is felt, and what makes the force fluctuate."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.companion_runs import perceptual_index, relative_index
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import Constant, System
from frictionloop.physics.reach import capable
from frictionloop.report import paper_protocol
from frictionloop.report.paper_protocol import finger_system

LOOKUPS = ("lookup of the bench", "lookup of Sec. 2.1", "lookup fitted to the finger")
STILL_N = 0.6
"""Constant set-point on which fluctuations are compared: the middle of the levels."""
FLUCTUATING: dict[str, dict[str, float]] = {
    "all": {},
    "neither": {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "friction.roughness_rms": 0.0},
}
"""With tremor and roughness and without, as overrides."""


def lookup(name: str, finger: Mapping[str, float]) -> dict[str, float]:
    """Return the model that a lookup table is made of, as overrides."""
    friction: Any = finger_system(finger).friction
    load_n: float = finger_system(finger).motion.load_n  # type: ignore[union-attr]
    pressed = (load_n / friction.reference_load_n) ** friction.load_exponent
    fitted = {
        "controller.model.nominal_n": friction.nominal_n * pressed,
        "controller.model.susceptibility_per_um2": friction.susceptibility_per_um2,
    }
    return dict(zip(LOOKUPS, ({}, {"controller.model.nominal_n": 0.8}, fitted), strict=True))[name]


def population(controller: str) -> xr.Dataset:
    """Return the fit of each finger, levels pooled and one stroke each, and what it can reach, over ``finger``."""
    some, levels = paper_protocol.population()[: paper_protocol.POPULATION], len(paper_protocol.LEVELS_N)
    able = capable(some, paper_protocol.LOW_N, paper_protocol.HIGH_N, contact_s=paper_protocol.SCORED_S)
    systems = [finger_system(finger).evolve(paper_protocol.CONTROLLERS[controller]) for finger in some]
    runs = paper_protocol.run_all(
        (system.evolve({"setpoint": paper_protocol.sine(level_n)}), paper_protocol.seed_of(i, 0))
        for system in systems
        for i, level_n in enumerate(paper_protocol.LEVELS_N)
    )
    fits = np.array([paper_protocol.fit(xr.concat(runs[i : i + levels], "level")) for i in range(0, len(runs), levels)])
    variables = {name: ("finger", column) for name, column in zip(paper_protocol.Fit._fields, fits.T, strict=True)}
    found = xr.Dataset(variables, {"finger": np.arange(len(some))})
    return found.assign(capable=able["capable"])


def felt(finger: Mapping[str, float], overrides: Mapping[str, Any]) -> dict[str, float]:
    """Return D of the middle level, and D over that of the same stroke under a constant amplitude (``relative``)."""
    system = finger_system(finger).evolve({**overrides, "setpoint": paper_protocol.sine(paper_protocol.LEVELS_N[1])})
    run = simulate(system, paper_protocol.STROKE_S, paper_protocol.seed_of(1, 0))
    scored = run["time"].values >= paper_protocol.START_S
    return {"index": perceptual_index(run, scored), "relative": relative_index(run, scored)}


def fluctuations(finger: Mapping[str, float], controller: Mapping[str, Any]) -> dict[str, float]:
    """Return the rms of f_a - f_r at a constant set-point over five strokes, N, by the names of ``FLUCTUATING``."""
    system = finger_system(finger).evolve({**controller, "setpoint": Constant(offset_n=STILL_N)})
    strokes = {name: paper_protocol.strokes(system.evolve(changes)) for name, changes in FLUCTUATING.items()}
    # All at once, so that they share a tile.
    jobs = ((each, paper_protocol.seed_of(1, j)) for some in strokes.values() for j, each in enumerate(some))
    runs = iter(paper_protocol.run_all(jobs))
    return {name: _rms_n([next(runs) for _ in some]) for name, some in strokes.items()}


def _rms_n(runs: Sequence[xr.Dataset]) -> float:
    return float(np.sqrt(np.mean([np.mean((run["f_a"].values - run["f_r"].values) ** 2) for run in runs])))


def stronger(system_overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Return the same controller on a plate of twice the amplitude, known to it."""
    return {**system_overrides, "plate.max_amplitude_um": 5.0, "controller.model.max_amplitude_um": 5.0}


@cache
def the_finger() -> Mapping[str, float]:
    """Return the finger that the protocol's rule picks."""
    people = paper_protocol.population()
    return MappingProxyType(people[paper_protocol.chosen(people)])


def bench_systems() -> dict[str, System]:
    """Return the middle stroke of each controller, for the provenance of the page."""
    base = finger_system(the_finger())
    return {f"bench, {name}": base.evolve(overrides) for name, overrides in paper_protocol.CONTROLLERS.items()}
