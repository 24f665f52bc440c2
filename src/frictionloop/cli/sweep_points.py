"""A short sweep, point by point, and which of its loops ring by linear analysis."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

from frictionloop.cli import describe, screen
from frictionloop.cli.advice_text import NEAR
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.cli.outcome import Outcome
    from frictionloop.parameters import System


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
        rows.append((", ".join(map(describe.short, point.values())), *cells, rings(system, point)))
    return [screen.table(rows), ""]


def margins(found: Outcome, system: System, given: str) -> list[str]:
    """Return whether the loop rings at the best point of the first metric, and what says more, where gains vary.

    ``given`` names the system on the command line.
    """
    best = next(filter(None, map(found.best, map(str, found.result.data_vars))), None)
    if best is None or not any(path.startswith("controller.") for path in found.axes):
        return []
    point = " ".join(f"--{path} {describe.short(value)}" for path, value in best.point.items())
    how = rings(system, best.point) or "does not ring as described"
    said = f"The loop with the best {best.metric} {how}."
    return [
        "",
        said,
        "Its margins, on other contacts and at other speeds too:",
        f"  frictionloop design check {given} {point}",
    ]


def rings(system: System, point: dict[str, Any]) -> str:
    """Return "RINGS" or "nearly rings" with its Ms, of a system at a point; empty if it does neither or is not known.

    Looked at are the lowest, mean and highest force of the set-point, on a dry finger and a moist one.
    """
    from frictionloop.cli.ringing import points_of

    try:
        peak = max(loop.sensitivity_peak() for loop in points_of(system.evolve(point)))
    except FrictionloopError:  # what cannot be linearised is not judged
        return ""
    return "" if peak < NEAR else f"nearly rings, Ms {peak:.3g}" if math.isfinite(peak) else "RINGS"
