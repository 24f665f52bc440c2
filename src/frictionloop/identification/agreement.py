"""What several entries say together: one value of each name, fingers that make a population, corners for a design."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from frictionloop.findings import Finding
from frictionloop.findings.catalogue import Severity
from frictionloop.identification.measured import Estimate, Measured, measured
from frictionloop.identification.part import Part
from frictionloop.identification.people import LEAST_FINGERS, People, few_fingers, people

APART = 3.0
"""Two methods contradict each other where they are so many standard errors apart (assumed)."""
FINGERS = 1.96
"""So many spreads on either side hold 95 of 100 fingers."""
TAU = "friction.susceptibility_per_um2"
LOOP = (
    *("sensor.resonance_hz", "sensor.q", "sensor.cutoff_hz", "plate.frequency_hz", "plate.q"),
    *("plate.max_amplitude_um", "controller.delay_s", "friction.nominal_n", TAU, "friction.load_exponent"),
)
"""Measured values on which the loop's margins depend."""


class Corner(NamedTuple):
    """One value at an end of its interval, at which gains have to hold."""

    path: str
    value: float
    side: str
    """"low" or "high"."""


def corners_of(values: Mapping[str, Measured], crowd: People | None) -> tuple[Corner, ...]:
    """Return both ends of the 95 % interval of each measured value that the loop depends on.

    The controller is not told: ``system.evolve({corner.path: corner.value})`` is the bench it has to hold on. The ends
    are value e^(+-half width/value), never below 0. Of what a population tells they hold 95 of 100 fingers, and not the
    median alone.
    """
    spreads = {} if crowd is None else {each.path: FINGERS * each.spread for each in crowd.population.value}
    found = []
    for path in LOOP:
        if path in values:
            each = values[path]
            half = max((each.interval().high - each.value) / each.value, spreads.get(path, 0.0))
            found += [
                Corner(path, each.value * math.exp(-half), "low"),
                Corner(path, each.value * math.exp(half), "high"),
            ]
    return tuple(found)


def agreed(parts: Sequence[Part]) -> tuple[dict[str, Measured], list[Finding]]:
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
        for other in values:
            if other is best:
                continue
            apart = abs(other.value - best.value) / max(math.hypot(other.error, best.error), 1e-300)
            more = {"path": path, "apart": apart, "other": other.files[0], "errors": [best.error, other.error]}
            severity: Severity = "warning" if apart > APART else "note"
            told.append(Finding("METHODS-DIFFER", severity, best.value, best.unit, other.value, more=more))
    return chosen, told


def together(parts: Sequence[Part]) -> tuple[People | None, list[Measured], list[Finding]]:
    """Return the population that the fingers of slides make, its medians as measured values, and what is said of it."""
    persons = [(part, part.curves["person"]) for part in parts if part.curves.get("person")]
    # Recordings with amplitude commands tell tau too; then those count alone.
    with_tau = [pair for pair in persons if TAU in pair[1]["found"][0]]
    used = with_tau if len({person["finger"] for _, person in with_tau}) >= LEAST_FINGERS else persons
    paths = set.intersection(*({*person["found"][0]} for _, person in used)) if used else set()
    entries: dict[str, list[Mapping[str, Any]]] = {}
    for _, person in used:
        for each in person["found"]:
            entries.setdefault(person["finger"], []).append({path: each[path] for path in sorted(paths)})
    if len(entries) < LEAST_FINGERS:
        return None, [], list(few_fingers(len(entries))) if entries else []
    found = people(entries)
    files = tuple(dict.fromkeys(each["path"] for part, _ in used for each in part.files))
    date = used[0][0].files[0]["date"]
    values = [
        _median(path, median, found, k, files, date)
        for k, (path, median) in enumerate(zip(sorted(paths), found.medians, strict=True))
    ]
    return found, values, list(found.findings)


def _median(path: str, median: Estimate, found: People, k: int, files: tuple[str, ...], date: str) -> Measured:
    """Return a median over fingers: what scatters within one is chance, the rest of its error is between them."""
    count = len(found.names)
    own = median.value * float(found.within[k]) / math.sqrt(count)
    value = measured(path, [median], [0.0], f"median of {count} fingers, partial pooling", files, date)
    within = min(own, median.standard_error)
    between = math.sqrt(max(median.standard_error**2 - within**2, 0.0))
    return Measured(**{**value.__dict__, "within": within, "between": between})
