"""A controller that was checked, as a person and as a program is shown it: the verdict and what would hold."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from frictionloop.analysis.stability import ringing_hz
from frictionloop.cli.check_fingers import NONE_LEFT
from frictionloop.cli.comparison_text import number
from frictionloop.cli.controller_holds import beyond_reach, finger, fingers_proposed, other_people, places_of
from frictionloop.cli.controller_text import gain_rows, turn, wanted_json
from frictionloop.cli.controller_verdict import HEAVIER, LIGHTER, NOT_HELD, but
from frictionloop.cli.scores import between
from frictionloop.design.corners import at_mean
from frictionloop.design.elsewhere import alike
from frictionloop.design.synthesis import SYNTHESES
from frictionloop.parameters import Strokes
from frictionloop.perception.thresholds import LOWEST_HZ

if TYPE_CHECKING:
    from frictionloop.design.checking import Checked
    from frictionloop.design.corners import Corner
    from frictionloop.design.elsewhere import How, Place
    from frictionloop.design.wanted import Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
WORST_FIRST: tuple[tuple[str, How], ...] = (*NOT_HELD, ("HOLDS", "within"))
EACH_S: dict[str, tuple[float, float]] = {"pi": (0.008, 0.04), "lookup": (0.008, 0.04)}
"""Time to check a loop, s: on an idle core with many loops, and on a busy one with few (assumed)."""
OTHER_S = (0.012, 0.08)
"""The same of laws with a notch, a model or an observer (assumed)."""
FINGERS_S: dict[str, tuple[float, float]] = {"pi": (0.002, 0.012)}
"""The same of loops of other people's fingers, which share a grid of frequencies (assumed)."""
OTHER_FINGERS_S = (0.006, 0.03)
"""The same of other laws (assumed)."""
DESIGN_S: dict[str, tuple[float, float]] = {"pi": (0.014, 0.06), "notch_pi": (0.027, 0.12)}
"""Time to design and to check a loop, s: on an idle core, and on a busy one (assumed)."""
OTHER_DESIGN_S = (0.05, 0.2)
"""The same of laws that are searched for longer (assumed)."""


def verdict(
    found: Checked, system: System, wanted: Wanted, given: str, moist: str = "", designed: str = "",
    fingers: Sequence[Row] = (),
) -> list[Row]:  # fmt: skip
    """Return rows of the verdict: holds or not, where and by how much, what would hold, and what else to look at.

    ``designed`` says what of that for which the file was designed is left out, ``fingers`` are the rows of others.
    """
    count, held = len(found.places), sum(place.how == "within" for place in found.places)
    every, some = ("every", f"{count - held} of {count}") if count > 1 else ("the", "the")
    many, load = "s" * (count > 1), pressed(system, wanted)
    rows: list[Row] = [
        ("HOLDS", f"at {every} slip length and speed looked at{load}")
        if found.holds
        else ("DOES NOT HOLD", f"at {some} slip length{many} and speed{many} looked at{load}")
    ]
    corners = [corner for place in found.places for corner in place.corners]
    states = sorted({each.loop.elements.occluded for each in corners})
    beyond = beyond_reach(places_of(corners), states)
    if found.holds:
        rows = [("HOLDS", but([*beyond, *fingers], moist) + rows[0][1])]
    elif found.holds_as_asked:
        worse = [(name, "") for name, how in NOT_HELD if any(place.how == how for place in found.places)]
        rows = [("HOLDS", f"{but([*beyond, *worse, *fingers], moist)}{_asked(system, wanted)}{load}")]
    for name, how in WORST_FIRST:
        groups = alike(place for place in found.places if place.how == how)
        first = "" if found.holds else name
        rows += [
            (first if k == 0 else "", ": ".join(filter(None, (where, _by_how_much(place)))))
            for k, (where, place) in enumerate(groups)
        ]
    forces = [each.loop.elements.force_n for each in corners]
    rows += [
        *beyond,
        *fingers,
        ("looked at", f"{between(min(forces), max(forces))}; {' and '.join(map(finger, states))}"),
    ]
    rows += [*(("note", note) for note in found.notes), *_would_hold(found, system, wanted, given, load)]
    does = "counts the fingers on which the limits hold, and names gains for more of them"
    rows += [] if fingers else other_people(found.people, found.law, f"`--fingers {fingers_proposed(wanted)}` {does}")
    if designed:
        return [*rows, ("by the file", designed)]
    return [*rows, *_other_loads(system, wanted)]


def _asked(system: System, wanted: Wanted) -> str:
    """Return which slip lengths and speeds were asked for: those of the flags, else the speed of the file."""
    motion = system.motion
    if wanted.speeds_mm_s or not isinstance(motion, Strokes):
        return "at every slip length and speed asked for"
    return f"at {motion.speed_mm_s:g} mm/s, the speed given, on every contact looked at"


def pressed(system: System, wanted: Wanted) -> str:
    """Return with which load all that was looked at is pressed, behind a comma; nothing without strokes."""
    if not isinstance(system.motion, Strokes):
        return ""
    low, high = min(wanted.loads_n, default=system.motion.load_n), max(wanted.loads_n, default=system.motion.load_n)
    return f", pressed with {low:.3g} N alone" if low == high else f", pressed with {low:.3g} to {high:.3g} N"


def _other_loads(system: System, wanted: Wanted) -> list[Row]:
    """Return the row with the flag that looks at other loads, where one alone was looked at."""
    if wanted.loads_n or not isinstance(system.motion, Strokes):
        return []
    low, high = (factor * system.motion.load_n for factor in (LIGHTER, HEAVIER))
    return [("other loads", f"nobody presses evenly: `--loads {low:.2g},{high:.2g}` looks at such a range")]


def _by_how_much(place: Place) -> str:
    """Return how far the worst corner is beyond its limit, and at which frequency."""
    if place.how == "within":
        return ""
    worst, margins = place.worst, place.worst.margins
    if place.how == "unstable":
        rings = ringing_hz([worst.loop])
        return "" if rings is None else f"starts to ring near {rings:.3g} Hz"
    said = [f"the limit is {worst.limit:.3g}"]
    if math.isfinite(margins.gain_margin):
        said.append(f"gain margin {margins.gain_margin:.3g} at {margins.phase_crossover_hz:.3g} Hz")
    if math.isfinite(margins.phase_margin_deg):
        said.append(f"phase margin {turn(margins.phase_margin_deg, ' deg of')} at {margins.crossover_hz:.3g} Hz")
    return ", ".join(said)


def _would_hold(found: Checked, system: System, wanted: Wanted, given: str, load: str) -> list[Row]:
    """Return rows on what would hold at all places, or how much room is left."""
    gain = min(found.gains)
    if found.holds:
        room = f"for the file's finger the gain of the loop may be {number(gain)} times as high, and any lower{load}"
        room = f"none: with a higher gain of the loop a place is beyond its limits{load}" if gain < NONE_LEFT else room
        return [("room", room)] if math.isfinite(gain) else []
    law = f" --law {found.law}" if found.law in SYNTHESES and found.law not in ("pi", "notch_pi") else ""
    searched = f"`frictionloop design controller {given}{law}` searches for a controller"
    if "controller.kp" in found.instead:
        kp, ki = (found.instead[f"controller.{name}"] for name in ("kp", "ki"))
        most = ([f"kp at most {kp:.4g}"] if kp else []) + ([f"ki at most {ki:.4g} 1/s"] if ki else [])
        said = " with ".join(most) + (", in this ratio" if kp and ki else "")
        searched = f"another ratio may leave less: {searched}" if kp or ki else searched
    elif found.instead:
        said = ", ".join(f"{path.removeprefix('controller.')} = {value:.3g}" for path, value in found.instead.items())
    else:
        return [("would hold", f"nothing was found by less gain alone; {searched}")]
    left = abs(at_mean(system.evolve(dict(found.instead))).responses(LOWEST_HZ)["S"][0])
    too = ", the slower and faster places too" if found.holds_as_asked else ""
    said += f": everywhere in the table{too}{load}; it leaves {left:.0%} of a disturbance at {LOWEST_HZ:g} Hz"
    return [("would hold", said), ("", searched)]


def takes(loops: int, each_s: tuple[float, float]) -> str:
    """Return how long so many loops take, in words, from the shortest and the longest time for one."""
    short_s, long_s = (each * loops for each in each_s)
    if long_s < 100.0:
        return f"from {max(short_s, 1.0):.0f} to {max(long_s, 2.0):.0f} s"
    return f"from {max(short_s / 60.0, 0.5):.2g} to {long_s / 60.0:.2g} minutes"


def controller_rows(system: System) -> list[Row]:
    """Return the law and its values; of the rest of the controller nothing."""
    shown = {"kind", "rate_hz", "delay_s", "jitter_s", "lost_ticks", "open_until_s", "form", "model"}
    own = {f"controller.{name}": value for name, value in system.controller if name not in shown}
    return [("law", system.controller.kind), *gain_rows(own)]


def as_json(found: Checked, system: System, wanted: Wanted) -> dict[str, Any]:
    """Return everything by name, SI units."""
    return {
        "law": found.law,
        "holds": found.holds,
        "holds_as_asked": found.holds_as_asked,
        "would_hold": dict(found.instead),
        "places": [_place_json(place, gain) for place, gain in zip(found.places, found.gains, strict=True)],
        "not_looked_at": found.unseen,
        "notes": found.notes,
        "people": found.people and found.people._asdict(),
        "wanted": wanted_json(wanted),
        "system": system.model_dump(),
    }


def _place_json(place: Place, gain: float) -> Mapping[str, Any]:
    worst = place.worst
    return {
        "slip_length_um": place.slip_length_um,
        "speeds_mm_s": place.speeds_mm_s,
        "how": place.how,
        "gain_factor": gain,
        "worst": _corner_json(worst) | {"ringing_hz": ringing_hz([worst.loop]), **asdict(worst.margins)},
        "corners": [_corner_json(each) for each in place.corners],
    }


def _corner_json(corner: Corner) -> dict[str, Any]:
    at, motion = corner.loop.elements, corner.loop.system.motion
    return {
        "speed_mm_s": getattr(motion, "speed_mm_s", None),
        "force_n": at.force_n,
        "occluded": at.occluded,
        "resonance_off": corner.off,
        "limit": corner.limit,
        "sensitivity_peak": corner.sensitivity_peak,
    }
