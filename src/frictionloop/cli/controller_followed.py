"""How well a designed controller follows the set-point of its own file: stable is not yet good."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np

from frictionloop.analysis.linear import linearise
from frictionloop.cli import screen
from frictionloop.cli.served import LATER
from frictionloop.design.over import at_speed
from frictionloop.loop.metrics import kept, rms_error
from frictionloop.loop.open_loop import OPENED
from frictionloop.loop.simulate import simulate
from frictionloop.parameters import PiController, Recording, Strokes, System
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.read import read_held

PRINTED = PiController()
"""With the gains that the paper prints."""
SECONDS = 10.0
"""Of signal that are simulated, the time of a default run; less where a recording ends before."""
LEAST_S = 1.0
"""A recording that is shorter says nothing."""


class Followed(NamedTuple):
    """RMS of f_a - f_r, N, on the finger, contact, speed and set-point of the system."""

    seconds: float
    rms_error_n: float
    before_rms_error_n: float
    """The same with the controller that the system had."""
    open_loop_rms_error_n: float
    """The same with the lookup table alone, in open loop."""
    setpoint_rms_n: float
    """Of the set-point itself about its mean: what a force leaves that stays there."""
    rms_error_n_at_mm_s: dict[float, float]
    """As the first at the slowest and the fastest speed asked for, but for that of the system; NaN: not known."""


def followed(before: System, after: System, speeds_mm_s: Collection[float] = ()) -> Followed | None:
    """Return how well the set-point is followed, by simulation; None of a recording that is too short.

    Also at the ends of ``speeds_mm_s``, of a system with strokes.
    """
    seconds = min(SECONDS, *(_seconds(each, after.controller.rate_hz) for each in (after.setpoint, after.disturbance)))
    if seconds < LEAST_S:
        return None
    alone = after.evolve(OPENED)
    runs = [simulate(each, seconds, seed=0) for each in (after, before, alone)]
    asked = runs[0]["f_r"].values[kept(runs[0], None)]
    asked_n = float(np.std(asked - asked[0]))  # exactly 0 of a constant
    error_n, before_n, alone_n = (float(rms_error(run)) for run in runs)
    return Followed(seconds, error_n, before_n, alone_n, asked_n, _at_speeds(after, speeds_mm_s, seconds))


def _at_speeds(system: System, speeds_mm_s: Collection[float], seconds: float) -> dict[float, float]:
    """Return the error at the slowest and the fastest, where a finger in contacts of one stroke lifts in time with it.

    NaN where a motion cannot be simulated so.
    """
    motion = system.motion
    if not isinstance(motion, Strokes):
        return {}
    found, own = {}, motion.speed_mm_s
    for each in sorted({end(speeds_mm_s, default=own) for end in (min, max)} - {own}):
        try:
            found[each] = float(rms_error(simulate(at_speed(system, each), seconds, seed=0)))
        except FrictionloopError:  # of a stroke without a plateau, say
            found[each] = math.nan
    return found


def _seconds(signal: Any, rate_hz: float) -> float:
    """Return how long a run of a signal may be."""
    if isinstance(signal, Recording):
        return (read_held(signal, rate_hz).size - 1) / rate_hz
    return float(signal.longest_s)


def _rings(system: System) -> str:
    """Return that a loop is unstable; nothing of one that is stable, or has no linear analysis."""
    try:
        return "" if linearise(system).is_stable() else ", which is unstable here"
    except FrictionloopError:
        return ""


def followed_text(before: System, found: Followed | None, unbelieved: str = "") -> list[Any]:
    """Return it for a person; ``unbelieved`` says what of the finger the lookup table does not know."""
    if found is None:
        return [
            screen.wrapped(f"how the set-point is followed is not known: a recording is shorter than {LEAST_S:g} s")
        ]
    motion: Any = before.motion
    at = f", slip length {before.finger.slip_length_um:g} um" if hasattr(before.finger, "slip_length_um") else ""
    at += f", {motion.speed_mm_s:g} mm/s" if hasattr(motion, "speed_mm_s") else ""
    head = f"how the set-point ({before.setpoint.kind}) is followed, {found.seconds:.3g} s of this finger simulated{at}"
    if getattr(motion, "contact_s", 0.0):
        head += f"; it is dry at first. Contact upon contact: simulate it with {LATER}"
    law: Any = before.controller
    gains = f" (kp {law.kp:.4g}, ki {law.ki:.4g} 1/s)" if isinstance(law, PiController) else ""
    printed = isinstance(law, PiController) and (law.kp, law.ki) == (PRINTED.kp, PRINTED.ki)
    whose = "the gains that the paper prints" if printed else "the controller that was there"
    ends = [
        f"not known at {each:g} mm/s" if math.isnan(error_n) else f"{1e3 * error_n:.3g} mN at {each:g} mm/s"
        for each, error_n in found.rms_error_n_at_mm_s.items()
    ]
    rows = [
        ("error", f"{1e3 * found.rms_error_n:.3g} mN", "; ".join(["rms of f_a - f_r with this law", *ends])),
        (
            "open loop",
            f"{1e3 * found.open_loop_rms_error_n:.3g} mN",
            "with the lookup table alone" + "; it believes another friction, see below" * bool(unbelieved),
        ),
        (
            "before",
            f"{1e3 * found.before_rms_error_n:.3g} mN",
            f"with {whose}, {law.kind}{gains}{_rings(before)}",
        ),
    ]
    if found.setpoint_rms_n > 0.0:
        asked = f"{1e3 * found.setpoint_rms_n:.3g} mN"
        rows.append(("set-point", asked, "its own rms about its mean, which a force that stays there leaves"))
    return [screen.wrapped(head), screen.columns(rows)]
