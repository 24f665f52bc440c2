"""Control laws compared on effects, and which of them lets most of each arrive."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.effects import Cell, Key, effect_cells
from frictionloop.design.comparison.entrants import Entrant
from frictionloop.findings import Result, shown
from frictionloop.findings.result import Row, plain
from frictionloop.findings.shown import between
from frictionloop.parameters import System
from frictionloop.quantities import must_be
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.effect_toml import find
from frictionloop.rendering.source import EffectSource

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

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


@dataclass(frozen=True, kw_only=True)
class EffectComparison(Result):
    """How much of effects arrives under control laws, on the capable of some fingers."""

    SCHEMA: ClassVar[str] = "compare.effects/1"
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
        laws = {law: abs(cell["contrast"] - 1.0) for (law, name, _), cell in self.cells.items() if name == effect}
        for (law, name, _), cell in self.cells.items():
            if name == effect:
                laws[law] = max(laws[law], abs(cell["contrast"] - 1.0))
        return min(laws, key=lambda law: laws[law])

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

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return medians over the capable fingers, and deciles."""
        return {"effects": self._table(HEADS), "deciles": self._table(SPREAD)}

    def _table(self, heads: Mapping[str, tuple[str, float]]) -> pd.DataFrame:
        import pandas as pd

        rows = [
            {"law": row["law"], "effect": row["effect"], "mm/s": row["speed_mm_s"]}
            | {head: factor * row[name] for name, (head, factor) in heads.items()}
            for row in self.scores
        ]
        return pd.DataFrame(rows).set_index("law")

    def tidy(self) -> pd.DataFrame:
        """Return `scores` as a table."""
        import pandas as pd

        return pd.DataFrame(self.scores)

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name."""
        own = super().to_dict()
        del own["cells"]
        return own | plain({"scores": self.scores})


def compare_effects(
    system: System,
    effects: Mapping[str, Effect] | Sequence[str] | None = None,
    laws: Iterable[str] | Mapping[str, Entrant] | None = None,
    count: int = protocol.SMALL,
    seed: int = protocol.EVALUATION_SEED,
    speeds_mm_s: Sequence[float] = protocol.SPEEDS_MM_S,
    *,
    given: Collection[str] = (),
    progress: bool | None = None,
) -> EffectComparison:
    """Return how much of effects arrives under control laws, on fingers that none was tuned on.

    Parameters
    ----------
    system
        The bench.
    effects
        Effects by name, or names of the library and of TOML files; None: that which is the set-point.
    laws, count, seed, speeds_mm_s
        As of `compare`.
    given
        As of `compare`.
    progress
        As of `sweep`.

    Raises
    ------
    FrictionloopError
        As `compare` and `arrived`, and for a set-point that is no effect where none is named.
    """
    protocol.check_free(each for each in given if not each.startswith("setpoint.") or effects is not None)
    if effects is None:
        if not isinstance(system.setpoint, EffectSource):
            raise must_be("setpoint.kind", system.setpoint.kind, '"effect" where no effects are named')
        effects = {ALREADY: system.setpoint.effect}
    named = dict(effects) if isinstance(effects, Mapping) else {name: find(name) for name in effects}
    cells = effect_cells(system, named, laws, count, seed, speeds_mm_s, progress=progress)
    return EffectComparison(system=system, effects=named, fingers=count, seed=seed, cells=cells)
