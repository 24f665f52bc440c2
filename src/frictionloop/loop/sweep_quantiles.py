"""Quantiles of a sweep over its people, from a table of counts a shard: no more than one shard is ever in memory."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.parallel_runs import shared_out, worker_count
from frictionloop.loop.record import load
from frictionloop.loop.sweep_shards import coordinates_of, together
from frictionloop.quantities import must_be

WITHIN = 0.005
"""Relative distance from a quantile of the values themselves that a bucket leaves."""
LEAST, MOST = 1e-15, 1e15
"""Sizes that are told apart, assumed: nearer to zero it is zero, beyond it is infinite."""
WIDTH = math.log((1 + WITHIN) / (1 - WITHIN))
OUTER = math.ceil(math.log(MOST / LEAST) / WIDTH) + 1
"""Bucket of infinity; 0 is that of zero, and those of negative values are negative."""
Counts = tuple[np.ndarray, np.ndarray]


def sweep_quantiles(folder: str | os.PathLike[str], quantiles: Sequence[float] = (0.1, 0.5, 0.9)) -> xr.Dataset:
    r"""Return quantiles of a sweep in shards over its first axis and its seeds, by the other axes.

    Each shard is counted where joblib's active back end runs it, in buckets
    :math:`\gamma^{k-1} < |x|/x_0 \le \gamma^k` with :math:`\gamma = (1 + \alpha)/(1 - \alpha)`; counts add up.

    Parameters
    ----------
    folder
        Where ``sweep(..., shard=(i, n))`` has put them; what has not run does not count.
    quantiles
        Shares from 0 to 1.

    Returns
    -------
    xarray.Dataset
        Each metric over ``quantile`` and the other axes, within :math:`\alpha = 0.5` % of a value that was found; the
        same bits in whatever shards, NaN where nothing has run.

    Raises
    ------
    FrictionloopError
        For shares out of range, and as `open_sweep`.

    References
    ----------
    Masson, Rim and Lee, DDSketch, Proc. VLDB Endowment 12, 2195 (2019).
    """
    shares = np.atleast_1d(np.asarray(quantiles, float))
    if not ((shares >= 0) & (shares <= 1)).all():
        raise must_be("quantiles", quantiles, "shares from 0 to 1")
    files, attrs = together(folder, told=True)
    first = next(iter(attrs.values()))
    shape = json.loads(first["shape"])
    groups, counts = math.prod(shape[1:-1]), dict[str, Counts]()
    calls = ((files[part], groups, shape[-1]) for part in attrs)
    with closing(shared_out(counted, calls, worker_count(None))) as done:
        for found in done:
            counts = {name: _added(counts.get(name), each) for name, each in found.items()}
    coords = dict(list(coordinates_of(first).items())[1:])
    units = {name: each.attrs for name, each in load(files[next(iter(attrs))]).data_vars.items()}
    values = {name: _read(each, groups, shares).reshape(-1, *shape[1:-1]) for name, each in counts.items()}
    data = {name: xr.Variable(("quantile", *coords), each, units[name]) for name, each in values.items()}
    return xr.Dataset(data, {"quantile": shares, **coords})


def counted(path: Path, groups: int, seeds: int) -> dict[str, Counts]:
    """Return of each metric of a shard which buckets of which groups there are, and how many values are in each."""
    part = load(path)
    group = part["run"].values // seeds % groups
    found = {}
    for name, each in part.data_vars.items():
        values = each.values
        there = ~np.isnan(values)
        found[str(name)] = np.unique(group[there] * (2 * OUTER + 1) + bucket(values[there]) + OUTER, return_counts=True)
    return found


def bucket(values: np.ndarray) -> np.ndarray:
    """Return the numbers of the buckets of values."""
    sizes = np.abs(values)
    number = np.ceil(np.log(np.clip(sizes, LEAST, MOST) / LEAST) / WIDTH).astype(np.int64)
    number = np.where(sizes > MOST, OUTER, np.where(sizes < LEAST, 0, np.maximum(number, 1)))
    return number * np.sign(values).astype(np.int64)


def value_of(number: np.ndarray) -> np.ndarray:
    """Return what stands for a bucket: at most the relative distance from all that is in it."""
    size = LEAST * np.exp(WIDTH * (np.abs(number) - 1)) * (1 + WITHIN)
    return np.where(number == 0, 0.0, np.sign(number) * np.where(np.abs(number) >= OUTER, np.inf, size))


def _added(one: Counts | None, other: Counts) -> Counts:
    if one is None:
        return other
    keys, place = np.unique(np.concatenate([one[0], other[0]]), return_inverse=True)
    total = np.zeros(keys.size, np.int64)
    np.add.at(total, place, np.concatenate([one[1], other[1]]))
    return keys, total


def _read(counts: Counts, groups: int, shares: np.ndarray) -> Any:
    """Return the quantiles of each group."""
    group, number = counts[0] // (2 * OUTER + 1), counts[0] % (2 * OUTER + 1) - OUTER
    sizes = np.bincount(group, counts[1], groups)
    rank = np.cumsum(sizes) - sizes + np.maximum(np.ceil(shares[:, None] * sizes), 1)
    place = np.searchsorted(np.cumsum(counts[1]), rank)
    return np.append(value_of(number), np.nan)[np.where(sizes > 0, place, -1)]
