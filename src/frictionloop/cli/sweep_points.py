"""A short sweep, point by point, and which of its loops ring by linear analysis."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

from frictionloop.cli import describe, screen
from frictionloop.cli.flags import again
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from pathlib import Path

    from frictionloop.cli.outcome import Outcome
    from frictionloop.parameters import System

Given = tuple["Path | None", str | None, list[str] | None]
"""A system on the command line: its file, its preset, its flags."""


def listed(found: Outcome, system: System) -> list[Any]:
    """Return a table with a row per point, means over seeds; nothing for many points."""
    from frictionloop.cli.outcome import shown

    if not found.few:
        return []
    names = [str(name) for name, values in found.result.data_vars.items() if values.dtype.kind == "f"]
    rows: list[tuple[str, ...]] = [(", ".join(found.axes), *names, "")]
    for at in product(*(range(found.result.sizes[path]) for path in found.axes)):
        here = found.result.isel(dict(zip(found.axes, at, strict=True)))
        point = {path: here[path].item() for path in found.axes}
        means = [(float(here[name].mean()), str(here[name].attrs.get("units", "1"))) for name in names]
        cells = ["-" if math.isnan(mean) else shown(mean, units) for mean, units in means]
        rows.append((", ".join(map(describe.short, point.values())), *cells, rings(system, point) or ""))
    return [screen.table(rows), ""]


def margins(found: Outcome, system: System, of: Given) -> list[str]:
    """Return whether the loop rings at the best point of the first metric, and what says more, where gains vary.

    Nothing of a law that has no margins.
    """
    from frictionloop.cli.one_place import WITHOUT_CHECK, unasked, without

    best = next(filter(None, map(found.best, map(str, found.result.data_vars))), None)
    if best is None or not any(path.startswith("controller.") for path in found.axes):
        return []
    if system.evolve(best.point).controller.kind in WITHOUT_CHECK:
        return []
    file, preset, flags = of
    point = [f"{path}={value}" for path, value in best.point.items()]
    system_flags = [flag for flag in flags or () if flag.partition("=")[0] not in best.point]
    how = rings(system, best.point)
    said = [f"The loop with the best {best.metric} {how or 'does not ring as described'}."] if how is not None else []
    more = f"Its margins, at other slip lengths and speeds too{without(flags)}:"
    return ["", *said, more, f"  frictionloop design check {again(file, preset, [*system_flags, *point], unasked)}"]


def rings(system: System, point: dict[str, Any]) -> str | None:
    """Return "RINGS" or "nearly rings" with its Ms, of a system at a point; empty of neither, None if not known.

    Looked at are the lowest, mean and highest force of the set-point, on a dry finger and a moist one.
    """
    from frictionloop.analysis.stability import NEAR
    from frictionloop.cli.ringing import points_of

    try:
        peak = max(loop.sensitivity_peak() for loop in points_of(system.evolve(point)))
    except FrictionloopError:  # what cannot be linearised is not judged
        return None
    return "" if peak < NEAR else f"nearly rings, Ms {peak:.3g}" if math.isfinite(peak) else "RINGS"
