"""Control laws compared on effects: how much of a pattern arrives, and which law lets most of it."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterable, Mapping, MutableMapping, Sequence
from typing import Any

import numpy as np

from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_scores import spread
from frictionloop.design.comparison.trial_protocol import Entrant, Overrides, entrants
from frictionloop.findings import Result, shown
from frictionloop.findings.result import Row, Table, Tables, frame, plain
from frictionloop.findings.shown import between
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import System
from frictionloop.physics.fingers import Fingers
from frictionloop.preview.pattern_arrival import delivered_to, spread_n
from frictionloop.preview.prepared_stroke import playable_forces, prepared
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_setpoint import EffectSource
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
    people = trial_protocol.population(system, count, seed)
    some = trial_protocol.able(system, people, speed_mm_s)
    if not some.any():
        forces = f"{trial_protocol.LOW_N:g} and {trial_protocol.HIGH_N:g} N at {speed_mm_s:g} mm/s"
        raise FrictionloopError(f"fingers = {count}: none reaches {forces}")
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


def _designed(entrant: Entrant, system: System, spare: bool) -> Overrides | None:
    """Return what a law changes; None if it cannot run on this bench and is spared."""
    try:
        changes = entrant(system)
        system.evolve(changes)
    except FrictionloopError:
        if not spare:
            raise
        return None
    return changes


ALREADY = "setpoint"
"""What the effect is called that a system has as its set-point."""
HEADS = {
    "contrast": ("arrives, %", 100.0),
    "rms_error_n": ("error, mN", 1e3),
    "error_felt": ("felt", 1.0),
    "pattern_felt": ("pattern", 1.0),
    "spread_n": ("between, mN", 1e3),
}
"""Medians of the first table, their heads and factors."""
SPREAD = {
    "contrast_low": ("arrives, % low", 100.0),
    "contrast_high": ("high", 100.0),
    "rms_error_n_worst": ("error, mN worst", 1e3),
    "error_felt_worst": ("felt worst", 1.0),
    "fingers": ("fingers", 1.0),
}
"""Deciles of the second."""


class EffectComparison(Result, schema="compare.effects/1", without="cells"):
    """How much of effects arrives under control laws, on the capable of some fingers."""

    system: System
    effects: Mapping[str, Effect]
    fingers: int
    seed: int
    cells: Mapping[Key, Cell]
    """By law, effect and speed in mm/s, as `arrived` has them."""

    @property
    def scores(self) -> list[dict[str, Any]]:
        """A row for each law, effect and speed."""
        return [{"law": law, "effect": name, "speed_mm_s": v} | cell for (law, name, v), cell in self.cells.items()]

    def best(self, effect: str) -> str:
        """Return the law under which the slope of what arrives is nearest to 1 at its worst speed."""
        worst: dict[str, float] = {}
        for (law, name, _), cell in self.cells.items():
            if name == effect:
                worst[law] = max(worst.get(law, 0.0), abs(cell["contrast"] - 1.0))
        return min(worst, key=lambda law: worst[law])

    def rows(self) -> list[Row]:
        """Return the best law of each effect, and how many fingers are capable."""
        found = []
        for name in list(self.effects)[:4]:
            law = self.best(name)
            ways = [100.0 * cell["contrast"] for (own, of, _), cell in self.cells.items() if (own, of) == (law, name)]
            found.append((name, f"{law}: {between(min(ways), max(ways), '%')} arrives"))
        speeds = {v: int(cell["fingers"]) for (_, _, v), cell in self.cells.items()}
        able = ", ".join(map(str, speeds.values()))
        return [*found, ("capable", f"{able} of {self.fingers} fingers at {', '.join(map(shown, speeds))} mm/s")]

    def tables(self) -> Tables:
        """Return medians over the capable fingers, and deciles."""
        return {"effects": self._table(HEADS), "deciles": self._table(SPREAD)}

    def _table(self, heads: Mapping[str, tuple[str, float]]) -> Table:
        rows = [
            {"law": row["law"], "effect": row["effect"], "mm/s": row["speed_mm_s"]}
            | {head: factor * row[name] for name, (head, factor) in heads.items()}
            for row in self.scores
        ]
        return frame(rows, "law")

    def tidy(self) -> Table:
        """Return `scores` as a table."""
        import pandas as pd  # type: ignore[import-untyped]

        return pd.DataFrame(self.scores)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name."""
        return super().to_dict() | plain({"scores": self.scores})


def compare_effects(
    system: System,
    effects: Mapping[str, Effect] | Sequence[str] | None = None,
    laws: Iterable[str] | Mapping[str, Entrant] | None = None,
    count: int = trial_protocol.SMALL,
    seed: int = trial_protocol.EVALUATION_SEED,
    speeds_mm_s: Sequence[float] = trial_protocol.SPEEDS_MM_S,
    *,
    given: Collection[str] = (),
    kept: MutableMapping[Key, Cell] | None = None,
    save: Callable[[], Any] = lambda: None,
    progress: bool | None = None,
) -> EffectComparison:
    """Return how much of effects arrives under control laws, on fingers that none was tuned on.

    Parameters
    ----------
    system
        The bench.
    effects
        Effects by name, or names of the library and of TOML files; None: that which is the set-point.
    laws, count, seed, speeds_mm_s, given
        As of `compare`; without ``laws``, all that can run on this bench and need not know a set-point ahead.
    kept
        Cells that are there already; new ones are added.
    save
        Called after each cell.
    progress
        As of `sweep`.

    Raises
    ------
    FrictionloopError
        As `compare` and `arrived`, and for a set-point that is no effect where none is named.
    """
    trial_protocol.check_free(each for each in given if not each.startswith("setpoint.") or effects is not None)
    if effects is None:
        if not isinstance(system.setpoint, EffectSource):
            raise must_be("setpoint.kind", system.setpoint.kind, '"effect" without named effects')
        effects = {ALREADY: system.setpoint.effect}
    named = dict(effects) if isinstance(effects, Mapping) else {name: find(name) for name in effects}
    fields, found = entrants(laws), {} if kept is None else kept
    trial_protocol.population(system, count, seed)
    speeds = trial_protocol.speeds_of(system, speeds_mm_s)
    for effect, speed in itertools.product(named.values(), speeds):
        playable_forces(prepared(effect, system, speed))
    with progress_bar("effects", len(fields) * len(named) * len(speeds), progress) as bar:
        for law, entrant in fields.items():
            left = [(name, speed) for name in named for speed in speeds if (law, name, speed) not in found]
            bar.doing(f"designing {law}")
            changes = _designed(entrant, system, spare=laws is None) if left else None
            for name, speed in itertools.product(named, speeds):
                if changes is not None and (name, speed) in left:
                    bar.doing(f"{law}, {name} at {speed:g} mm/s")
                    found[law, name, speed] = arrived(system, named[name], changes, speed, count, seed)
                    save()
                bar()
    return EffectComparison(system=system, effects=named, fingers=count, seed=seed, cells=dict(found))
