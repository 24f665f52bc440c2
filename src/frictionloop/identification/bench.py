"""From a project file to the System of a bench: measured values in place of the preset's, the rest assumed."""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from frictionloop.identification.agreement import Corner, agreed, corners_of, together
from frictionloop.identification.analyses import Part, Sensor, analyse
from frictionloop.identification.load import sha256
from frictionloop.identification.measured import Measured
from frictionloop.identification.people import People
from frictionloop.identification.project import Project, Take, read_project
from frictionloop.parameters import ResonantPlate, System, preset
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.version import package_version

ORDER = (
    *("weights", "hits", "quiet", "load", "position", "scale", "plate", "carrier", "delay", "slides", "amplitude"),
)
BELIEVED = {
    "sensor.resonance_hz": "controller.model.resonance_hz",
    "sensor.q": "controller.model.resonance_q",
    "sensor.cutoff_hz": "controller.model.sensor_hz",
    "friction.nominal_n": "controller.model.nominal_n",
    "friction.susceptibility_per_um2": "controller.model.susceptibility_per_um2",
    "plate.max_amplitude_um": "controller.model.max_amplitude_um",
}
"""What the controller believes follows what was measured."""
LEAST_CORNER = 0.005
"""Share by which a design should let the resonance be off, however well it was measured (assumed: it warms)."""


@dataclass(frozen=True)
class Bench:
    """A bench, and where its numbers come from."""

    system: System
    parts: tuple[Part, ...]
    measured: Mapping[str, Measured]
    """Values of the System that were measured, by dotted name."""
    stated: Mapping[str, str]
    """Values that the project file states, by dotted name, and from what."""
    resonance_error: float | None
    """Share by which the resonance may be off: the half width of its 95 % interval, at least 0.005."""
    project: Path
    keys: tuple[str, ...]
    """What each part depends on, as a hash."""
    analysed: int
    """Entries that were analysed; the others were unchanged since the last time."""
    people: People | None = None
    """The population of fingers, where slides of three or more were recorded."""
    told: tuple[str, ...] = ()
    """What entries say together: where two measured one value, and what fingers have in common."""

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Ends of the intervals at which gains have to hold."""
        return corners_of(self.measured, self.people)


def bench(path: str | os.PathLike[str], kept: Mapping[str, Any] | None = None) -> Bench:
    """Return the bench that a project file's recordings describe.

    Parameters
    ----------
    path : path
        Project file (`Project` lists its fields).
    kept : mapping, optional
        Results of an earlier time (`kept_results`): an entry whose files and settings are unchanged is not analysed
        again.

    Raises
    ------
    FrictionloopError
        For what the project file, a recording or an analysis refuses, in one line.
    """
    project, folder = read_project(path), Path(path).parent
    sensor, parts, analysed = Sensor(), [], 0
    for take in sorted(project.recording, key=lambda each: ORDER.index(each.kind)):
        key = _key(take, folder, sensor)
        earlier = (kept or {}).get(key)
        if earlier is None:
            part, analysed = analyse(take, folder, sensor), analysed + 1
        else:
            part = _part(earlier)
        parts.append((key, part))
        sensor = _knowing(sensor, part)
    found, told_together = agreed([part for _, part in parts])
    crowd, medians, said = together([part for _, part in parts])
    found |= {each.path: each for each in medians}
    overrides, stated = _stated(project, sensor)
    if "sensitivity" in found and sensor.unit == "counts":
        overrides["board.force_n_per_count"] = 1 / sensor.sensitivity
        overrides["board.force_zero_counts"] = [round(found["offset"].value), 0]
        for name in ("force_n_per_count", "force_zero_counts"):
            stated[f"board.{name}"] = "from the weights: " + _source(found["sensitivity"])
    of_system = {name: each for name, each in found.items() if "." in name}
    for name, each in of_system.items():
        overrides[name] = _rounded(each)
        if name in BELIEVED:
            overrides[BELIEVED[name]] = overrides[name]
    if "controller.model.plate_hz" in found and "plate.q" not in found:
        frequency = overrides.get("plate.frequency_hz", ResonantPlate().frequency_hz)
        overrides["plate.q"] = frequency / (2 * found["controller.model.plate_hz"].value)
        stated["plate.q"] = "from the corner of the envelope, f/(2 Q)"
    for _, part in parts:
        for name, value in part.curves.get("overrides", {}).items():
            overrides[name] = tuple(value) if isinstance(value, list) else value
            stated[name] = f"from the {part.kind} recordings ({part.files[0]['path']})"
    system = preset(project.preset).evolve(overrides)
    resonance = found.get("sensor.resonance_hz")
    corner = None
    if resonance is not None:
        corner = max((resonance.interval().high - resonance.value) / resonance.value, LEAST_CORNER)
    keys, told = (tuple(each) for each in zip(*parts, strict=True))
    together_told = (*told_together, *said)
    return Bench(system, told, found, stated, corner, Path(path), keys, analysed, crowd, together_told)


def kept_results(found: Bench) -> dict[str, Any]:
    """Return the results of a bench as plain data, to be handed to `bench` the next time."""
    return {key: asdict(part) for key, part in zip(found.keys, found.parts, strict=True)}


def to_toml(found: Bench) -> str:
    """Return the System as TOML text; a comment says whether a value is measured, stated, chosen or assumed."""
    import tomlkit

    from frictionloop.parameters import files

    document = tomlkit.parse(files.to_toml(found.system, every=False))
    said = {name: _source(each) for name, each in found.measured.items() if "." in name}
    said |= {BELIEVED[name]: f"as {name}" for name in said if name in BELIEVED}
    said |= dict(found.stated)
    _comment(document, "", said)
    head = [f"# Bench of {found.project.name}, by frictionloop {package_version()}."]
    head += [f"# {each['path']}: sha256 {each['sha256']}" for part in found.parts for each in part.files]
    if (line := found.measured.get("sensitivity")) is not None:
        head.append(f"# sensitivity of the reading: {line.estimate} ({_source(line)})")
    if found.resonance_error is not None:
        head.append(
            f"# gains for it: frictionloop design controller FILE --resonance-error {found.resonance_error:.3g}"
        )
    body = document.as_string().split("\n", 1)[1] if document.as_string().startswith("#") else document.as_string()
    return "\n".join(head) + "\n" + body


CHOSEN = ("setpoint.", "disturbance.", "controller.kp", "controller.ki", "motion.speed", "motion.stroke")


def _comment(table: Any, prefix: str, said: Mapping[str, str]) -> None:
    for key in list(table):
        item, name = table[key] if hasattr(table[key], "trivia") else table.item(key), f"{prefix}{key}"
        if hasattr(item, "keys"):
            _comment(item, f"{name}.", said)
        elif name not in ("schema",) and key != "kind":
            old = item.trivia.comment.lstrip("# ")
            word = said.get(name) or ("chosen" if name.startswith(CHOSEN) else "assumed") + (f"; {old}" if old else "")
            unit = old.partition(":")[0] if name in said and ":" in old and len(old.partition(":")[0]) < 8 else ""
            item.comment(f"{unit}: {word}" if unit else word)
            item.trivia.comment_ws = "  "


def _rounded(each: Measured) -> float:
    """Return a value to a hundredth of its standard error."""
    if each.value == 0:
        return 0.0
    return float(
        f"{each.value:.{max(round(math.log10(abs(each.value) / max(each.error, 1e-12 * abs(each.value)))) + 3, 3)}g}"
    )


def _source(each: Measured) -> str:
    files = each.files[0] if len(each.files) == 1 else f"{each.files[0]} and {len(each.files) - 1} more"
    return f"measured, {each.estimate} (95 %); {files}; {each.how}; {each.date}"


def _stated(project: Project, sensor: Sensor) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the values that the project file states, and from what."""
    overrides: dict[str, Any] = dict(project.known)
    said = dict.fromkeys(project.known, "stated in the project file")
    if project.converter is not None:
        bits, full = project.converter.bits, project.converter.full_scale
        overrides |= {"sensor.adc_bits": bits, "sensor.range_n": abs(full / sensor.sensitivity)}
        said["sensor.adc_bits"] = "stated in the project file"
        said["sensor.range_n"] = f"full scale of {full:g} {sensor.unit}, stated, over the measured sensitivity"
    return overrides, said


def _knowing(sensor: Sensor, part: Part) -> Sensor:
    values = {each.path: each for each in part.measured}
    if (slope := values.get("sensitivity")) is not None:
        sensor = replace(sensor, sensitivity=slope.value, unit=slope.unit.partition("/")[0])
    if (hertz := values.get("sensor.resonance_hz")) is not None:
        sensor = replace(sensor, resonance_hz=hertz.value)
    if (cutoff := values.get("sensor.cutoff_hz")) is not None:
        sensor = replace(sensor, cutoff_hz=cutoff.value, cutoff_error_hz=cutoff.error)
    return sensor


def _key(take: Take, folder: Path, sensor: Sensor) -> str:
    """Return what an analysis depends on, as one hash: files, maps, settings, what is known, version."""
    files = [*take.files, *([take.map] if take.map else [])]
    try:
        prints = [sha256(folder / name) for name in files]
    except OSError as error:
        raise FrictionloopError(f"{take.kind}: {error.filename}: cannot be read ({error.strerror})") from None
    told = [
        prints,
        take.model_dump(),
        asdict(sensor) if take.kind in ("quiet", "slides", "load", "amplitude") else {},
        package_version(),
    ]
    return hashlib.sha256(json.dumps(told, sort_keys=True, default=str).encode()).hexdigest()


def _part(tree: Mapping[str, Any]) -> Part:
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
