"""The entries of a project, one after the other: what each told, which were refused, what is kept for the next time."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from frictionloop.findings import Condition, Finding
from frictionloop.findings.result import plain
from frictionloop.identification.analyses import analyse
from frictionloop.identification.measured import Measured
from frictionloop.identification.opened import sha256
from frictionloop.identification.part import Part, Sensor
from frictionloop.identification.project import Project, Take
from frictionloop.identification.refused import Refused
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.version import package_version

ORDER = (
    *("weights", "hits", "response", "quiet", "load", "position", "scale"),
    *("plate", "carrier", "delay", "slides", "amplitude"),
)

FORM = 2
"""Of what is kept: another one is not read."""
USE_SENSOR = ("quiet", "slides", "load", "amplitude")
"""Kinds whose analysis depends on what is known of the sensor."""


class RefusedEntry(NamedTuple):
    """An entry whose files or analysis were refused."""

    kind: str
    said: str
    """The line, which names the file."""


class Unfinished(Refused):
    """A bench of which some entries were refused; ``results`` are those of the others, to be handed on as ``kept``."""

    def __init__(self, said: str, kind: str, curves: Mapping[str, Any], results: Mapping[str, Any]) -> None:
        super().__init__(said, kind, curves)
        self.results = results


@dataclass
class Work:
    """What has been done of a project."""

    parts: list[tuple[str, Part]] = field(default_factory=list)
    """With what each depends on, as a hash."""
    sensor: Sensor = field(default_factory=Sensor)
    analysed: int = 0
    errors: list[tuple[str, FrictionloopError]] = field(default_factory=list)
    """Kinds of the entries that were refused, and how."""

    @property
    def refused(self) -> tuple[RefusedEntry, ...]:
        """Entries that were refused."""
        return tuple(RefusedEntry(kind, str(error)) for kind, error in self.errors)

    def findings(self) -> list[Finding]:
        """Return which entries were left out."""
        return [
            Finding("LEFT-OUT", "warning", where=Condition(recording=each.kind), more={"reason": each.said})
            for each in self.refused
        ]

    def refusal(self) -> FrictionloopError:
        """Return the refusals in one line; with the results of what was done, if anything was."""
        said = "; ".join(dict.fromkeys(str(error) for _, error in self.errors))
        first = next((error for _, error in self.errors if isinstance(error, Refused)), Refused("", "recording", {}))
        if not self.parts:
            return Refused(said, first.kind, first.curves)
        done = ", ".join(dict.fromkeys(part.kind for _, part in self.parts))
        return Unfinished(f"{said}; results kept: {done}", first.kind, first.curves, results_of(self.parts))


def analysed_entries(project: Project, folder: Path, kept: Mapping[str, Any]) -> Work:
    """Analyse the entries of a project in the order in which one needs the other; a refused one stops these alone."""
    work = Work()
    blind = False
    for take in sorted(project.recording, key=lambda each: ORDER.index(each.kind)):
        if blind and take.kind in USE_SENSOR:
            continue  # it would be analysed as if the reading were in newtons
        try:
            key = key_of(take, folder, work.sensor)
            if (earlier := kept.get(key)) is None:
                part = analyse(take, folder, work.sensor)
                work.analysed += 1
            else:
                part = part_of(earlier)
        except FrictionloopError as error:
            work.errors.append((take.kind, error))
            blind |= take.kind == "weights"
            continue
        work.parts.append((key, part))
        work.sensor = _knowing(work.sensor, part)
    return work


def _knowing(sensor: Sensor, part: Part) -> Sensor:
    values = {each.path: each for each in part.measured}
    if (slope := values.get("sensitivity")) is not None:
        sensor = replace(sensor, sensitivity=slope.value, unit=slope.unit.partition("/")[0])
    if (hertz := values.get("sensor.resonance_hz")) is not None:
        sensor = replace(sensor, resonance_hz=hertz.value)
    if (cutoff := values.get("sensor.cutoff_hz")) is not None:
        sensor = replace(sensor, cutoff_hz=cutoff.value, cutoff_error_hz=cutoff.error)
    return sensor


def results_of(parts: Sequence[tuple[str, Part]]) -> dict[str, Any]:
    """Return what entries told as plain data, by what each depends on."""
    return {key: plain({**part.to_dict(), "curves": part.curves}) for key, part in parts}


def key_of(take: Take, folder: Path, sensor: Sensor) -> str:
    """Return what an analysis depends on, as one hash: files, maps, settings, what is known, version."""
    files = [*take.files, *([take.map] if take.map else [])]
    try:
        prints = [sha256(folder / name) for name in files]
    except OSError as error:
        raise FrictionloopError(f"{take.kind}: {error.filename}: cannot be read ({error.strerror})") from None
    told = [prints, take.model_dump(), asdict(sensor) if take.kind in USE_SENSOR else {}, package_version(), FORM]
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


def part_of(tree: Mapping[str, Any]) -> Part:
    """Return an entry from its plain data."""
    return Part(
        tree["kind"],
        tuple(tree["files"]),
        tuple(Measured.from_dict(each) for each in tree["measured"]),
        tuple(map(Finding.from_dict, tree["findings"])),
        dict(tree["numbers"]),
        tuple(map(tuple, tree["rows"])),
        dict(tree["curves"]),
    )
