"""Results kept from one time to the next: what has not changed is not analysed twice."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.identification.measured import Measured
from frictionloop.identification.opened import sha256
from frictionloop.identification.parts.part import Part, Sensor
from frictionloop.identification.project import Take
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.version import package_version

if TYPE_CHECKING:
    from frictionloop.identification.bench import Bench


USE_SENSOR = ("quiet", "slides", "load", "amplitude")
"""Kinds whose analysis depends on what is known of the sensor."""


def kept_results(found: Bench) -> dict[str, Any]:
    """Return the results of a bench as plain data, to be handed to `bench` the next time."""
    return {key: asdict(part) for key, part in zip(found.keys, found.parts, strict=True)}


def key_of(take: Take, folder: Path, sensor: Sensor) -> str:
    """Return what an analysis depends on, as one hash: files, maps, settings, what is known, version."""
    files = [*take.files, *([take.map] if take.map else [])]
    try:
        prints = [sha256(folder / name) for name in files]
    except OSError as error:
        raise FrictionloopError(f"{take.kind}: {error.filename}: cannot be read ({error.strerror})") from None
    told = [prints, take.model_dump(), asdict(sensor) if take.kind in USE_SENSOR else {}, package_version()]
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


def part_of(tree: Mapping[str, Any]) -> Part:
    """Return an entry from its plain data."""
    values = [
        {**each, "freedom": math.inf if each["freedom"] is None else each["freedom"]} for each in tree["measured"]
    ]
    return Part(
        tree["kind"],
        tuple(tree["files"]),
        tuple(Measured(**each | {"files": tuple(each["files"])}) for each in values),
        tuple(tree["told"]),
        tuple(map(tuple, tree["rows"])),
        dict(tree["curves"]),
    )
