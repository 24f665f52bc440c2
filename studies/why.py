"""Why laws of a comparison win or lose: their residuals split by cause and by frequency, on the fingers it scored.

``python -m studies.why notch_pi [FINGERS]`` keeps a table of medians: two minutes for 60 fingers.
"""

from __future__ import annotations

import itertools
import math
import sys
from collections.abc import Iterable
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_scores import spread
from frictionloop.design.comparison.trial_protocol import Condition
from frictionloop.parameters import bench
from studies.causes import CAUSES
from studies.kept import keep
from studies.residual import residual_by_cause
from studies.residual_bands import residual_bands

MOST, FEW = 100, 20
"""Fingers that are split by cause at most, and by frequency, which takes traces."""
TASK = trial_protocol.SINES[1]
"""What they do: the sine in the middle."""
Row = dict[str, Any]


def reasons(comparison: rooms.LawRuns, laws: Iterable[str], *, n_jobs: int | None = None) -> xr.Dataset:
    """Return `residual_by_cause` and `residual_bands` of some laws over law, speed and slip length.

    On the first 100 capable fingers of the population (of all if none is capable) at the sine around 0.6 N; bands on
    the first 20. A cause that cannot be taken away under one law has NaN there.
    """
    asked, speeds = list(laws), list(comparison.speeds_mm_s)
    lengths = trial_protocol.lengths_of(comparison.system)
    cells = itertools.product(asked, speeds, lengths)
    parts = [_split(comparison, *cell, n_jobs) for cell in cells]
    everyone = sorted({i for part in parts for i in part["finger"].values.tolist()})
    names = [name for name in CAUSES if any(name in part["cause"].values for part in parts)]
    flat = [part.reindex(finger=everyone, cause=names) for part in parts]
    axes: dict[str, list[Any]] = {"law": asked, "speed_mm_s": speeds, "slip_length_um": list(lengths)}
    shape = tuple(len(values) for values in axes.values())
    data: dict[str, Any] = {}
    for name, first in flat[0].data_vars.items():
        stacked = np.array([part[name].values for part in flat])
        data[str(name)] = ((*axes, *first.dims), stacked.reshape(*shape, *first.shape), first.attrs)
    own = {str(name): flat[0][name] for name in flat[0].coords}
    return xr.Dataset(data, own | axes)


def _split(comparison: rooms.LawRuns, law: str, speed: float, length_um: float, n_jobs: int | None) -> xr.Dataset:
    some = np.flatnonzero(trial_protocol.able(comparison.system, comparison.people, speed, comparison.duration_s))
    numbers = (some if some.size else np.arange(len(comparison.people)))[:MOST]
    people = [comparison.people[i] for i in numbers]
    at = Condition(speed, length_um, TASK)
    bench = comparison.system.evolve({**trial_protocol.overrides_of(at, comparison.duration_s), **comparison.laws[law]})
    seed, start_s = trial_protocol.noise_seed(comparison.seed, TASK), comparison.start_s
    options: dict[str, Any] = {"score_from_s": start_s, "n_jobs": n_jobs, "progress": False}
    found = residual_by_cause(bench, people, comparison.duration_s, [seed], **options)
    bands = residual_bands(bench, people[:FEW], comparison.duration_s, seed, score_from_s=start_s)
    return found.drop_vars("kind").assign(band_rms=bands["rms"].median("finger")).assign_coords(finger=numbers)


def reason_rows(found: xr.Dataset) -> list[Row]:
    """Return a row for each law, speed, slip length and part of the residual: medians and worst deciles, N."""
    rows = []
    for law, speed, z in itertools.product(
        *(found[dim].values.tolist() for dim in ("law", "speed_mm_s", "slip_length_um"))
    ):
        cell = found.sel(law=law, speed_mm_s=speed, slip_length_um=z)
        where = {"law": law, "speed_mm_s": speed, "slip_length_um": z}
        for name in ("all", "silent", "left_over_costs", "left_over_alone"):
            rows.append(where | {"part": name, **_spread("rms", cell[name])})
        for cause in found["cause"].values.tolist():
            own = cell.sel(cause=cause)
            values = {
                key: value for name in ("cost", "alone", "without") for key, value in _spread(name, own[name]).items()
            }
            rows.append(where | {"part": cause, **values})
        for low, high, rms in zip(
            *(cell[name].values.tolist() for name in ("low_hz", "high_hz", "band_rms")), strict=True
        ):
            rows.append(where | {"part": f"{low:g}-{high:g} Hz", "rms_median": rms})
    return rows


def _spread(name: str, values: xr.DataArray) -> dict[str, float]:
    there = values.values[np.isfinite(values.values)]
    median, worst = spread(there, larger_is_better=False)
    return {f"{name}_median": median, f"{name}_worst_decile": worst}


def main(laws: str = "notch_pi", fingers: str = "60") -> None:
    """Keep what each part of the residual costs: a column for each law, speed and slip length, medians in mN."""
    names = laws.split(",")
    rows = reason_rows(reasons(rooms.run_laws(bench(), names, int(fingers)), names))
    cells: dict[str, dict[str, str]] = {}
    for row in rows:
        at = f"{row['law']}, {row['speed_mm_s']:g} mm/s, {row['slip_length_um']:g} um"
        value = row["cost_median"] if "cost_median" in row else row["rms_median"]
        cells.setdefault(row["part"], {})[at] = "-" if math.isnan(value) else f"{1e3 * value:.1f}"
    heads = list(cells["all"])
    keep(
        "why",
        f"why {laws} {fingers}",
        ("part", *heads),
        ([part, *(found[at] for at in heads)] for part, found in cells.items()),
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
