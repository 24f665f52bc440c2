"""The targets of the benchmark as data: a ratio of two measured times, and what it should be."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from contenders import C_ENDS, C_JUMP, C_LANES, OURS, C


@dataclass(frozen=True)
class Target:
    """`value` is a ratio or seconds; it should be at most (or at least) `limit`."""

    what: str
    value: float
    limit: float | None
    at_least: bool = False
    unit: str = "x"

    @property
    def met(self) -> bool | None:
        if self.limit is None:
            return None
        return self.value >= self.limit if self.at_least else self.value <= self.limit

    def row(self) -> dict[str, Any]:
        return asdict(self) | {"met": self.met}


def of(best: dict[str, dict[str, float]], threads: int) -> Iterator[Target]:
    """Targets that the measured sections allow; `best` holds seconds by section and contender."""
    yield from _one(best.get("one run", {}))
    yield from _grid(best.get("grid", {}), f"{threads} thread{'s' * (threads > 1)}")
    for name, seconds in best.get("population", {}).items():
        yield Target(f"{name} x 10 s on the bench", seconds, 5.0, unit="s")
    for name, seconds in best.get("bench", {}).items():
        if name == "+ jitter, lost ticks":
            yield Target("the bench with all blocks, million periods/s", 256 * 0.05 / seconds, 10.0, at_least=True)
    effect = list(best.get("effect", {}).values())
    if effect:
        yield Target("a bench period with an effect of 2,048 points / without", effect[1] / effect[0], 1.15)
    for command, seconds in best.get("cold", {}).items():
        yield Target(f"{command}, empty cache", seconds, 6.0 if command.endswith("paper") else 15.0, unit="s")
    for command, seconds in best.get("start-up", {}).items():
        yield Target(f"{command}, fresh process", seconds, 0.5 if command.endswith("--help") else 2.0, unit="s")


def _one(one: dict[str, float]) -> Iterator[Target]:
    mine = one.get(OURS)
    if mine is None:
        return
    yield Target("one run with traces / C, same straight-line loop", mine / one[C], 1.6)
    yield Target("one run with traces / C with a branch on the clamp", mine / one[C_JUMP], None)
    for peer, seconds in one.items():
        asked = any(name in peer for name in ("python-control", "SciPy", "Drake"))
        if peer not in (OURS, C, C_JUMP):
            yield Target(f"one run: {peer} / {OURS}", seconds / mine, 300.0 if asked else None, at_least=True)


def _grid(grid: dict[str, float], all_threads: str) -> Iterator[Target]:
    mine = grid.get(f"{OURS}, {all_threads}")
    if mine is None:
        return
    for threads in ("1 thread", all_threads) if all_threads != "1 thread" else ("1 thread",):
        # The limit was set against C that takes six nodes, as frictionloop then did.
        for other, limit in ((C, 1.3), (C_LANES, None), (C_ENDS, None)):
            yield Target(f"grid, {threads} / {other}", grid[f"{OURS}, {threads}"] / grid[f"{other}, {threads}"], limit)
    for kind in ("common", "1024 seeds"):
        noisy = grid[f"{OURS}, noise, {kind}, {all_threads}"]
        yield Target(f"grid with noise ({kind}) / without", noisy / mine, 1.2)
        yield Target(
            f"grid with noise ({kind}) / C with noise", noisy / grid[f"{C}, noise, {kind}, {all_threads}"], None
        )
    seeds = f"noise, 1024 seeds, {all_threads}"
    yield Target(
        f"grid with noise (1024 seeds) / {C_LANES}", grid[f"{OURS}, {seeds}"] / grid[f"{C_LANES}, {seeds}"], None
    )
    for peer, limit in (
        (f"JAX vmap, 10 substeps, {all_threads}", 5.0),
        (f"JAX vmap, {all_threads}", None),
        ("NumPy batch, 10 substeps, 1 thread", 20.0),
        ("NumPy batch, 1 thread", None),
    ):
        if peer in grid and not (limit is None and all_threads == "1 thread"):
            yield Target(f"grid: {peer} / {OURS}, {all_threads}", grid[peer] / mine, limit, at_least=True)
