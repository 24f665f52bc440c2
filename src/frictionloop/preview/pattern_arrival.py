"""What of effects arrives, for several fingers, at several speeds, under several laws, and how differently."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from frictionloop.findings import Result
from frictionloop.loop.kernel.lane_grouping import tiles_of
from frictionloop.loop.kernel.tile_compatibility import structure
from frictionloop.loop.progress import progress_bar
from frictionloop.loop.record import provenance
from frictionloop.loop.simulate import traced
from frictionloop.parameters import Strokes, System
from frictionloop.parameters.controller import Model
from frictionloop.preview.pattern_measures import Delivered, delivered
from frictionloop.preview.prepared_stroke import both, duration_s, playable_forces, prepared
from frictionloop.quantities import Array, must_be
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_toml import find

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]


class People(Result, schema="rendering.people/1"):
    """What of an effect several fingers are given, open and closed loop."""

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
    return People(open_loop=tuple(delivered_to(opened, seed)), closed_loop=tuple(delivered_to(closed, seed)))


def check_fingers(fingers: Sequence[Mapping[str, Any]]) -> None:
    """Refuse an empty population."""
    if not fingers:
        raise must_be("fingers", 0, "at least one")


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


Laws = Mapping[str, Mapping[str, Any] | Sequence[Mapping[str, Any]]]
OPEN_AND_CLOSED: Laws = {"open": {"controller.kind": "lookup"}, "closed": {}}
"""The lookup alone, of the table that the law has, and the law of the system."""


def arrivals(
    effects: Mapping[str, Effect] | Sequence[str],
    system: System,
    fingers: Sequence[Mapping[str, Any]],
    speeds_mm_s: Sequence[float] = (20.0, 50.0, 100.0, 150.0),
    seed: int = 0,
    laws: Laws = OPEN_AND_CLOSED,
    progress: bool | None = False,
) -> xr.Dataset:
    """Return how much of each effect arrives, for each finger at each speed under each law.

    Parameters
    ----------
    effects : mapping or list
        Effects by name, or names of the library.
    system, fingers, seed
        As of ``fl.rendering.people``.
    speeds_mm_s : list of float
        Speeds of the stroke, mm/s.
    laws : mapping
        What each law changes, by its name: values by dotted name, or a list of such, one for each finger. If not given,
        ``"open"`` is the lookup alone, of the same ``controller.model``, and ``"closed"`` the law of the system.
    progress : bool, optional
        Show a progress bar; None: on a terminal.

    Returns
    -------
    xarray.Dataset
        ``contrast`` (1), ``rms_error`` (N), ``error_felt`` (1) and ``pattern_felt`` (1) over ``effect``,
        ``speed_mm_s``, ``law`` and ``finger``; ``spread`` (N), the standard deviation between fingers at a place, over
        the first three.

    Raises
    ------
    FrictionloopError
        As ``fl.rendering.people``, and for a law with another number of values than there are fingers.
    """
    named = effects if isinstance(effects, Mapping) else {name: find(name) for name in effects}
    check_fingers(fingers)
    if laws is OPEN_AND_CLOSED:
        both(system)
    under = {law: _for_each(law, given, fingers) for law, given in laws.items()}
    shape = (len(named), len(speeds_mm_s), len(laws))
    values = np.empty((len(_TOLD), *shape, len(fingers)))
    spread = np.empty(shape)
    with progress_bar("arrivals", spread.size, progress) as bar:
        for i, j, k in np.ndindex(shape):
            name, speed, law = list(named)[i], speeds_mm_s[j], list(under)[k]
            bar.doing(f"{name} at {speed:g} mm/s, {law}")
            shown = [prepared(named[name], system.evolve(each), speed) for each in under[law]]
            playable_forces(shown[0])
            ways = delivered_to(shown, seed)
            spread[i, j, k] = spread_n(ways)
            values[:, i, j, k] = [[getattr(each, of) for each in ways] for of in _TOLD]
            bar()
    dims = ("effect", "speed_mm_s", "law", "finger")
    data: dict[str, Any] = {
        name: (dims, each, {"units": unit}) for (name, unit), each in zip(_TOLD.values(), values, strict=True)
    }
    data["spread"] = (dims[:3], spread, {"units": "N"})
    coordinates = {"effect": list(named), "speed_mm_s": list(speeds_mm_s), "law": list(laws)}
    return xr.Dataset(data, coordinates, provenance(system, seed=seed))


_TOLD = {
    "contrast": ("contrast", "1"),
    "rms_error_n": ("rms_error", "N"),
    "error_felt": ("error_felt", "1"),
    "pattern_felt": ("pattern_felt", "1"),
}
"""Of `Delivered`, by the name and the unit in a table."""


def _for_each(law: str, given: Any, fingers: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return what a law and a finger change together, for each finger."""
    own = [given] * len(fingers) if isinstance(given, Mapping) else list(given)
    if len(own) != len(fingers):
        raise must_be(f"laws: {law}", len(own), f"{len(fingers)}, as fingers", "values")
    return [{**finger, **each} for finger, each in zip(fingers, own, strict=True)]
