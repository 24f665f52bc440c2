"""Which lanes share a tile, and its systems: values that have been tried, placed without trying them again."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

from pydantic import BaseModel

from frictionloop.loop.kernel.slab import LANES
from frictionloop.parameters import System


def tiles_of(structures: Sequence[object], wanted: Iterable[int], seeds: int = 1) -> Iterator[list[int]]:
    """Yield the lane numbers of each tile: lanes of one structure, single lanes if few are left.

    ``structures`` has one entry for each ``seeds`` lanes.
    """
    groups: dict[object, list[int]] = {}
    for lane in wanted:
        groups.setdefault(structures[lane // seeds], []).append(lane)
    for lanes in groups.values():
        for start in range(0, len(lanes), LANES):
            part = lanes[start : start + LANES]
            # Up to two lanes cost less one by one than as a padded tile; the bits are the same.
            yield from [part] if len(part) > 2 else [[lane] for lane in part]


def placed(system: System, overrides: Sequence[Mapping[str, Any]]) -> list[System]:
    """Return ``system.evolve(override)`` for each, of values that have been tried: numbers are placed unchecked.

    Blocks that no path enters stay one object in all systems; an override given twice in a row is one system.
    """
    branches: dict[tuple[str, ...], dict[str, Any] | None] = {}
    systems: list[System] = []
    last: Mapping[str, Any] | None = None
    for override in overrides:
        if override is not last:
            values = system.resolved(override)
            paths = tuple(values)
            if paths not in branches:
                branches[paths] = None if any(path.endswith(".kind") for path in paths) else _branches(paths)
            places = branches[paths] if {int, float}.issuperset(map(type, values.values())) else None
            made = system.evolve(values) if places is None else _copied(system, places, values)
            last = override
        systems.append(made)
    return systems


def _branches(paths: Iterable[str]) -> dict[str, Any]:
    """Return the names in a block: each with the whole path of its value, or the names in the block that is there."""
    tree: dict[str, Any] = {}
    for path in paths:
        *parents, leaf = path.split(".")
        node = tree
        for name in parents:
            node = node.setdefault(name, {})
        node[leaf] = path
    return tree


def _copied(block: Any, places: Mapping[str, Any], values: Mapping[str, Any]) -> Any:
    changed = {
        name: values[place] if isinstance(place, str) else _copied(getattr(block, name), place, values)
        for name, place in places.items()
    }
    # As ``model_copy``, which takes half as long again: blocks are frozen, so that nothing of theirs needs a copy.
    made = object.__new__(type(block))
    object.__setattr__(made, "__dict__", {**block.__dict__, **changed})
    for name in BaseModel.__slots__[1:]:
        object.__setattr__(made, name, getattr(block, name))
    return made
