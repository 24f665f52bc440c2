"""Every value of a sweep tried before anything runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from frictionloop.loop.formulas import METRICS
from frictionloop.loop.kernel.structure import COUPLED, STRUCTURAL, structure
from frictionloop.loop.points import Points
from frictionloop.loop.step_times import STEP_TIMES
from frictionloop.loop.timing import is_finite, periods_in
from frictionloop.parameters import Recording, System
from frictionloop.physics.sources import sampler
from frictionloop.quantities import FrictionloopError


def structures_of(
    system: System, grid: Points, duration_s: float, score_from_s: float, names: Sequence[str]
) -> list[object]:
    """Try every value of a sweep before anything runs and return the structure of each point."""
    read: set[tuple[Recording, float]] = set()

    def tried(override: dict[str, Any]) -> object:
        changed = system.evolve(override)
        periods = periods_in(changed, duration_s)
        scored = is_finite(score_from_s) and 0 <= score_from_s < duration_s
        if not (scored and round(score_from_s * changed.controller.rate_hz) < periods):
            raise FrictionloopError(
                f"score_from_s = {score_from_s!r} s: must be at least 0 and below duration_s = {duration_s!r} s"
            )
        stepped = [name for name in names if getattr(METRICS[name], "tally", None) is STEP_TIMES]
        if stepped and changed.setpoint.kind != "steps":
            raise FrictionloopError(
                f"metric {stepped[0]}: needs steps to follow; setpoint.kind is {changed.setpoint.kind!r}, not 'steps'"
            )
        for source in (changed.setpoint, changed.disturbance):
            # A file that is missing or too short is found now, not when its tile runs.
            rate = changed.controller.rate_hz
            if isinstance(source, Recording) and (source, rate) not in read:
                read.add((source, rate))
                sampled = sampler(source, rate, 0, 0)
                assert sampled is not None
                sampled(0, periods)
        return structure(changed)

    # Systems are not kept: thousands of small objects would cost the garbage collector more than the kernel takes.
    probed = [tried(override) for override in grid.probes()]
    if not grid.gridded:
        return probed
    # Whatever describes the plate may change how many segments a period has.
    plain = not any(path.startswith("plate.") or path.endswith(STRUCTURAL) for path in grid.axes)
    plain = plain and all(axis.dtype.kind in "if" for axis in grid.axes.values())
    plain = plain and sum(path.endswith(COUPLED) for path in grid.axes) < 2
    return probed[:1] * len(grid.overrides) if plain else [tried(override) for override in grid.overrides]
