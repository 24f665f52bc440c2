"""How much of several effects arrives, for several fingers at several speeds, under several laws."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.loop.progress import progress_bar
from frictionloop.loop.record import provenance
from frictionloop.parameters import System
from frictionloop.preview.people import check_fingers, delivered_to, spread_n
from frictionloop.preview.prepared_stroke import both, prepared
from frictionloop.preview.stroke_forces import playable_forces
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.files import find

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
        raise FrictionloopError(f"laws: {law!r} must have values for each finger")
    return [{**finger, **each} for finger, each in zip(fingers, own, strict=True)]
