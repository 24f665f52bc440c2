"""What a designed controller holds for, in words: strokes, forces, resonances, ends of intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.analysis.reach import missed
from frictionloop.cli.scores import between
from frictionloop.design.corners import CONTACT_S
from frictionloop.design.elsewhere import in_words

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System


MANY = "`frictionloop sweep FILE --fingers 100` says how many fingers can be given these forces."
LARGER = ", or give a larger max_amplitude_um to plate and controller.model, or a shorter motion.contact_s."
CONTACT_SAID = f"A moist finger is one after {CONTACT_S:g} s on the plate, or after motion.contact_s."


def holds(law: str, designed: Designed, wanted: Wanted) -> list[str]:
    """Return the comment lines of a saved controller: for which strokes, forces and resonances it holds."""
    found = designed.corners
    forces = [each.loop.elements.force_n for each in found]
    states = sorted({each.loop.elements.occluded for each in found})
    fingers = " and ".join(finger(state) for state in states)
    limits = [
        f"{peak:.3g} " + (f"with it +-{100 * off:.3g} % off" if off else "as described")
        for off, peak in sorted(wanted.limits.items())
    ]
    return [
        f"Law {law} from frictionloop design controller. It holds for what follows; elsewhere, design again.",
        f"Strokes: {'; '.join(each.removeprefix(', ') for each in strokes_said(found, wanted)) or 'none'}.",
        f"Forces: {between(min(forces), max(forces))}, {fingers}.",
        *([CONTACT_SAID] if max(states) > 0 else []),
        *instead_of(found[0].loop.system, states),
        f"Resonance of the sensor: Ms up to {', '.join(limits)}.",
        *ends_said(wanted),
        *also_said(designed),
        *designed.warnings,
    ]


def also_said(designed: Designed) -> list[str]:
    """Return a line with the other contacts and speeds at which the same limits hold, resonance off too; or none."""
    places = in_words(designed.elsewhere.where("within"))
    return [f"Within the same limits, resonance off too: {'; '.join(places)}."] if places else []


def ends_said(wanted: Wanted) -> list[str]:
    """Return a line with the values that may be at the ends of their intervals, none without."""
    by_path: dict[str, list[float]] = {}
    for path, value in wanted.lean.ends:
        by_path.setdefault(path, []).append(value)
    listed = [f"{path} {min(values):.6g} to {max(values):.6g}" for path, values in by_path.items()]
    return [f"One value at a time at an end of its interval: {', '.join(listed)}."] if listed else []


def instead_of(system: System, states: Sequence[float]) -> list[str]:
    """Return a line for each force asked for that is out of reach: which was evaluated in its place."""
    said = [
        f"{each.force_n:.3g} N is out of reach of {finger(each.occluded)}: {each.instead_n:.3g} N is evaluated in its "
        "place."
        for each in missed(system, states)
    ]
    return [*said, MANY] if said else []


def beyond_reach(system: System, states: Sequence[float]) -> list[tuple[str, str]]:
    """Return rows of a verdict: which forces no amplitude gives to which finger, and what to change; none if all do."""
    rows = []
    for state in states:
        beyond = missed(system, [state])
        for low, end, other in ((True, "least", "more"), (False, "most", "less")):
            here = [each for each in beyond if (each.force_n < each.instead_n) == low]
            if here:
                forces = ", ".join(f"{each.force_n:.3g} N" for each in here)
                rows.append(f"{forces} of {finger(state)}: {here[0].instead_n:.3g} N is looked at, near the {end} it "
                            f"can be given; a run does not follow there. Ask for {other} (setpoint.offset_n, "
                            f"amplitude_n){LARGER * low}")  # fmt: skip
    return [("OUT OF REACH" if k == 0 else "", row) for k, row in enumerate([*rows, MANY])] if rows else []


def finger(occluded: float) -> str:
    """Return the state of a finger in words."""
    return f"a moist finger (occluded {occluded:.0%})" if occluded > 0 else "a finger just landed"


def strokes_said(found: Sequence[Corner], wanted: Wanted) -> list[str]:
    """Return contacts and speeds in words; a range of speeds by its ends."""
    strokes = list(dict.fromkeys(each.stroke for each in found))
    if len(strokes) == 1 or not wanted.speeds_mm_s:
        return strokes
    contacts = dict.fromkeys(stroke.rpartition(", ")[0] for stroke in strokes)
    low, high = min(wanted.speeds_mm_s), max(wanted.speeds_mm_s)
    return [f"{contact}, {low:g} to {high:g} mm/s" for contact in contacts]
