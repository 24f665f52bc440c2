"""The entries of a project, one after the other: what each told, and which were refused."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

from frictionloop.identification.analyses import analyse
from frictionloop.identification.kept import USE_SENSOR, key_of, part_of
from frictionloop.identification.parts.part import Part, Sensor
from frictionloop.identification.project import Project
from frictionloop.identification.refused import Refused
from frictionloop.quantities import FrictionloopError

ORDER = (
    *("weights", "hits", "response", "quiet", "load", "position", "scale"),
    *("plate", "carrier", "delay", "slides", "amplitude"),
)


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

    def told(self) -> list[str]:
        """Return what was left out, in words."""
        return [f"{each.kind} left out: {each.said}" for each in self.refused]

    def refusal(self) -> FrictionloopError:
        """Return the refusals in one line; with the results of what was done, if anything was."""
        said = "; ".join(dict.fromkeys(str(error) for _, error in self.errors))
        first = next((error for _, error in self.errors if isinstance(error, Refused)), Refused("", "recording", {}))
        if not self.parts:
            return Refused(said, first.kind, first.curves)
        done = ", ".join(dict.fromkeys(part.kind for _, part in self.parts))
        results = {key: asdict(part) for key, part in self.parts}
        return Unfinished(f"{said}; results of {done} are kept, no bench is written", first.kind, first.curves, results)


def analysed_entries(project: Project, folder: Path, kept: Mapping[str, Any]) -> Work:
    """Analyse the entries of a project in the order in which one needs the other; a refused one stops none but these.

    Parameters
    ----------
    project, folder
        The project, and where its paths begin.
    kept : mapping
        Results of an earlier time, by what they depend on.
    """
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
