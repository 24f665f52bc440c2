"""What a designed controller holds for, in words: strokes, forces, resonances, ends of intervals."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from frictionloop.analysis.reach import Missed, missed
from frictionloop.design.corners import load_of
from frictionloop.design.elsewhere import in_words
from frictionloop.design.loop_gains import MOST_PEAK
from frictionloop.parameters import FingerFriction, Skin, Strokes

if TYPE_CHECKING:
    from frictionloop.design.corners import Corner
    from frictionloop.design.loop_gains import LoopGains
    from frictionloop.design.wanted import Designed, Wanted
    from frictionloop.parameters import System


MANY = "`frictionloop sweep FILE --fingers 100{}` says how many fingers can be given these forces."
LARGER = ", or give a larger max_amplitude_um to plate and controller.model"
DRIER = ", a shorter motion.contact_s or a longer motion.lifted_s."
OFF = {
    "sensor_error": "the pole of the sensor's electronics", "delay_error": "the delay",
    "gain_error": "the sensor's sensitivity", "q_error": "the Q of the sensor's resonance",
}  # fmt: skip


def wanted_flags(found: Sequence[Corner], wanted: Wanted) -> str:
    """Return the flags that check a controller for what it was designed for: slip lengths to errors."""
    lengths = lengths_of(found)
    limits = {"sensitivity_peak": wanted.sensitivity_peak, "resonance_error": wanted.resonance_error}
    usual, shares = type(wanted)(), {name: f"{share:g}" for name, share in wanted.lean.shares.items() if share}
    flags = {
        "slip_lengths_um": ""
        if wanted.slip_lengths_um is None and len(lengths) != 1
        else ",".join(f"{z:g}" for z in lengths),
        "speeds": _ends(wanted.speeds_mm_s),
        "loads": _ends(wanted.loads_n),
    }
    limits |= {} if wanted.finger_gain is None else {"finger_gain": wanted.finger_gain}
    flags |= {name: f"{value:g}" for name, value in limits.items() if value != getattr(usual, name)} | shares
    flags |= {"corners": "CERTIFICATE"} if wanted.lean.ends else {}
    return "".join(f" --{name.replace('_', '-')} {value}" for name, value in flags.items() if value)


def _ends(values: Sequence[float]) -> str:
    return f"{min(values):g},{max(values):g}" if values else ""


def also_said(designed: Designed) -> list[str]:
    """Return a line with the other slip lengths and speeds at which the same limits hold; or none."""
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


def places_of(found: Sequence[Corner]) -> list[System]:
    """Return a system for each mean load and speed of the corners, lightest and slowest first."""
    by_place = {_place(each.loop.system): each.loop.system for each in reversed(found)}
    return [by_place[place] for place in sorted(by_place)]


def _place(system: System) -> tuple[float, float]:
    """Return mean load and speed of a finger that strokes; 0 of any other."""
    return load_of(system) or 0.0, system.motion.speed_mm_s if isinstance(system.motion, Strokes) else 0.0


def out_of_reach(systems: Sequence[System], state: float) -> list[tuple[System, Missed]]:
    """Return the forces that no amplitude gives to a finger: at each load those of the speed where most is missing."""
    worst: dict[tuple[float, bool], tuple[System, Missed]] = {}
    for there in systems:
        for each in missed(there, [state]):
            at = (_place(there)[0], each.force_n < each.instead_n)
            if at not in worst or each.short_n > worst[at][1].short_n:
                worst[at] = (there, each)
    return [
        (there, each)
        for (_, low), (there, _) in worst.items()
        for each in missed(there, [state])
        if (each.force_n < each.instead_n) == low
    ]


def beyond_reach(systems: Sequence[System], states: Sequence[float]) -> list[tuple[str, str]]:
    """Return rows of a verdict: which forces no amplitude gives to which finger, and what to change; none if all do.

    The systems are one at several loads and speeds.
    """
    rows, ask = [], {}
    larger = LARGER + (DRIER if all(map(has_people, systems)) else ".")
    for state in states:
        beyond = out_of_reach(systems, state)
        for low, end, other in ((True, "least", "more"), (False, "most", "less")):
            here = [(there, each) for there, each in beyond if (each.force_n < each.instead_n) == low]
            if here:
                forces = ", ".join(dict.fromkeys(f"{each.in_words[0]} N" for _, each in here))
                instead = list(
                    dict.fromkeys(each.in_words[1] + f" N{place_said(systems, there)}" for there, each in here)
                )
                rows.append(f"{forces} of {finger(state)}: {', '.join(instead)} {'are' if len(instead) > 1 else 'is'} "
                            f"looked at, near the {end} it can be given; a run does not follow there.")  # fmt: skip
                ask[other] = f"Ask for {other} (setpoint.offset_n, amplitude_n){larger if low else '.'}"
    told = [*rows, *ask.values(), *filter(None, [many_said(systems)])] if rows else []
    return [("OUT OF REACH" if k == 0 else "", row) for k, row in enumerate(told)]


def many_said(systems: Sequence[System]) -> str:
    """Return the command that says how many fingers can be given the forces, pressed with the same loads."""
    if not all(map(has_people, systems)):
        return ""
    loads = sorted({f"{load_of(each):.3g}" for each in systems}, key=float)
    return MANY.format(f" --loads {loads[0]},{loads[-1]}" if len(loads) > 1 else "")


def place_said(systems: Sequence[System], there: System) -> str:
    """Return at which of several loads, and of several speeds where friction goes with them, in words."""
    loads, speeds = (set(each) for each in zip(*map(_place, systems), strict=True))
    load_n, speed_mm_s = _place(there)
    pressed = f" pressed with {load_n:.3g} N" if len(loads) > 1 else ""
    slope = getattr(there.friction, "speed_slope", 0.0)
    return pressed + (f" at {speed_mm_s:.3g} mm/s" if len(speeds) > 1 and slope else "")


def has_people(system: System) -> bool:
    """Tell whether a system is of a finger that others could bring their own in place of."""
    has = isinstance(system.friction, FingerFriction) and isinstance(system.finger, Skin)
    return has and isinstance(system.motion, Strokes)


def other_people(found: LoopGains | None, law: str, does: str) -> list[tuple[str, str]]:
    """Return the row on how many people the loop comes close to ringing; none of a system without a finger."""
    if found is None:
        return []
    said = f"{found.share:.1%} of {found.people} bring a loop gain above {found.critical:.3g}, where Ms is above "
    said += f"{MOST_PEAK:g}" + ("; `--law limit_observer` bears more" if found.many and law != "limit_observer" else "")
    return [("other people", f"{said}. {does}")]


def fingers_proposed(wanted: Wanted) -> int:
    """Return how many fingers to look at (both chosen): fewer over a range, where each takes seconds."""
    return 20 if wanted.speeds_mm_s or wanted.loads_n else 100


def finger(occluded: float) -> str:
    """Return the state of a finger in words."""
    return f"a moist finger (occluded {occluded:.0%})" if occluded > 0 else "a finger just landed"


def strokes_said(found: Sequence[Corner], wanted: Wanted) -> str:
    """Return slip lengths, speeds and loads in words, a range by its ends: slip length 0 to 11.5 um, 20 to 60 mm/s."""
    systems = [each.loop.system for each in found]
    lengths = lengths_of(found)
    speeds = [each.motion.speed_mm_s for each in systems if isinstance(each.motion, Strokes)]
    said = [f"slip length {range_said(lengths)} um"] if lengths else []
    said += [f"{range_said(speeds)} mm/s"] if speeds else []
    said += [f"pressed with {range_said(wanted.loads_n)} N"] if wanted.loads_n else []
    return ", ".join(said)


def lengths_of(found: Sequence[Corner]) -> list[float]:
    """Return the slip lengths of corners in um; none without a skin."""
    fingers = [each.loop.system.finger for each in found]
    return sorted({each.slip_length_um for each in fingers if isinstance(each, Skin)})


def range_said(values: Sequence[float]) -> str:
    """Return the ends of some values in words, one that all have alone."""
    low, high = min(values), max(values)
    return f"{low:g}" if low == high else f"{low:g} to {high:g}"
