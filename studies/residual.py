"""Why a law leaves what it leaves: the residual split by cause, by runs that pair up, and by frequency."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.record import provenance
from frictionloop.loop.sweep import sweep
from frictionloop.parameters import System
from studies.causes import DISTURBANCES, LIMITS, causes_of, without

ALL, SILENT = "all", "silent"
MEANING = {
    "all": "rms of f_a - f_r",
    "silent": "the same without any disturbance: what the loop does by itself",
    "without": "the same without this cause",
    "alone": "the same with this disturbance alone, or this limit alone and no disturbance",
    "cost": "sqrt(all^2 - without^2), signed: above 0 the cause costs",
    "left_over_costs": "sqrt(all^2 - sum of the disturbances' costs^2), signed",
    "left_over_alone": "sqrt(all^2 - silent^2 - sum over disturbances of (alone^2 - silent^2)), signed",
}


def residual_by_cause(
    system: System,
    fingers: Sequence[Mapping[str, Any]] | None = None,
    duration_s: float = 11.0,
    seeds: int | Sequence[int] = 1,
    *,
    score_from_s: float = 1.0,
    causes: Iterable[str] | None = None,
    n_jobs: int | None = None,
    progress: bool | None = None,
) -> xr.Dataset:
    """Return the residual with everything in it, without each cause, and with each cause alone.

    A disturbance alone is a run without the other disturbances; the loop's limits stay. Were the loop linear and time
    invariant, and the disturbances independent, their squares would add up to the whole, of costs as of runs alone:
    what is left over of the sum is what they do to each other. A limit alone is a run without disturbances and
    without the other limits: what it does by itself, such as ring.

    Parameters
    ----------
    system : System
        The loop, with any controller.
    fingers : sequence of mappings, optional
        Fingers as overrides, as from `fingers`; by default the system's own.
    duration_s, score_from_s : float
        Duration of each run and the start of its scored part, in s.
    seeds : int or sequence of int
        Seeds, the same for every run; squares are averaged over them.
    causes : iterable of str, optional
        Which of `causes.CAUSES` to take away; by default all the system has.
    n_jobs, progress
        As for `sweep`.

    Returns
    -------
    xarray.Dataset
        In N: ``all``, ``silent``, ``left_over_costs`` and ``left_over_alone`` over ``finger``; ``without``, ``alone``
        and ``cost`` over ``cause`` and ``finger``; ``kind`` of a cause is "disturbance" or "limit".
    """
    people = [dict(each) for each in (fingers if fingers is not None else [{}])]
    time = score_from_s, duration_s
    there = causes_of(system.evolve(people[0]), *time)
    names = there if causes is None else tuple(causes)
    variants = list(_variants(names, there))
    points = [each | without(system.evolve(each), removed, *time) for _, _, removed in variants for each in people]
    found = sweep(
        system, points, duration_s, seeds, ["rms_error"], score_from_s=score_from_s, n_jobs=n_jobs, progress=progress
    )
    rms = np.sqrt(np.mean(found["rms_error"].values ** 2, axis=-1)).reshape(len(variants), len(people))
    runs = {(what, name): row for (what, name, _), row in zip(variants, rms, strict=True)}
    attrs = provenance(system, duration_s=duration_s, score_from_s=score_from_s, seeds=found["seed"].values.tolist())
    return _dataset(names, runs, attrs)


def signed_root(square: Any) -> Any:
    """Return sqrt(|x|) with the sign of x."""
    return np.sign(square) * np.sqrt(np.abs(square))


def _variants(names: Sequence[str], there: Sequence[str]) -> Iterator[tuple[str, str, frozenset[str]]]:
    """Yield what a run is for, the cause it is about, and the causes taken away."""
    moving, limits = set(DISTURBANCES) & set(there), set(LIMITS) & set(there)
    yield ALL, "", frozenset()
    yield SILENT, "", frozenset(moving)
    for name in names:
        yield "without", name, frozenset({name})
        # A resonance that is not where it is believed to be is one that is there.
        kept = {name, "resonance"} if name == "misjudged resonance" else {name}
        yield "alone", name, frozenset(moving - kept if name in DISTURBANCES else (moving | limits) - kept)


def _dataset(names: Sequence[str], runs: Mapping[tuple[str, str], np.ndarray], attrs: dict[str, Any]) -> xr.Dataset:
    whole, silent = runs[ALL, ""], runs[SILENT, ""]
    less = np.array([runs["without", name] for name in names]).reshape(len(names), whole.size)
    alone = np.array([runs["alone", name] for name in names]).reshape(len(names), whole.size)
    moving = np.array([name in DISTURBANCES for name in names], dtype=bool)
    costs2, alone2 = whole**2 - less**2, alone**2 - silent**2
    both, finger = ("cause", "finger"), ("finger",)
    values: dict[str, tuple[tuple[str, ...], np.ndarray]] = {
        "all": (finger, whole),
        "silent": (finger, silent),
        "without": (both, less),
        "alone": (both, alone),
        "cost": (both, signed_root(costs2)),
        "left_over_costs": (finger, signed_root(whole**2 - costs2[moving].sum(axis=0))),
        "left_over_alone": (finger, signed_root(whole**2 - silent**2 - alone2[moving].sum(axis=0))),
    }
    data = {name: (*each, {"units": "N", "long_name": MEANING[name]}) for name, each in values.items()}
    kinds = ("cause", ["disturbance" if name in DISTURBANCES else "limit" for name in names])
    return xr.Dataset(data, {"cause": list(names), "kind": kinds, "finger": np.arange(whole.size)}, attrs)
