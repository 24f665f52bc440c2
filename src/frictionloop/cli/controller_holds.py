"""What a designed controller holds for, in words: strokes, forces, resonances, ends of intervals."""

from __future__ import annotations

import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from frictionloop.analysis.reach import missed
from frictionloop.cli.scores import between
from frictionloop.design.corners import CONTACT_S, load_of
from frictionloop.design.elsewhere import in_words
from frictionloop.parameters import FingerFriction, Skin, Strokes

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System


AGAIN = "Look again: frictionloop design check FILE"
"""Begins the line of a saved controller with the flags that it was designed for."""
NOT_SAVED = ("would hold", "other people", "other loads", "by the file")
"""Rows of a check that propose what to do next, which a file is not the place for."""
MANY = "`frictionloop sweep FILE --fingers 100{}` says how many fingers can be given these forces."
LARGER = ", or give a larger max_amplitude_um to plate and controller.model"
DRIER = ", a shorter motion.contact_s or a longer motion.lifted_s."
OFF = {
    "sensor_error": "the pole of the sensor's electronics", "delay_error": "the delay",
    "gain_error": "the sensor's sensitivity", "q_error": "the Q of the sensor's resonance",
}  # fmt: skip
CONTACT_SAID = (
    f"A moist finger is one after {CONTACT_S:g} s on the plate, or after contact upon contact of motion.contact_s."
)


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
        f"Strokes: {strokes_said(found, wanted) or 'none'}.",
        f"Forces: {between(min(forces), max(forces))}, {fingers}.",
        *([CONTACT_SAID] if max(states) > 0 else []),
        *instead_of(loads_of(found), states),
        f"Resonance of the sensor: Ms up to {', '.join(limits)}.",
        *ends_said(wanted),
        *also_said(designed),
        *designed.warnings,
        *beyond_said(designed),
        *(
            ["The finger is that of this file; others: --fingers 100 with the next line."]
            if has_people(found[0].loop.system)
            else []
        ),
        f"{AGAIN}{wanted_flags(found, wanted)}",
    ]


def checked(verdict: Sequence[tuple[str, ...]], found: Sequence[Corner], wanted: Wanted, more: str) -> list[str]:
    """Return the comment lines of a controller that was checked: the rows of the verdict, and how to look again."""
    told, name = ["This controller as it was given; frictionloop design check found of it:"], ""
    for first, said in verdict:
        name = first or name
        if name not in NOT_SAVED and not said.startswith("`frictionloop"):
            told += textwrap.wrap(f"{first}: {said}" if first else f"  {said}", 100, subsequent_indent="  ")
    return [*told, f"{AGAIN}{wanted_flags(found, wanted)}{more}"]


def designed_for(file: Path | None) -> str:
    """Return the flags that look at what a saved controller says it was designed for; empty of any other file."""
    if file is None:
        return ""
    lines = (line.removeprefix("# ") for line in file.read_text(encoding="utf-8").splitlines() if line.startswith("# "))
    return next((line.removeprefix(AGAIN).strip() for line in lines if line.startswith(AGAIN)), "")


def beyond_said(designed: Designed) -> list[str]:
    """Return a line with the other contacts and speeds at which it is stable, beyond the limits; or none."""
    places = in_words(designed.elsewhere.where("beyond"))
    return [f"Stable, but beyond these limits: {'; '.join(places)}."] if places else []


def wanted_flags(found: Sequence[Corner], wanted: Wanted) -> str:
    """Return the flags that check a controller for what it was designed for: contacts to errors."""
    contacts = dict.fromkeys(each.loop.system.finger.contact for each in found
                             if isinstance(each.loop.system.finger, Skin))  # fmt: skip
    limits = {"sensitivity_peak": wanted.sensitivity_peak, "resonance_error": wanted.resonance_error}
    usual, shares = type(wanted)(), {name: f"{share:g}" for name, share in wanted.lean.shares.items() if share}
    flags = {"contacts": ",".join(contacts), "speeds": _ends(wanted.speeds_mm_s), "loads": _ends(wanted.loads_n)}
    flags |= {name: f"{value:g}" for name, value in limits.items() if value != getattr(usual, name)} | shares
    flags |= {"corners": "CERTIFICATE"} if wanted.lean.ends else {}
    return "".join(f" --{name.replace('_', '-')} {value}" for name, value in flags.items() if value)


def _ends(values: Sequence[float]) -> str:
    return f"{min(values):g},{max(values):g}" if values else ""


def also_said(designed: Designed) -> list[str]:
    """Return a line with the other contacts and speeds at which the same limits hold, resonance off too; or none."""
    places = in_words(designed.elsewhere.where("within"))
    return [f"Within the same limits, resonance off too: {'; '.join(places)}."] if places else []


def ends_said(wanted: Wanted) -> list[str]:
    """Return lines with the shares by which a bench may be off, and the values that may be at an end; none without."""
    by_path: dict[str, list[float]] = {}
    for path, value in wanted.lean.ends:
        by_path.setdefault(path, []).append(value)
    listed = [f"{path} {min(values):.6g} to {max(values):.6g}" for path, values in by_path.items()]
    off = [f"{OFF[name]} {100 * share:.3g} %" for name, share in wanted.lean.shares.items() if share]
    lines = [f"The same limits with the bench off, either way: {', '.join(off)}."] if off else []
    return [*lines, *([f"One value at a time at an end of its interval: {', '.join(listed)}."] if listed else [])]


def loads_of(found: Sequence[Corner]) -> list[System]:
    """Return a system for each mean load of the corners, lightest first."""
    by_load = {load_of(each.loop.system): each.loop.system for each in reversed(found)}
    return [by_load[load] for load in sorted(by_load, key=lambda load: load or 0.0)]


def instead_of(systems: Sequence[System], states: Sequence[float]) -> list[str]:
    """Return a line for each force asked for that is out of reach: which was evaluated in its place."""
    said = [
        f"{each.in_words[0]} N is out of reach of {finger(each.occluded)}{_pressed(systems, [there])}: "
        f"{each.in_words[1]} N is evaluated in its place."
        for there in systems
        for each in missed(there, states)
    ]
    return [*said, *filter(None, [_many(systems)])] if said else []


def beyond_reach(systems: Sequence[System], states: Sequence[float]) -> list[tuple[str, str]]:
    """Return rows of a verdict: which forces no amplitude gives to which finger, and what to change; none if all do.

    The systems are one at several loads.
    """
    rows = []
    larger = LARGER + (DRIER if all(map(has_people, systems)) else ".")
    for state in states:
        beyond = [(there, each) for there in systems for each in missed(there, [state])]
        for low, end, other in ((True, "least", "more"), (False, "most", "less")):
            here = [(there, each) for there, each in beyond if (each.force_n < each.instead_n) == low]
            if here:
                forces = ", ".join(dict.fromkeys(f"{each.in_words[0]} N" for _, each in here))
                instead = list(
                    dict.fromkeys(each.in_words[1] + f" N{_pressed(systems, [there])}" for there, each in here)
                )
                rows.append(f"{forces} of {finger(state)}: {', '.join(instead)} {'are' if len(instead) > 1 else 'is'} "
                            f"looked at, near the {end} it can be given; a run does not follow there. Ask for {other} "
                            f"(setpoint.offset_n, amplitude_n){larger if low else '.'}")  # fmt: skip
    return (
        [("OUT OF REACH" if k == 0 else "", row) for k, row in enumerate(filter(None, [*rows, _many(systems)]))]
        if rows
        else []
    )


def _many(systems: Sequence[System]) -> str:
    """Return the command that says how many fingers can be given the forces, pressed with the same loads."""
    if not all(map(has_people, systems)):
        return ""
    loads = sorted({f"{load_of(each):.3g}" for each in systems}, key=float)
    return MANY.format(f" --loads {loads[0]},{loads[-1]}" if len(loads) > 1 else "")


def _pressed(systems: Sequence[System], some: Sequence[System]) -> str:
    """Return at which of several loads, in words; nothing of one."""
    loads = dict.fromkeys("" if (load_n := load_of(each)) is None else f"{load_n:.3g}" for each in some)
    return f" pressed with {', '.join(loads)} N" if len(systems) > 1 else ""


def has_people(system: System) -> bool:
    """Tell whether a system is of a finger that others could bring their own in place of."""
    has = isinstance(system.friction, FingerFriction) and isinstance(system.finger, Skin)
    return has and isinstance(system.motion, Strokes)


def other_people(system: System, command: str) -> list[tuple[str, str]]:
    """Return the row with the command that looks at other people's fingers; none of a system without a finger."""
    if not has_people(system):
        return []
    return [("other people", f"not looked at: {command} counts the fingers on which the limits hold, and names gains "
                             "for more of them")]  # fmt: skip


def finger(occluded: float) -> str:
    """Return the state of a finger in words."""
    return f"a moist finger (occluded {occluded:.0%})" if occluded > 0 else "a finger just landed"


def strokes_said(found: Sequence[Corner], wanted: Wanted) -> str:
    """Return contacts, speeds and loads in words, a range by its ends: contacts dahl and slider, 20 to 60 mm/s."""
    systems = [each.loop.system for each in found]
    contacts = list(dict.fromkeys(each.finger.contact for each in systems if isinstance(each.finger, Skin)))
    speeds = [each.motion.speed_mm_s for each in systems if isinstance(each.motion, Strokes)]
    said = [f"contact{'s' * (len(contacts) > 1)} {' and '.join(contacts)}"] if contacts else []
    said += [f"{_range(speeds)} mm/s"] if speeds else []
    said += [f"pressed with {_range(wanted.loads_n)} N"] if wanted.loads_n else []
    return ", ".join(said)


def _range(values: Sequence[float]) -> str:
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
