"""What each choice of a page without a server changes of the numbers of its loops.

Python lowers each choice once, at build, and the page puts numbers in place of others: a loop's numbers are those of
the base, then of its effect, its finger, its law, and of each slider's stop. That they are those of the whole System is
checked for combinations drawn at random; a page for which they are not is not built.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from frictionloop.loop.kernel.tile_record import PROGRAMS, SCRATCH
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.tiles_in_c import LoopInC
from frictionloop.parameters import System
from frictionloop.physics.roughness import roughness_shape
from frictionloop.quantities import FrictionloopError

MOST = 128
"""Periods of one call at most."""
TRIED = 40
"""Combinations of choices that are lowered whole, and compared."""
_FILLED = ("trace", "path", "setpoint_samples", "disturbance_samples")
"""What the page has a room of its own for."""
Words = dict[str, np.ndarray]
"""All numbers of a loop by the array that they are in, as words of 64 bits."""


class Axis(NamedTuple):
    """Choices of which one is in force, and the numbers that tell them apart."""

    choices: tuple[Any, ...]
    """Names, or the values of a slider."""
    places: dict[str, np.ndarray | None]
    """Where in each array; None where all of it is another."""
    words: tuple[Words, ...]
    """What stands there, for each choice."""


class PageBench:
    """The loop of a System as C, and the numbers of the Systems around it."""

    def __init__(self, system: System, seed: int) -> None:
        self.system, self.seed, self.loop = system, seed, LoopInC()
        self.shape, self.shape_rms = roughness_shape(seed)
        self.base = self.words(system)

    def words(self, system: System) -> Words:
        """Return all numbers of a System under a finger that is moved: no addresses, and of its roughness the scale."""
        traces = np.zeros(len(traces_of(system)) * MOST)
        tile = self.loop.lower(system, self.seed, traces=traces, guided=True)
        if tile.setpoint(0, 1).size or tile.disturbance(0, 1).size:
            raise FrictionloopError("setpoint, disturbance: must need no samples", "NO-C")
        record = tile.shared.record.copy()
        for name in (*SCRATCH, *PROGRAMS):
            record[name] = 0
        found = {"slab": tile.slab.data, "record": record, **tile.shared.kept}
        scale = np.array([getattr(system.friction, "roughness_rms", 0.0) / self.shape_rms])
        if not np.array_equal(scale * self.shape, found.pop("roughness")):
            raise FrictionloopError("motion.person: must be 0", "STUDIO-NO-SUM")
        found["scale"] = scale
        return {name: np.frombuffer(each.tobytes(), np.uint64) for name, each in found.items() if name not in _FILLED}

    def axis(self, of: System, choices: Mapping[Any, Mapping[str, Any]]) -> Axis:
        """Lower each choice by itself, beside a System that has none of them."""
        before, made = self.words(of), [self.words(of.evolve(values)) for values in choices.values()]
        places: dict[str, np.ndarray | None] = {}
        for name, words in before.items():
            if any(len(each[name]) != len(words) for each in made):
                places[name] = None
            elif (differs := np.any([each[name] != words for each in made], axis=0)).any():
                places[name] = np.flatnonzero(differs)
        taken = [{name: each[name] if at is None else each[name][at] for name, at in places.items()} for each in made]
        return Axis(tuple(choices), places, tuple(taken))

    def put(self, chosen: Sequence[tuple[Axis, int]]) -> Words:
        """Return the base with choices over it, one after the other, as the page does."""
        found = {name: words.copy() for name, words in self.base.items()}
        for axis, index in chosen:
            for name, at in axis.places.items():
                if at is None:
                    found[name] = axis.words[index][name]
                else:
                    found[name][at] = axis.words[index][name]
        return found


class Choices(NamedTuple):
    """What can be chosen on a page, each by overrides of its System."""

    laws: Mapping[str, Mapping[str, Any]]
    effects: Mapping[str, Mapping[str, Any]]
    fingers: Mapping[str, Mapping[str, Any]]
    stops: Mapping[str, Sequence[float]]
    """Values of a slider by its path."""
    gains: Mapping[str, Mapping[str, Sequence[float]]]
    """Sliders that a law has of its own."""


class Axes(NamedTuple):
    """The choices, lowered."""

    laws: Axis
    effects: Axis
    fingers: Axis
    stops: dict[str, Axis]
    gains: dict[str, dict[str, Axis]]


def axes_of(bench: PageBench, choices: Choices) -> Axes:
    """Lower all choices of a page.

    Raises
    ------
    FrictionloopError
        STUDIO-NO-SUM where choices do not add up to the System that has all of them; NO-C for what has no C.
    """

    def sliders(of: System, stops: Mapping[str, Sequence[float]]) -> dict[str, Axis]:
        return {path: bench.axis(of, {value: {path: value} for value in values}) for path, values in stops.items()}

    base = bench.system
    found = Axes(
        bench.axis(base, choices.laws),
        bench.axis(base, choices.effects),
        bench.axis(base, choices.fingers),
        sliders(base, choices.stops),
        {law: sliders(base.evolve(choices.laws[law]), stops) for law, stops in choices.gains.items()},
    )
    rng = np.random.default_rng(0)
    for _ in range(TRIED):
        _check_sum(bench, choices, found, rng)
    return found


def _check_sum(bench: PageBench, choices: Choices, axes: Axes, rng: np.random.Generator) -> None:
    """Draw one of each choice, and compare what they add up to with the whole System."""
    chosen: list[tuple[Axis, int]] = []
    system, law = bench.system, ""
    for axis, values in ((axes.effects, choices.effects), (axes.fingers, choices.fingers), (axes.laws, choices.laws)):
        if not values:
            continue
        index = int(rng.integers(len(axis.choices)))
        chosen.append((axis, index))
        law = axis.choices[index]
        system = system.evolve(values[law])
    for path, axis in (axes.stops | axes.gains.get(law, {})).items():
        if rng.random() < 0.5:
            index = int(rng.integers(len(axis.choices)))
            chosen.append((axis, index))
            system = system.evolve({path: axis.choices[index]})
    whole, added = bench.words(system), bench.put(chosen)
    if wrong := [name for name in whole if not np.array_equal(whole[name], added[name])]:
        places = np.flatnonzero(whole[wrong[0]] != added[wrong[0]])[:8] if wrong[0] != "effect" else ""
        taken = ", ".join(str(axis.choices[index]) for axis, index in chosen)
        raise FrictionloopError(f"{taken}: {wrong[0]} {places}: choices do not add up", "STUDIO-NO-SUM")
