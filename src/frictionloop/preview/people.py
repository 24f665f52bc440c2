"""The preview of an effect for several fingers: what each gets, and how differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from frictionloop.findings import Result
from frictionloop.loop.kernel.placing import tiles_of
from frictionloop.loop.kernel.structure import structure
from frictionloop.loop.simulate import traced
from frictionloop.parameters import Strokes, System
from frictionloop.parameters.timing import Model
from frictionloop.preview.measures import Delivered, delivered
from frictionloop.preview.prepared_stroke import both, duration_s, prepared
from frictionloop.preview.stroke_forces import playable_forces
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.checks import Array
from frictionloop.rendering.effect import Effect

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]


@dataclass(frozen=True, kw_only=True)
class People(Result):
    """What of an effect several fingers are given, open and closed loop."""

    SCHEMA: ClassVar[str] = "rendering.people/1"
    open_loop: tuple[Delivered, ...]
    """Of each finger, with the lookup alone."""
    closed_loop: tuple[Delivered, ...]
    """Of each finger, with the system's control law."""

    @property
    def spread_n(self) -> tuple[float, float]:
        """Standard deviation between fingers of the force at a place, rms over places, N: open and closed loop."""
        return spread_n(self.open_loop), spread_n(self.closed_loop)

    @property
    def contrasts(self) -> tuple[Array, Array]:
        """Contrast that each finger is given, open and closed loop."""
        ways = (self.open_loop, self.closed_loop)
        opened, closed = (np.array([each.contrast for each in way]) for way in ways)
        return opened, closed

    @property
    def spread(self) -> str:
        """The spread, for a row."""
        here, there = self.spread_n
        return f"{1e3 * here:.0f} mN open loop, {1e3 * there:.0f} mN closed ({len(self.open_loop)} fingers)"

    def rows(self) -> list[tuple[str, str]]:
        """Return the spread."""
        return [("between fingers", self.spread)]

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return contrast and error of each finger."""
        import pandas as pd

        ways = {"open": self.open_loop, "closed": self.closed_loop}
        columns = {f"contrast {name}, %": [100.0 * each.contrast for each in way] for name, way in ways.items()}
        columns |= {f"error {name}, mN": [1e3 * each.rms_error_n for each in way] for name, way in ways.items()}
        return {"fingers": pd.DataFrame(columns).rename_axis("finger")}

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name, the spread too."""
        return super().to_dict() | {"spread_n": dict(zip(("open_loop", "closed_loop"), self.spread_n, strict=True))}


def people(
    effect: Effect | str,
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    stroke: Strokes | float | None = None,
    seed: int = 0,
    *,
    table: Model | None = None,
) -> People:
    """Return what of an effect several fingers are given.

    Parameters
    ----------
    effect, system, stroke, seed, table
        As of ``fl.rendering.preview``.
    fingers : list of dict
        From ``fl.fingers(n, seed)``, or such dicts of values by dotted name.

    Raises
    ------
    FrictionloopError
        As ``fl.rendering.preview``.
    """
    check_fingers(fingers)
    shown = [prepared(effect, system.evolve(finger), stroke) for finger in fingers]
    playable_forces(shown[0])
    opened, closed = zip(*(both(each, table).values() for each in shown), strict=True)
    return People(
        open_loop=tuple(delivered_to(opened, seed)),
        closed_loop=tuple(delivered_to(closed, seed)),
    )


def check_fingers(fingers: Sequence[Mapping[str, Any]]) -> None:
    """Refuse an empty population."""
    if not fingers:
        raise FrictionloopError("fingers: must be at least one")


def delivered_to(systems: Sequence[System], seed: int) -> list[Delivered]:
    """Return what is delivered in each system's run; those that can share a tile run side by side."""
    found: dict[int, Delivered] = {}
    keys = [(structure(each), duration_s(each)) for each in systems]
    for lanes in tiles_of(keys, range(len(systems))):
        runs = traced([systems[lane] for lane in lanes], [seed] * len(lanes), keys[lanes[0]][1])
        found |= {lane: delivered(run, systems[lane].controller.kind) for lane, run in zip(lanes, runs, strict=True)}
    return [found[lane] for lane in range(len(systems))]


def spread_n(ways: Sequence[Delivered]) -> float:
    """Return the standard deviation between fingers of the force at a place, rms over places, N."""
    forces = np.array([each.over_n for each in ways])
    known = np.isfinite(forces).all(axis=0)
    return float(np.sqrt(np.mean(np.var(forces[:, known], axis=0))))
