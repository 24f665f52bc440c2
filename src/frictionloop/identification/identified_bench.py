"""A bench that was identified, and its file: of each value whether it is measured, stated, chosen or assumed."""

from __future__ import annotations

import os
from collections.abc import Mapping
from operator import attrgetter
from pathlib import Path
from typing import Any

from frictionloop.analysis import operating_band
from frictionloop.analysis.linear import LinearLoop
from frictionloop.findings import Result
from frictionloop.findings.result import Row, Tables, plain
from frictionloop.identification.certificate_comparison import LOOP, Corner, corners_of
from frictionloop.identification.estimate import Measured
from frictionloop.identification.finger_population import LEAST_FINGERS, People
from frictionloop.identification.project_analysis import RefusedEntry, results_of
from frictionloop.identification.project_entry_result import EntryResult, number_said
from frictionloop.parameters import System, preset
from frictionloop.parameters.refusals import known_names
from frictionloop.quantities import must_be, replacing, unit_of
from frictionloop.quantities.code_version import package_version

MOST = 12
"""Values in the table that belongs to the answer."""
ASSUMED = ("friction.", "plate.", "sensor.", "finger.", "controller.delay_s", "controller.rate_hz")
"""Where numbers stand that a bench can be measured for."""
DESIGNED = {"sensor": "sensor.cutoff_hz", "delay": "controller.delay_s", "gain": "sensitivity"}
"""Values whose intervals a design holds, by its flag."""

BELIEVED = {
    "sensor.resonance_hz": "controller.model.resonance_hz",
    "sensor.q": "controller.model.resonance_q",
    "sensor.cutoff_hz": "controller.model.sensor_hz",
    "friction.nominal_n": "controller.model.nominal_n",
    "friction.susceptibility_per_um2": "controller.model.susceptibility_per_um2",
    "plate.max_amplitude_um": "controller.model.max_amplitude_um",
}
"""What the controller believes follows what was measured."""
CHOSEN = ("setpoint.", "disturbance.", "controller.kp", "controller.ki", "motion.speed", "motion.stroke")


class Bench(Result, schema="identify.bench/1", without="keys"):
    """A bench, and where its numbers come from."""

    system: System
    parts: tuple[EntryResult, ...]
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

    def tables(self) -> Tables:
        """Return the values with their intervals, the three lines of each error, numbers, and what was not measured."""
        import pandas as pd  # type: ignore[import-untyped]

        every = list(self.measured.values())
        loop = sorted(every, key=lambda each: each.path not in LOOP)[:MOST]
        lines = {
            name: [getattr(each, name) for each in every] for name in ("within", "between", "method", "how", "date")
        }
        lines["between"] = ["not known" if each is None else each for each in lines["between"]]
        numbers = [(part.kind, name, number_said(each)) for part in self.parts for name, each in part.numbers.items()]
        people = {} if self.people is None else self.people.numbers()
        numbers += [("fingers", name, number_said(each)) for name, each in people.items()]
        stated = {"value": [attrgetter(name)(self.system) for name in self.stated], "from": list(self.stated.values())}
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

    def to_dict(self) -> dict[str, Any]:
        """Return everything by name but what is drawn; ``certified`` reads measured values and corners again."""
        more = {"corners": self.corners, "design_flags": self.design_flags, "assumed": self.assumed}
        return super().to_dict() | {"measured": plain(list(self.measured.values()))} | plain(more)

    def entry_results(self) -> dict[str, Any]:
        """Return what entries told as plain data, to be handed to `bench` the next time."""
        return results_of(list(zip(self.keys, self.parts, strict=True)))

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write what `to_toml` returns; ``FrictionloopError`` for a path that cannot be written."""
        with replacing(path) as beside:
            beside.write_text(to_toml(self), encoding="utf-8")

    def write_population(self, path: str | os.PathLike[str]) -> None:
        """Write the population of fingers as TOML, for ``fl.fingers``."""
        import tomlkit

        if self.people is None:
            raise must_be("population", None, f"slides of {LEAST_FINGERS} fingers or more", "", "FEW-FINGERS")
        with replacing(path) as beside:
            beside.write_text(tomlkit.dumps(self.people.population.model_dump()), encoding="utf-8")


def to_toml(found: Bench) -> str:
    """Return the System as TOML text; a comment says whether a value is measured, stated, chosen or assumed."""
    import tomlkit

    from frictionloop.parameters.toml_writer import to_toml

    document = tomlkit.parse(to_toml(found.system, every=False))
    said = {name: source_of(each) for name, each in found.measured.items() if "." in name}
    said |= {BELIEVED[name]: f"as {name}" for name in said if name in BELIEVED}
    said |= dict(found.stated)
    _comment(document, "", said)
    head = [f"# {found.project.name}, frictionloop {package_version()}"]
    head += [f"# {each['path']}: sha256 {each['sha256']}" for part in found.parts for each in part.files]
    if (line := found.measured.get("sensitivity")) is not None:
        head.append(f"# sensitivity: {line.estimate} ({source_of(line)})")
    if found.resonance_error is not None:
        head.append(f"# frictionloop design controller FILE {found.design_flags}")
    body = document.as_string().split("\n", 1)[1] if document.as_string().startswith("#") else document.as_string()
    return "\n".join(head) + "\n" + body


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


def source_of(each: Measured) -> str:
    """Return where a value comes from, with its interval."""
    files = each.files[0] if len(each.files) == 1 else f"{each.files[0]} and {len(each.files) - 1} more"
    return f"measured, {each.estimate} (95 %); {files}; {each.how}; {each.date}"
