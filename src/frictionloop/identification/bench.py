"""From a project file to the System of a bench: measured values in place of the preset's, the rest assumed."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from frictionloop.analysis import operating_band
from frictionloop.analysis.linear import LinearLoop
from frictionloop.identification.agreement import Corner, agreed, corners_of, together
from frictionloop.identification.bench_file import BELIEVED, source_of
from frictionloop.identification.entries import RefusedEntry, Work, analysed_entries
from frictionloop.identification.figures_of_merit import dynamic_range_db
from frictionloop.identification.measured import Measured
from frictionloop.identification.parts.part import Part, Sensor
from frictionloop.identification.people import People
from frictionloop.identification.project import Project, read_project
from frictionloop.parameters import ResonantPlate, System, preset

DESIGNED = {"sensor": "sensor.cutoff_hz", "delay": "controller.delay_s", "gain": "sensitivity"}
"""Values whose intervals a design holds, by its flag."""
TAU, SPREAD = "friction.susceptibility_per_um2", "controller.model.gain_spread"
LEAST_SPREAD = 1.1
"""Loop gain over the believed one that is left to a finger however well it was measured (assumed: it moistens)."""
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
    """What entries say together: where two measured one value, what fingers have in common, the dynamic range."""
    refused: tuple[RefusedEntry, ...] = ()
    """Entries that were left out because their files or analyses were refused."""

    @property
    def design_flags(self) -> str:
        """What ``frictionloop design controller`` should hold, by its flags: half widths of the intervals."""
        shares = {"resonance": self.resonance_error} | {
            flag: (each.interval().high - each.value) / abs(each.value)
            for flag, path in DESIGNED.items()
            if (each := self.measured.get(path)) is not None and each.value
        }
        return " ".join(f"--{flag}-error {share:.3g}" for flag, share in shares.items() if share is not None)

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Ends of the intervals at which gains have to hold."""
        return corners_of(self.measured, self.people)

    @property
    def loops(self) -> list[LinearLoop]:
        """The loops at which gains have to hold, for `retune`: as measured, and at each corner, dry and moist."""
        benches = [self.system, *(self.system.evolve({each.path: each.value}) for each in self.corners)]
        return [loop for each in benches for loop in operating_band(each, occluded=(0.0, 1.0))]


def bench(
    path: str | os.PathLike[str], kept: Mapping[str, Any] | None = None, *, without_refused: bool = False
) -> Bench:
    """Return the bench that a project file's recordings describe.

    Parameters
    ----------
    path : path
        Project file (`Project` lists its fields).
    kept : mapping, optional
        Results of an earlier time (`kept_results`): an entry whose files and settings are unchanged is not analysed
        again.
    without_refused : bool
        Whether to go on without the entries whose files or analyses are refused; what they say is then told.

    Raises
    ------
    FrictionloopError
        For what the project file, a recording or an analysis refuses, in one line. `Unfinished` keeps the results of
        the other entries.
    """
    project, folder = read_project(path), Path(path).parent
    preset(project.preset).evolve(dict(project.known))  # refuses an unknown name before anything is computed
    work = analysed_entries(project, folder, kept or {})
    if work.refused and not (without_refused and work.parts):
        raise work.refusal()
    return _bench(project, Path(path), work)


def _bench(project: Project, path: Path, work: Work) -> Bench:
    parts, sensor = work.parts, work.sensor
    found, told_together = agreed([part for _, part in parts])
    crowd, medians, said = together([part for _, part in parts])
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
        stated[SPREAD] = f"upper end of {TAU} over its value, at least {LEAST_SPREAD:g}"
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
    together_told = (*told_together, *said, *(_range(system, told) if "sensor.range_n" in stated else ()), *work.told())
    return Bench(system, told, found, stated, corner, path, keys, work.analysed, crowd, together_told, work.refused)


def _rounded(each: Measured) -> float:
    """Return a value to a hundredth of its standard error."""
    if each.value == 0:
        return 0.0
    return float(
        f"{each.value:.{max(round(math.log10(abs(each.value) / max(each.error, 1e-12 * abs(each.value)))) + 3, 3)}g}"
    )


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


def _range(system: System, parts: Sequence[Part]) -> list[str]:
    """Return the dynamic range in words: what the converter spans, by what is stated, over the noise of a recording."""
    sensor: Any = system.sensor
    floors = [part.curves["floor"] for part in parts if part.kind == "quiet" and "floor" in part.curves]
    if not floors or not floors[0]["rms_n"] > 0 or "range_n" not in type(sensor).model_fields:
        return []
    rms, span = floors[0]["rms_n"], sensor.range_n
    decibels = dynamic_range_db(span, rms)
    return [f"dynamic range {decibels:.1f} dB: {span:.4g} N over {rms:.3g} N rms, {floors[0]['band']}"]
