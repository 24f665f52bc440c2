"""A population of fingers: who they are."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from scipy.special import ndtr

from frictionloop.parameters.population import Population, read_population
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import whole
from frictionloop.quantities.normals import normals

POPULATION_STREAM = 21
"""Stream of the counter-based noise that fingers are drawn from."""
SLOTS = 16
"""Numbers kept for each finger, used or not: finger i is the same whatever the size of the population."""
UNIFORM = {
    "friction.nominal_n": (0.5, 1.4),  # assumed: coefficients of 1 to 2.8, inside the 0.4 to 2.8 that are published
    "friction.load_exponent": (0.67, 1.0),  # Dzidek 2014, smooth glass
    "friction.speed_slope": (-0.15, 0.15),  # assumed; both signs are published
    "motion.load_drift": (0.1, 0.2),  # assumed
    "motion.tremor_hz": (8.0, 12.0),  # Sutton & Sykes 1967
    "friction.occlusion_s": (7.0, 20.0),  # the two published readings (FingerFriction.occlusion_s)
}
LOG_UNIFORM = {
    "friction.occlusion_ratio": (1.0, 5.0),  # assumed; up to 10 in Adams 2013
    "friction.roughness_rms": (0.02, 0.10),  # assumed; within 0.10 in Derler & Rotaru
    "finger.damping_n_s_m": (0.5, 2.0),  # assumed, after Wiertlewski & Hayward 2012
    "motion.tremor_um": (30.0, 120.0),  # Growdon 2000: 30, and 4 to 5 times that with the arm extended
    "motion.tremor_n": (0.015, 0.060),  # assumed: 30 um on 0.5 to 2 N/mm
}
LOG_NORMAL = {  # median and standard deviation of the logarithm
    "friction.susceptibility_per_um2": (0.38, 0.35),  # median: paper, Sec. 2.1; spread assumed
    "finger.stiffness_n_m": (1000.0, 0.35),  # median: robomechjournal 10.1186/s40648-017-0080-8; spread assumed
    "finger.slip_length_um": (11.5, math.log(1.5)),  # median: arXiv 2505.11162; a spread of a factor 1.5 is assumed
    "motion.load_n": (0.55, 0.25),  # assumed, around the 0.49 to 0.64 N of Smith 2002
}
LAST = ("moisture", "friction.occlusion_s", "finger.slip_length_um")
COLUMNS = (*(path for path in (*UNIFORM, *LOG_UNIFORM, *LOG_NORMAL) if path not in LAST), *LAST)
"""Which of a finger's numbers each value is drawn with."""
DRAWN_AT = {"friction.reference_load_n": 0.5, "friction.reference_speed_mm_s": 20.0}
"""Load and speed at which the drawn ``friction.nominal_n`` is that of the finger, whatever those of a system are."""
MOIST_LOSS = 0.3
"""Share of tau that a dry finger loses on its way to a wet one (direction: Gueorguiev 2017; assumed)."""


class Fingers(list[dict[str, float]]):
    """Overrides of a `System`, one finger each; a sweep over them has the dimension ``finger``."""

    dim = "finger"


def fingers(
    n: int,
    seed: int,
    population: Population | Mapping[str, Any] | str | None = None,
    loads_n: tuple[float, float] | None = None,
) -> Fingers:
    """Return a random population as overrides for `sweep`.

    Distributions are those of docs/finger.md, independent of each other but for moisture m, uniform from 0 to 1, which
    lowers ``friction.susceptibility_per_um2`` by 30 % m and leaves the rest of the 30 % to occlusion
    (``friction.moist_loss``). ``motion.person`` is i: at one seed of a run each has tremor and roughness of
    its own. Friction is drawn as that at 0.5 N and 20 mm/s, so each finger brings this reference load and speed, but
    not with a measured ``population``, whose friction is at those of the system. The system needs friction of kind
    "finger", a finger of kind "skin" and motion of kind "strokes".

    Parameters
    ----------
    n : int
        Number of fingers, at least 1.
    seed : int
        Seed, from 0 to 2^64 - 1. Finger i depends on the seed and i alone.
    population : Population, mapping or path, optional
        A population that was measured (``identify bench --population``): its values are drawn with their medians,
        spreads and correlations in place of the assumed ones. A tau that was measured has its moisture in it already.
    loads_n : (float, float), optional
        Least and largest mean load in N, between which ``motion.load_n`` is uniform: what participants are asked to
        press with. The rest of each finger stays as it is.

    Raises
    ------
    FrictionloopError
        For an n below 1 or a seed out of range, or what is not a whole number; for a population that cannot be read or
        has a value that fingers do not have; for loads that are not above 0 and rising.
    """
    whole("n", n, 1, 2**32)
    whole("seed", seed, 0, 2**64 - 1)
    z = normals(seed, POPULATION_STREAM, 0, n * SLOTS).reshape(n, SLOTS)
    found = Fingers(_finger(row) | DRAWN_AT | {"motion.person": i} for i, row in enumerate(z))
    if population is not None:
        measured = read_population(population)
        found = _as_measured(found, z, measured)
        if any(each.path == "friction.nominal_n" for each in measured.value):
            found = Fingers({path: value for path, value in each.items() if path not in DRAWN_AT} for each in found)
    return found if loads_n is None else _pressed(found, z, loads_n)


def _pressed(found: Fingers, z: np.ndarray, loads_n: tuple[float, float]) -> Fingers:
    """Return fingers whose mean loads are uniform between two, each by its own column of the noise."""
    low, high = loads_n
    if not 0 < low <= high < math.inf:
        raise FrictionloopError(f"loads_n = {tuple(loads_n)} N: must be above 0, the least before the largest")
    shares = ndtr(z[:, COLUMNS.index("motion.load_n")]).tolist()
    return Fingers(
        each | {"motion.load_n": low + (high - low) * share} for each, share in zip(found, shares, strict=True)
    )


def _as_measured(found: Fingers, z: np.ndarray, population: Population) -> Fingers:
    """Return fingers whose measured values are drawn from the population: median e^(spread R z)."""
    drawn = [*UNIFORM, *LOG_UNIFORM, *LOG_NORMAL]
    for each in population.value:
        if each.path not in drawn or UNIFORM.get(each.path, (0.0,))[0] < 0:
            known = ", ".join(path for path in drawn if UNIFORM.get(path, (0.0,))[0] >= 0)
            raise FrictionloopError(f"population: path = {each.path!r}: accepted: {known}")
    # Each value keeps its own column of the noise, so a finger changes in what was measured alone.
    own = z[:, [COLUMNS.index(each.path) for each in population.value]] @ population.root().T
    for finger, row in zip(found, own, strict=True):
        for each, normal in zip(population.value, row.tolist(), strict=True):
            finger[each.path] = each.median * math.exp(each.spread * normal)
    return found


def _finger(z: np.ndarray) -> dict[str, float]:
    drawn = dict(zip(COLUMNS, z.tolist(), strict=False))
    found = {path: low + (high - low) * float(ndtr(drawn[path])) for path, (low, high) in UNIFORM.items()}
    found |= {path: low * (high / low) ** float(ndtr(drawn[path])) for path, (low, high) in LOG_UNIFORM.items()}
    found |= {path: median * math.exp(spread * drawn[path]) for path, (median, spread) in LOG_NORMAL.items()}
    left = 1.0 - MOIST_LOSS * float(ndtr(drawn["moisture"]))
    found["friction.susceptibility_per_um2"] *= left
    found["friction.moist_loss"] = 1.0 - (1.0 - MOIST_LOSS) / left
    return found


def nearest_to_median(people: Fingers, some: np.ndarray) -> int:
    """Return the number of the finger of ``some`` whose f0 and tau are nearest to the medians of all, as logarithms."""
    points = np.log([[each["friction.nominal_n"], each["friction.susceptibility_per_um2"]] for each in people])
    spread = np.maximum(points.std(axis=0), 1e-12)
    apart = np.sum(((points - np.median(points, axis=0)) / spread) ** 2, axis=1)
    return int(np.argmin(np.where(some, apart, math.inf)))
