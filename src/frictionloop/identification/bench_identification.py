"""From a project file to the System of a bench: measured values in place of the preset's, the rest assumed."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from frictionloop.analysis import operating_band
from frictionloop.analysis.linear import LinearLoop
from frictionloop.findings import Result
from frictionloop.findings.result import Row, plain
from frictionloop.identification import bench_file
from frictionloop.identification.agreement import LOOP, Corner, agreed, corners_of, together
from frictionloop.identification.entries import RefusedEntry, Work, analysed_entries, results_of
from frictionloop.identification.figures_of_merit import dynamic_range_db
from frictionloop.identification.measured import Measured
from frictionloop.identification.part import Part, Sensor, number_said
from frictionloop.identification.people import LEAST_FINGERS, People
from frictionloop.identification.project import Project, read_project
from frictionloop.parameters import ResonantPlate, System, preset
from frictionloop.parameters.refusals import known_names
from frictionloop.quantities import must_be, replacing, unit_of

if TYPE_CHECKING:
    import pandas as pd  # type: ignore[import-untyped]

MOST = 12
"""Values in the table that belongs to the answer."""
ASSUMED = ("friction.", "plate.", "sensor.", "finger.", "controller.delay_s", "controller.rate_hz")
"""Where numbers stand that a bench can be measured for."""
DESIGNED = {"sensor": "sensor.cutoff_hz", "delay": "controller.delay_s", "gain": "sensitivity"}
"""Values whose intervals a design holds, by its flag."""
TAU, SPREAD = "friction.susceptibility_per_um2", "controller.model.gain_spread"
LEAST_SPREAD = 1.1
"""Loop gain over the believed one that is left to a finger however well it was measured (assumed: it moistens)."""
LEAST_CORNER = 0.005
"""Share by which a design should let the resonance be off, however well it was measured (assumed: it warms)."""


@dataclass(frozen=True, kw_only=True)
class Bench(Result):
    """A bench, and where its numbers come from."""

    SCHEMA: ClassVar[str] = "identify.bench/1"
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
    range_db: float | None = None
    """What the converter spans, by what is stated, over the noise of a quiet recording."""
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
    def assumed(self) -> dict[str, Any]:
        """Numbers of plate, sensor, delay and friction that nobody has measured or stated, by dotted name."""
        tree = self.system.model_dump()
        told = {*self.measured, *self.stated}
        names = [name for name in known_names(type(preset("bench")), tree) if name.startswith(ASSUMED)]
        left = [name for name in names if name not in told and not name.endswith("kind")]
        return {name: tree[name.partition(".")[0]].get(name.partition(".")[2]) for name in left}

    @property
    def corners(self) -> tuple[Corner, ...]:
        """Ends of the intervals at which gains have to hold."""
        return corners_of(self.measured, self.people)

    @property
    def loops(self) -> list[LinearLoop]:
        """The loops at which gains have to hold, for `retune`: as measured, and at each corner, dry and moist."""
        benches = [self.system, *(self.system.evolve({each.path: each.value}) for each in self.corners)]
        return [loop for each in benches for loop in operating_band(each, occluded=(0.0, 1.0))]

    def rows(self) -> list[Row]:
        """Return how much was measured, what a design should hold, whose fingers, and the dynamic range."""
        counts = {"measured": self.measured, "stated": self.stated, "assumed": self.assumed}
        found = [("bench", ", ".join(f"{len(each)} values {name}" for name, each in counts.items()))]
        if self.resonance_error is not None:
            found.append(("design", f"design controller BENCH.toml {self.design_flags}"))
        if self.people is not None:
            found.append(("fingers", f"{len(self.people.names)}: {', '.join(self.people.names)}"))
        return found + ([("range", f"{self.range_db:.1f} dB")] if self.range_db is not None else [])

    def tables(self) -> dict[str, pd.DataFrame]:
        """Return the values with their intervals, the three lines of each error, numbers, and what was not measured."""
        import pandas as pd

        every = list(self.measured.values())
        loop = sorted(every, key=lambda each: each.path not in LOOP)[:MOST]
        lines = {
            name: [getattr(each, name) for each in every] for name in ("within", "between", "method", "how", "date")
        }
        numbers = [(part.kind, name, number_said(each)) for part in self.parts for name, each in part.numbers.items()]
        numbers += [("fingers", name, number_said(each)) for name, each in self._of_people()]
        stated = {"value": [self._value(name) for name in self.stated], "from": list(self.stated.values())}
        assumed = {"value": list(self.assumed.values()), "unit": [unit_of(name) for name in self.assumed]}
        corners = [(each.path, f"{each.value:.6g}", each.side) for each in self.corners]
        return {
            "measured": pd.DataFrame({"value, 95 %": [str(e.estimate) for e in loop]}, [e.path for e in loop]),
            "standard errors": pd.DataFrame(lines, [each.path for each in every]),
            "numbers": pd.DataFrame(numbers, columns=["of", "number", "value"]).set_index("of"),
            "stated": pd.DataFrame(stated, list(self.stated)),
            "assumed": pd.DataFrame(assumed, list(self.assumed)),
            "corners": pd.DataFrame(corners, columns=["value", "at", "end"]).set_index("value"),
        }

    def _value(self, path: str) -> Any:
        value: Any = self.system
        for word in path.split("."):
            value = getattr(value, word)
        return value

    def _of_people(self) -> list[tuple[str, Any]]:
        return [] if self.people is None else list(self.people.numbers().items())

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name but what is drawn; ``certified`` reads measured values and corners again."""
        own = super().to_dict()
        del own["keys"]
        more = {"corners": self.corners, "design_flags": self.design_flags, "assumed": self.assumed}
        return own | {"measured": plain(list(self.measured.values()))} | plain(more)

    def kept(self) -> dict[str, Any]:
        """Return what entries told as plain data, to be handed to `bench` the next time."""
        return results_of(list(zip(self.keys, self.parts, strict=True)))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write what `to_toml` returns; ``FrictionloopError`` for a path that cannot be written."""
        with replacing(path) as beside:
            beside.write_text(bench_file.to_toml(self), encoding="utf-8")

    def write_population(self, path: str | os.PathLike[str]) -> None:
        """Write the population of fingers as TOML, for ``fl.fingers``."""
        import tomlkit

        if self.people is None:
            raise must_be("population", None, f"slides of {LEAST_FINGERS} fingers or more", "", "FEW-FINGERS")
        with replacing(path) as beside:
            beside.write_text(tomlkit.dumps(self.people.population.model_dump()), encoding="utf-8")


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
        Results of an earlier time (`Bench.kept`), or a JSON file of them, which is written anew: an entry whose files
        and settings are unchanged is not analysed again.
    again : bool
        Whether to analyse everything anew; the file is written all the same.
    without_refused : bool
        Whether to go on without the entries whose files or analyses are refused, and say which.

    Raises
    ------
    FrictionloopError
        For what the project file, a recording or an analysis refuses, in one line. `Unfinished` keeps the results of
        the other entries.
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
    with suppress(OSError, ValueError):
        found = json.loads(Path(path).read_text(encoding="utf-8"))
        if isinstance(found, dict):
            return found
    return {}


def _bench(project: Project, path: Path, work: Work) -> Bench:
    parts, sensor = work.parts, work.sensor
    found, doubts = agreed([part for _, part in parts])
    crowd, medians, few = together([part for _, part in parts])
    found |= {each.path: each for each in medians}
    overrides, stated = _stated(project, sensor)
    if "sensitivity" in found and sensor.unit == "counts":
        overrides["board.force_n_per_count"] = 1 / sensor.sensitivity
        overrides["board.force_zero_counts"] = [round(found["offset"].value), 0]
        for name in ("force_n_per_count", "force_zero_counts"):
            stated[f"board.{name}"] = "from the weights: " + bench_file.source_of(found["sensitivity"])
    of_system = {name: each for name, each in found.items() if "." in name}
    for name, each in of_system.items():
        overrides[name] = _rounded(each)
        if name in bench_file.BELIEVED:
            overrides[bench_file.BELIEVED[name]] = overrides[name]
    if TAU in of_system:
        tau = of_system[TAU]
        overrides[SPREAD] = float(f"{max(tau.interval().high / tau.value, LEAST_SPREAD):.3g}")
        stated[SPREAD] = f"upper end over value, {LEAST_SPREAD:g} or more"
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
        said["sensor.range_n"] = f"stated: full scale {full:g} {sensor.unit} / sensitivity"
    return overrides, said


def _range_db(system: System, parts: Sequence[Part]) -> float | None:
    """Return what the converter spans, by what is stated, over the noise of a recording; None without one."""
    sensor: Any = system.sensor
    floors = [part.curves["floor"] for part in parts if part.kind == "quiet" and "floor" in part.curves]
    if not floors or not floors[0]["rms_n"] > 0 or "range_n" not in type(sensor).model_fields:
        return None
    return dynamic_range_db(sensor.range_n, floors[0]["rms_n"])
