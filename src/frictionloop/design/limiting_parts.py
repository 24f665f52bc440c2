"""What limits a bench: the controller of a bench that has one part changed, beside that of the bench as it is."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from joblib import Parallel, delayed

from frictionloop.analysis.limits import headroom
from frictionloop.analysis.operating_point import at_levels
from frictionloop.design.controller_synthesis import default_law, synthesised
from frictionloop.design.operating_grid import with_longest_contact
from frictionloop.design.requirements import NOT_HELD, Requirements
from frictionloop.design.tracking import tracking
from frictionloop.findings import Finding, Result, shown
from frictionloop.findings.result import Figure, Row, Tables, frame
from frictionloop.loop.progress import progress_bar
from frictionloop.parameters import LowpassPlate, Strokes, SuspendedSensor, System
from frictionloop.quantities import FrictionloopError

WORTH = 0.9
"""Residual over that of the bench as it is below which a part is said to limit it (assumed)."""
KNOWN_GAIN = 1.1
"""Loop gain over the believed one of a finger whose friction and susceptibility were measured (docs/which-law.md)."""
AS_IT_IS = "as it is"


@dataclass(frozen=True, kw_only=True)
class LimitedPart:
    """The bench with one part changed, under the controller that is found for it."""

    name: str
    part: str
    """What was changed, of the bench as it is."""
    changes: Mapping[str, Any]
    """Overrides, and requirements by their names."""
    crossover_hz: float = math.nan
    """Lowest frequency at which |S| is 1."""
    residual_n: float = math.nan
    """What is left of friction noise, tremor and drift, rms, by linear analysis."""
    rms_error_n: float = math.nan
    """RMS of f_a - f_r of a simulated run at the set-point of the file."""
    relative_index: float = math.nan
    """How rough that error is to touch, over a plain stroke."""

    @property
    def left_n(self) -> float:
        """The residual; where nothing strokes, so that there is none, the error of the run."""
        return self.rms_error_n if math.isnan(self.residual_n) else self.residual_n


class BenchLimits(Result, schema="design.limits/1"):
    """Which part of a bench limits its controller."""

    law: str
    requirements: Requirements
    parts: tuple[LimitedPart, ...]
    """The bench as it is first."""

    @property
    def limiting(self) -> tuple[LimitedPart, ...]:
        """Parts whose change leaves less, the one that leaves least first."""
        least = WORTH * self.parts[0].left_n
        return tuple(sorted((p for p in self.parts[1:] if p.left_n < least), key=lambda part: part.left_n))

    def rows(self) -> list[Row]:
        """Return what limits the bench, and what the best change would leave."""
        own, found = self.parts[0], self.limiting
        left = f"{shown(1e3 * own.left_n)} mN"
        if not found:
            return [(self.law, left), ("limited by", "no single part")]
        best = f"{shown(1e3 * found[0].left_n)} mN with {found[0].name}"
        return [(self.law, f"leaves {left}, {best}"), ("limited by", ", then ".join(each.part for each in found))]

    def tables(self) -> Tables:
        """Return crossover, residual, error and roughness by what was changed."""
        rows = {
            each.name: [each.crossover_hz, 1e3 * each.residual_n, 1e3 * each.rms_error_n, each.relative_index]
            for each in self.parts
        }
        heads = ["|S| = 1, Hz", "leaves, mN", "error, mN", "felt"]
        return {"parts": frame(rows, "bench", heads)}

    def plot(self) -> Figure:
        """Return bars of what is left, by what was changed."""
        from frictionloop.figures.style import BLUE, GREY, new_figure, styled

        @styled
        def draw() -> Figure:
            figure = new_figure(6.4, 0.5 + 0.32 * len(self.parts))
            axes = figure.subplots()
            names = [each.name for each in self.parts]
            left = [1e3 * each.left_n for each in self.parts]
            axes.barh(names, left, color=[GREY, *[BLUE] * (len(names) - 1)])
            axes.invert_yaxis()
            axes.set(xlabel="rms left (mN)", title=f"{self.law}, one part changed")
            return figure

        return draw()


Changed = tuple[str, str, dict[str, Any], dict[str, Any]]


def changed_parts(system: System, must: Requirements) -> list[Changed]:
    """Return name, part, overrides and requirements of each bench with one part changed, that as it is first."""
    controller, plate = system.controller, system.plate
    found: list[Changed] = [(AS_IT_IS, "", {}, {})]
    if isinstance(system.sensor, SuspendedSensor):
        stiffer = 2.0 * system.sensor.resonance_hz
        if must.resonance_error:
            found += [("resonance exactly as told", "the resonance's error", {}, {"resonance_error": 0.0})]
        found += [(f"resonance of {stiffer:g} Hz", "the sensor's resonance", {"sensor.resonance_hz": stiffer}, {})]
    if controller.delay_s:
        found += [("no computing delay", "the delay", {"controller.delay_s": 0.0}, {})]
    twice_hz = 2.0 * controller.rate_hz
    found += [(f"rate of {1e-3 * twice_hz:g} kHz", "the rate", {"controller.rate_hz": twice_hz}, {})]
    fast_hz = 5.0 * plate.cutoff_hz
    faster = {"plate.cutoff_hz": fast_hz} if isinstance(plate, LowpassPlate) else {"plate.q": plate.q / 5.0}
    found += [("plate 5 x as fast", "the plate", faster | {"controller.model.plate_hz": fast_hz}, {})]
    amplitude = {f"{block}.max_amplitude_um": 2.0 * plate.max_amplitude_um for block in ("plate", "controller.model")}
    found += [("amplitude 2 x as large", "the amplitude", amplitude, {})]
    if isinstance(system.motion, Strokes) and hasattr(system.finger, "slip_length_um"):
        known = {"finger_gain": KNOWN_GAIN, "slip_lengths_um": (system.finger.slip_length_um,)}
        found += [("finger measured", "the spread of fingers", {}, known)]
    return found


def limits(system: System, law: str | None = None, requirements: Requirements | None = None) -> BenchLimits:
    """Return what a controller would leave on a bench that has one part changed, each with the design for it.

    Parameters
    ----------
    system
        The bench.
    law
        As of `controller`.
    requirements
        What must hold. None: `Requirements` as it is.

    Raises
    ------
    FrictionloopError
        As of `controller`, for the bench as it is.
    """
    must = requirements or Requirements()
    name = law or default_law(system)
    cases = changed_parts(system, must)
    tasks = (delayed(_part)(system, name, must, *each) for each in cases)
    parts: list[LimitedPart] = []
    with progress_bar("benches with one part changed", len(cases)) as bar:
        for each in Parallel(n_jobs=-1, return_as="generator")(tasks):
            parts.append(each)
            bar()
    failed = [each.name for each in parts if math.isnan(each.crossover_hz)]
    findings = [Finding("PART-FAILED", value=len(failed), more={"names": failed})] if failed else []
    return BenchLimits(law=name, requirements=must, parts=tuple(parts), findings=tuple(findings))


def _part(
    system: System, law: str, must: Requirements, name: str, part: str, changes: dict[str, Any], asked: dict[str, Any]
) -> LimitedPart:
    """Return one bench; NaN where a changed one has no such controller."""
    there, changed = system.evolve(changes), LimitedPart(name=name, part=part, changes={**changes, **asked})
    required = replace(must, **asked)
    levels = with_longest_contact(at_levels(there), required.speeds_mm_s)
    try:
        found, _ = synthesised(levels, law, required)
    except FrictionloopError as error:
        if name == AS_IT_IS or error.code != NOT_HELD:
            raise
        return changed
    left = headroom(levels.evolve(dict(found.overrides)), required.sensitivity_peak)
    run = tracking(there.evolve(dict(found.overrides)))
    return replace(
        changed,
        crossover_hz=left.zero_db_hz,
        residual_n=left.residual_rms_n,
        rms_error_n=math.nan if run is None else run.rms_error_n,
        relative_index=math.nan if run is None else run.relative_index,
    )
