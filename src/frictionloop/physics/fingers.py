"""A population of fingers: who they are."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from operator import eq
from types import MappingProxyType
from typing import Any

import numpy as np
from pydantic import BaseModel
from scipy.special import ndtr

from frictionloop.parameters import FingerFriction, Skin, Strokes, System
from frictionloop.parameters.population import Population, read_population
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.counter_noise import normals
from frictionloop.quantities.value_checks import whole

POPULATION_STREAM = 21
"""Stream of the counter-based noise that fingers are drawn from."""
BLOCK = 1024
"""Fingers that are drawn at a time."""
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


class Fingers(Sequence[dict[str, float]]):
    """Overrides of a `System`, one finger each; a sweep over them has the dimension ``finger``."""

    dim = "finger"
    drawn: Mapping[str, Any] = MappingProxyType({})
    """What `fingers` was given for them."""

    def __init__(self, people: Iterable[Mapping[str, float]] = ()) -> None:
        self._people = [dict(each) for each in people]

    def __len__(self) -> int:
        return len(self._people)

    def __getitem__(self, place: Any) -> Any:
        return self._people[place]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Sequence) and len(self) == len(other) and all(map(eq, self, other))

    __hash__ = None  # type: ignore[assignment]


class DrawnFingers(Fingers):
    """Fingers that are drawn where they are asked for, so that a million of them take no memory."""

    def __init__(
        self, count: int, drawn: Mapping[str, Any], block: Callable[[int, int], list[dict[str, float]]]
    ) -> None:
        self._count, self.drawn, self._draw = count, drawn, block
        self._first, self._block = 0, list[dict[str, float]]()

    def __reduce__(self) -> Any:
        return fingers, tuple(self.drawn.values())

    def __len__(self) -> int:
        return self._count

    def __getitem__(self, place: Any) -> Any:
        if isinstance(place, slice):
            return [self[k] for k in range(*place.indices(self._count))]
        at = range(self._count)[place]
        if not self._first <= at < self._first + len(self._block):
            first = at - at % BLOCK
            self._first, self._block = first, self._draw(first, min(BLOCK, self._count - first))
        return self._block[at - self._first]

    def __iter__(self) -> Iterator[dict[str, float]]:
        for first in range(0, self._count, BLOCK):
            yield from self._draw(first, min(BLOCK, self._count - first))


def fingers(
    n: int,
    seed: int,
    population: Population | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    loads_n: tuple[float, float] | None = None,
    coefficients: tuple[float, float] | None = None,
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
    coefficients : (float, float), optional
        Least and largest friction coefficient, limit of friction over load (`coefficient_of`), between which it is
        uniform: ``friction.nominal_n`` follows.

    Raises
    ------
    FrictionloopError
        For an n below 1 or a seed out of range, or what is not a whole number; for a population that cannot be read or
        has a value that fingers do not have; for loads or coefficients that are not above 0 and rising.
    """
    whole("n", n, 1, 2**32)
    whole("seed", seed, 0, 2**64 - 1)
    measured = None if population is None else read_population(population)
    for name, ends in (("loads_n", loads_n), ("coefficients", coefficients)):
        _check_ends(name, ends)
    if measured is not None:
        _check_measured(measured)

    def block(first: int, count: int) -> list[dict[str, float]]:
        z = normals(seed, POPULATION_STREAM, first * SLOTS, (first + count) * SLOTS).reshape(count, SLOTS)
        found = [_finger(row) | DRAWN_AT | {"motion.person": first + k} for k, row in enumerate(z)]
        if measured is not None:
            _as_measured(found, z, measured)
        if loads_n is not None:
            drawn = _between(loads_n, z, "motion.load_n")
            found = [each | {"motion.load_n": load} for each, load in zip(found, drawn, strict=True)]
        if coefficients is not None:
            drawn = _between(coefficients, z, "friction.nominal_n")
            found = [_with_coefficient(each, value) for each, value in zip(found, drawn, strict=True)]
        return found

    whose = {"n": n, "seed": seed, "population": population, "loads_n": loads_n, "coefficients": coefficients}
    return DrawnFingers(n, whose, block)


def fingers_for(
    system: System,
    n: int,
    seed: int = 0,
    population: Population | Mapping[str, Any] | str | os.PathLike[str] | None = None,
    loads_n: tuple[float, float] | None = None,
    coefficients: tuple[float, float] | None = None,
    *,
    given: Collection[str] = (),
) -> Fingers:
    """Return `fingers` in the place of that of a system.

    Parameters
    ----------
    system
        The bench, whose friction, finger and motion are of the kinds that fingers need.
    n, seed, population, loads_n, coefficients
        As of `fingers`.
    given
        Dotted names of values that somebody gave for all fingers.

    Raises
    ------
    FrictionloopError
        As `fingers`, for a system without a finger, and for a value given that each finger brings itself.
    """
    check_finger(system)
    people = fingers(n, seed, population, loads_n, coefficients)
    for path in given:
        if path in people[0]:
            raise FrictionloopError(f"{path}: each finger brings its own; leave it out")
    return people


def check_finger(system: System) -> None:
    """Refuse a system without a finger that moves."""
    wanted: dict[str, type[BaseModel]] = {"friction": FingerFriction, "finger": Skin, "motion": Strokes}
    for name, model in wanted.items():
        block, kind = getattr(system, name), model.model_fields["kind"].default
        if not isinstance(block, model):
            raise FrictionloopError(f'{name}.kind = "{block.kind}": must be "{kind}", as in bench(), for fingers')


def coefficient_of(finger: Mapping[str, Any]) -> float:
    """Return the friction coefficient of a finger just landed, f0 (N/N0)^(n - 1) / N0 at its mean load N.

    That is the limit of friction without vibration over the load, at the reference speed.

    Parameters
    ----------
    finger : mapping
        Dotted paths to values, as from `fingers`; what is missing is the default of `FingerFriction` and `Strokes`.

    Raises
    ------
    FrictionloopError
        For a load that is not above 0.
    """
    usual = {path: model.model_fields[path.partition(".")[2]].default for path, model in _COEFFICIENT.items()}
    values = {**usual, **finger}
    f0, n, load_n, reference_n = (float(values[path]) for path in _COEFFICIENT)
    if not load_n > 0.0:
        raise must_be("motion.load_n", load_n, "above 0", "N")
    return f0 * (load_n / reference_n) ** (n - 1.0) / reference_n


_COEFFICIENT: dict[str, type[BaseModel]] = {
    "friction.nominal_n": FingerFriction,
    "friction.load_exponent": FingerFriction,
    "motion.load_n": Strokes,
    "friction.reference_load_n": FingerFriction,
}
"""What a coefficient follows from, and whose values these are."""


def _with_coefficient(finger: dict[str, float], coefficient: float) -> dict[str, float]:
    found = finger | DRAWN_AT
    return found | {"friction.nominal_n": found["friction.nominal_n"] * coefficient / coefficient_of(found)}


def _check_ends(name: str, ends: tuple[float, float] | None) -> None:
    if ends is not None and not 0 < ends[0] <= ends[1] < math.inf:
        raise must_be(name, tuple(ends), "above 0, the least before the largest", "N" if name == "loads_n" else "")


def _between(ends: tuple[float, float], z: np.ndarray, path: str) -> list[float]:
    """Return values that are uniform between two, each by its own column of the noise."""
    low, high = ends
    return (low + (high - low) * ndtr(z[:, COLUMNS.index(path)])).tolist()


def _check_measured(population: Population) -> None:
    drawn = [*UNIFORM, *LOG_UNIFORM, *LOG_NORMAL]
    for each in population.value:
        if each.path not in drawn or UNIFORM.get(each.path, (0.0,))[0] < 0:
            known = ", ".join(path for path in drawn if UNIFORM.get(path, (0.0,))[0] >= 0)
            raise FrictionloopError(f"population: path = {each.path!r}: accepted: {known}")


def _as_measured(found: list[dict[str, float]], z: np.ndarray, population: Population) -> None:
    """Draw the values that were measured from the population, in their places: median e^(spread R z).

    Friction is then at the load and speed of the system.
    """
    # Each value keeps its own column of the noise, so a finger changes in what was measured alone.
    brought = DRAWN_AT if any(each.path == "friction.nominal_n" for each in population.value) else ()
    own = z[:, [COLUMNS.index(each.path) for each in population.value]] @ population.root().T
    for finger, row in zip(found, own, strict=True):
        for each, normal in zip(population.value, row.tolist(), strict=True):
            finger[each.path] = each.median * math.exp(each.spread * normal)
        for path in brought:
            del finger[path]


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
