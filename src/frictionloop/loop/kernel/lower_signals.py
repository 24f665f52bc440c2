"""From sources to the kernel: formula rows for smooth signals, samplers for sampled ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from frictionloop.loop.kernel.columns import Slab
from frictionloop.loop.kernel.signals import FORMULAS
from frictionloop.parameters import ColouredNoise, Constant, LogSweep, Sine, Source, Steps
from frictionloop.physics.sources import Sampler, sampler, sweep_turns
from frictionloop.rendering.source import EffectSource

_HOW = {Constant: "sine", Sine: "sine", LogSweep: "log_sweep", Steps: "held"}
"""How signals are made; all others are linear between samples."""


class Signal(NamedTuple):
    """How the kernel makes a signal."""

    how: str
    """A formula of `FORMULAS` (signals), or how samples are taken: "linear" or "held"."""
    shared: bool
    """One column serves all lanes."""
    take: Sampler
    """(start, stop) -> samples of a chunk, [period][column], empty for a formula."""


def lower_signal(
    slab: Slab, rows: str, sources: Sequence[Source], seeds: np.ndarray, stream: int, rate_hz: float, nodes_alike: bool
) -> Signal:
    """Set the formula rows of a signal, one source per lane; ``nodes_alike`` says that lanes may share it."""
    first = sources[0]
    if isinstance(first, EffectSource):  # made tick by tick (loop/kernel/effect_tile)
        return Signal("effect", False, lambda start, stop: np.zeros(0))
    alike = all(s is first or s == first for s in sources)
    slab.view(rows)[:] = np.array([_formula(s) for s in (sources[:1] if alike else sources)]).T
    drawn = isinstance(first, ColouredNoise) and bool(np.any(seeds != seeds[0]))
    shared = nodes_alike and alike and not drawn
    how = _HOW.get(type(first), "linear")
    sampled = [] if how in FORMULAS else sources[: 1 if shared else len(sources)]
    takes = [sampler(s, rate_hz, int(seed), stream) for s, seed in zip(sampled, seeds, strict=False)]

    def take(start: int, stop: int) -> np.ndarray:
        return np.ascontiguousarray(np.array([one(start, stop) for one in takes if one]).T).ravel()

    return Signal(how, shared, take)


def _formula(source: Source) -> tuple[float, float, float, float]:
    if isinstance(source, Sine):
        return source.offset_n, source.amplitude_n, source.frequency_hz, 0.0
    if isinstance(source, LogSweep):
        return source.offset_n, source.amplitude_n, *sweep_turns(source)
    return getattr(source, "offset_n", 0.0), 0.0, 0.0, 0.0
