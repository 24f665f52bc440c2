"""From a project file to the System of a bench: measured values in place of the preset's, the rest assumed."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from frictionloop.findings import Finding
from frictionloop.findings.catalogue import Severity
from frictionloop.identification.estimate import Estimate, Measured
from frictionloop.identification.finger_population import TAU, together
from frictionloop.identification.identified_bench import BELIEVED, Bench, source_of
from frictionloop.identification.noise_density import dynamic_range_db
from frictionloop.identification.project_analysis import Work, analysed_entries, results_of
from frictionloop.identification.project_entry_result import EntryResult, Sensor
from frictionloop.identification.project_file import Project, read_project
from frictionloop.parameters import ResonantPlate, System, preset
from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.quantities.whole_files import json_of

APART = 3.0
"""Two methods contradict each other where they are so many standard errors apart (assumed)."""

HAMMER = 0.05
"""Relative standard error of a hammer's scale (assumed: data sheets say 2 to 10 %)."""
SPREAD = "controller.model.gain_spread"
LEAST_SPREAD = 1.1
"""Loop gain over the believed one that is left to a finger however well it was measured (assumed: it moistens)."""
LEAST_CORNER = 0.005
"""Share by which a design should let the resonance be off, however well it was measured (assumed: it warms)."""


def bench(
    path: str | os.PathLike[str],
    kept: Mapping[str, Any] | str | os.PathLike[str] | None = None,
    *,
    again: bool = False,
    without_refused: bool = False,
) -> Bench:
    """Return the bench that a project file's recordings describe.

    Parameters
    ----------
    path : path
        Project file (`Project` lists its fields).
    kept : mapping or path, optional
        Results of an earlier time (`Bench.entry_results`), or a JSON file of them, which is written anew: an entry
        whose files and settings are unchanged is not analysed again.
    again : bool
        Whether to analyse everything anew; the file is written all the same.
    without_refused : bool
        Whether to go on without the entries whose files or analyses are refused, and say which.

    Raises
    ------
    FrictionloopError
        For what the project file, a recording or an analysis refuses, in one line.
    """
    project, folder = read_project(path), Path(path).parent
    preset(project.preset).evolve(dict(project.known))  # refuses an unknown name before anything is computed
    file = kept if isinstance(kept, (str, os.PathLike)) else None
    earlier = _read(file) if file is not None else dict(kept or {})  # type: ignore[arg-type]
    work = analysed_entries(project, folder, {} if again else earlier)
    if file is not None and work.parts:
        with replacing(file) as beside:
            beside.write_text(json.dumps(results_of(work.parts), default=str), encoding="utf-8")
    if work.refused and not (without_refused and work.parts):
        raise work.refusal()
    return _bench(project, Path(path), work)


def _read(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Return the results of the last time, none if there are none that can be read."""
    with suppress(FrictionloopError):
        found = json_of(path)
        if isinstance(found, dict):
            return found
    return {}


def _bench(project: Project, path: Path, work: Work) -> Bench:
    parts, sensor = work.parts, work.sensor
    found, doubts = agreed([part for _, part in parts])
    doubts += _hammer_against_weights(found.get("sensitivity"), [part for _, part in parts])
    crowd, medians, few = together([part for _, part in parts])
    found |= {each.path: each for each in medians}
    overrides, stated = _stated(project, sensor)
    if "sensitivity" in found and sensor.unit == "counts":
        overrides["board.force_n_per_count"] = 1 / sensor.sensitivity
        overrides["board.force_zero_counts"] = [round(found["offset"].value), 0]
        for name in ("force_n_per_count", "force_zero_counts"):
            stated[f"board.{name}"] = "from the weights: " + source_of(found["sensitivity"])
    of_system = {name: each for name, each in found.items() if "." in name}
    for name, each in of_system.items():
        overrides[name] = _rounded(each)
        if name in BELIEVED:
            overrides[BELIEVED[name]] = overrides[name]
    if TAU in of_system:
        tau = of_system[TAU]
        overrides[SPREAD] = float(f"{max(tau.interval().high / tau.value, LEAST_SPREAD):.3g}")
        stated[SPREAD] = f"upper end over value, least {LEAST_SPREAD:g}"
    if "controller.model.plate_hz" in found and "plate.q" not in found:
        frequency = overrides.get("plate.frequency_hz", ResonantPlate().frequency_hz)
        overrides["plate.q"] = frequency / (2 * found["controller.model.plate_hz"].value)
        stated["plate.q"] = "from the envelope, f/(2 corner)"
    for _, part in parts:
        for name, value in part.curves.get("overrides", {}).items():
            overrides[name] = tuple(value) if isinstance(value, list) else value
            stated[name] = f"from the {part.kind} recordings ({part.files[0]['path']})"
    system = preset(project.preset).evolve(overrides)
    resonance = found.get("sensor.resonance_hz")
    corner = None
    if resonance is not None:
        corner = max((resonance.interval().high - resonance.value) / resonance.value, LEAST_CORNER)
    every = tuple(part for _, part in parts)
    return Bench(
        system=system,
        parts=every,
        measured=found,
        stated=stated,
        resonance_error=corner,
        project=path,
        keys=tuple(key for key, _ in parts),
        analysed=work.analysed,
        people=crowd,
        range_db=_range_db(system, every) if "sensor.range_n" in stated else None,
        refused=work.refused,
        findings=(*work.findings(), *doubts, *few, *(each for part in every for each in part.findings)),
    )


def _hammer_against_weights(slope: Measured | None, parts: Sequence[EntryResult]) -> list[Finding]:
    """Return that a hammer gives another sensitivity than the weights; its own scale is in it."""
    told = []
    for part in parts:
        gain = part.numbers.get("response_gain")
        if slope is None or gain is None or gain["unit"] != slope.unit:
            continue
        error = math.hypot(gain["standard_error"], HAMMER * gain["value"])
        told.append(_differ(slope, gain["value"], error, part.files[0]["path"]))
    return [each for each in told if each.severity == "warning"]


def _differ(best: Measured, value: float, error: float, file: str) -> Finding:
    """Return how far another value is from the best one: a warning beyond three standard errors."""
    apart = abs(value - best.value) / max(math.hypot(error, best.error), 1e-300)
    more = {"path": best.path, "apart": apart, "other": file, "errors": [best.error, error]}
    severity: Severity = "warning" if apart > APART else "note"
    return Finding("METHODS-DIFFER", severity, best.value, best.unit, value, more=more)


def _rounded(each: Measured) -> float:
    """Return a value to a hundredth of its standard error."""
    if each.value == 0:
        return 0.0
    digits = round(math.log10(abs(each.value) / max(each.error, 1e-12 * abs(each.value)))) + 3
    return float(f"{each.value:.{max(digits, 3)}g}")


def _stated(project: Project, sensor: Sensor) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the values that the project file states, and from what."""
    overrides: dict[str, Any] = dict(project.known)
    said = dict.fromkeys(project.known, "stated in the project file")
    if project.converter is not None:
        bits, full = project.converter.bits, project.converter.full_scale
        overrides |= {"sensor.adc_bits": bits, "sensor.range_n": abs(full / sensor.sensitivity)}
        said["sensor.adc_bits"] = "stated in the project file"
        range_n = Estimate(overrides["sensor.range_n"], overrides["sensor.range_n"] * sensor.share, "N")
        said["sensor.range_n"] = f"{range_n}, stated: full scale {full:g} {sensor.unit} / sensitivity"
    return overrides, said


def _range_db(system: System, parts: Sequence[EntryResult]) -> float | None:
    """Return what the converter spans, by what is stated, over the noise of a recording; None without one."""
    sensor: Any = system.sensor
    floors = [part.curves["floor"] for part in parts if part.kind == "quiet" and "floor" in part.curves]
    if not floors or not floors[0]["rms_n"] > 0 or "range_n" not in type(sensor).model_fields:
        return None
    return dynamic_range_db(sensor.range_n, floors[0]["rms_n"])


def agreed(parts: Sequence[EntryResult]) -> tuple[dict[str, Measured], list[Finding]]:
    """Return one value of each name, that with the least error, and a finding for each other entry."""
    every: dict[str, list[Measured]] = {}
    for part in parts:
        for each in part.measured:
            every.setdefault(each.path, []).append(each)
    chosen = {path: min(values, key=lambda each: each.error) for path, values in every.items()}
    told = []
    # Fingers differ; that is no contradiction.
    several = len({part.curves["person"]["finger"] for part in parts if part.curves.get("person")}) > 1
    for path, values in every.items():
        if several and path.startswith("friction."):
            continue
        best = chosen[path]
        told += [_differ(best, each.value, each.error, each.files[0]) for each in values if each is not best]
    return chosen, told
