"""Control laws compared on effects: how much of a pattern arrives, and how differently fingers are given it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, MutableMapping, Sequence
from typing import Any

import numpy as np

from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.entrants import Entrant, Overrides, entrants
from frictionloop.design.comparison.scores import spread
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers
from frictionloop.preview.arrivals import delivered_to, spread_n
from frictionloop.preview.prepared_stroke import playable_forces, prepared
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_toml import find

SEED = 0
"""Seed of all noise: the same for every finger, law and effect."""
ERRORS = ("rms_error_n", "error_felt")
Cell = dict[str, float]
Key = tuple[str, str, float]
"""Law, effect and speed in mm/s."""


def arrived(
    system: System, effect: Effect | str, law: Overrides, speed_mm_s: float, count: int, seed: int
) -> dict[str, float]:
    """Return how much of an effect arrives at the capable ones of random fingers.

    Parameters
    ----------
    system : System
        The bench.
    effect : Effect or str
        The effect, or its name.
    law : dict
        What a law changes on the bench, by dotted name.
    speed_mm_s : float
        Speed of the strokes.
    count, seed : int
        The fingers, as of `compare`; every third meets a sensor whose resonance is 5 % off each way.

    Returns
    -------
    dict
        ``fingers``, how many are capable; ``spread_n``, the standard deviation between them of the force at a place, N;
        medians of ``contrast`` (1), ``rms_error_n`` (N), ``error_felt`` and ``pattern_felt`` (thresholds); the deciles
        ``contrast_low`` and ``contrast_high``, and the worst deciles ``rms_error_n_worst`` and ``error_felt_worst``.

    Raises
    ------
    FrictionloopError
        As `fl.rendering.preview`, and for a bench on which no finger is capable.
    """
    people = protocol.population(system, count, seed)
    some = protocol.able(system, people, speed_mm_s)
    if not some.any():
        forces = f"{protocol.LOW_N:g} and {protocol.HIGH_N:g} N at {speed_mm_s:g} mm/s"
        raise FrictionloopError(f"fingers = {count}: none can be given {forces}; take more")
    able = Fingers(each for each, counts in zip(people, some, strict=True) if counts)
    shown = [prepared(effect, system.evolve(each).evolve(law), speed_mm_s) for each in able]
    playable_forces(shown[0])
    ways = delivered_to(shown, SEED)
    names = ("contrast", "pattern_felt", *ERRORS)
    values = {name: np.array([getattr(each, name) for each in ways]) for name in names}
    found: Cell = {"fingers": len(able), "spread_n": spread_n(ways)}
    found |= {name: float(np.median(each)) for name, each in values.items()}
    found |= {f"{name}_worst": spread(values[name], larger_is_better=False)[1] for name in ERRORS}
    low, high = np.quantile(values["contrast"], (0.1, 0.9))
    return found | {"contrast_low": float(low), "contrast_high": float(high)}


def effect_cells(
    system: System,
    effects: Mapping[str, Effect] | Sequence[str],
    laws: Iterable[str] | Mapping[str, Entrant] | None = None,
    count: int = protocol.SMALL,
    seed: int = protocol.EVALUATION_SEED,
    speeds_mm_s: Sequence[float] = protocol.SPEEDS_MM_S,
    *,
    kept: MutableMapping[Key, Cell] | None = None,
    save: Callable[[], Any] = lambda: None,
    progress: bool | None = None,
) -> dict[Key, Cell]:
    """Return what `arrived` finds for each law, effect and speed.

    Parameters
    ----------
    system, laws, count, seed, speeds_mm_s, progress
        As of `compare`; without ``laws``, all that can run on this bench and need not know a set-point ahead.
    effects : mapping or list
        Effects by name, or names of the library and of TOML files.
    kept : dict, optional
        Cells that are there already; new ones are added, and ``save()`` is called after each.

    Raises
    ------
    FrictionloopError
        As `compare` and `arrived`.
    """
    named = dict(effects) if isinstance(effects, Mapping) else {name: find(name) for name in effects}
    fields, found = entrants(laws), {} if kept is None else kept
    protocol.population(system, count, seed)
    speeds = protocol.speeds_of(system, speeds_mm_s)
    for effect, speed in itertools.product(named.values(), speeds):
        playable_forces(prepared(effect, system, speed))
    with progress_bar("effects", len(fields) * len(named) * len(speeds), progress) as bar:
        for law, entrant in fields.items():
            left = [(name, speed) for name in named for speed in speeds if (law, name, speed) not in found]
            bar.doing(f"designing {law}")
            changes = next(_designed(entrant, system, spare=laws is None), None) if left else None
            for name, speed in itertools.product(named, speeds):
                if changes is not None and (name, speed) in left:
                    bar.doing(f"{law}, {name} at {speed:g} mm/s")
                    found[law, name, speed] = arrived(system, named[name], changes, speed, count, seed)
                    save()
                bar()
    return dict(found)


def _designed(entrant: Entrant, system: System, spare: bool) -> Iterator[Overrides]:
    """Yield what a law changes; nothing if it cannot run on this bench and is spared."""
    try:
        changes = entrant(system)
        system.evolve(changes)
    except FrictionloopError:
        if not spare:
            raise
        return
    yield changes
