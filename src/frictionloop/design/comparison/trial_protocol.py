"""What every entrant is put through: the protocol of Section 4.2 on fingers nobody has tuned for; and who competes.

Three sines of 0.1 N and 1 Hz around 0.4, 0.6 and 0.8 N (paper, Sec. 4.2); the same levels held; steps between 0.35
and 0.75 N; and landings, a finger that lifts and lands once a second. A run is a second that does not count, then ten
periods of the sine, in strokes of 3 s and at most 240 mm; nothing counts on the way in which a finger's skin turns
over (`motion.unscored_n`), but ``turn_peak`` tells of it. Of every three fingers one meets a sensor whose resonance
is as the bench says, one 5 % below and one 5 % above; what the controller believes stays, unless it is one that is
told what each device's own ringing shows (`measured`).

Of the three devices that fingers meet, one has the bench's resonance and two are 5 % off; every law believes the
bench's, and has to bear what is there.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.analysis.operating_point import at_levels
from frictionloop.design import controller_synthesis
from frictionloop.design.operating_grid import OperatingGrid, with_longest_contact
from frictionloop.design.people_reach import with_own
from frictionloop.design.pi_synthesis import retune
from frictionloop.design.requirements import Requirements
from frictionloop.parameters import (
    RETUNED,
    Constant,
    PiController,
    Sine,
    Source,
    Steps,
    SuspendedSensor,
    System,
    bench,
    check_system,
)
from frictionloop.parameters.controller import CONTROLLERS, Timing
from frictionloop.parameters.motion import TURN_SHARE
from frictionloop.physics.fingers import Fingers, check_finger, fingers, nearest_to_median
from frictionloop.physics.reach import capable
from frictionloop.quantities import FrictionloopError, check_each_once, check_known, must_be

TUNING_SEED = 3
"""Seed of the fingers that laws may be tuned on, and of nothing that is scored."""
EVALUATION_SEED = 11
"""Seed of the fingers that are scored if no other is asked for."""
SMALL = 26
"""Fingers of the small population of reports and checks: the paper has as many trials in Fig. 1a."""
ORACLE = "oracle"
"""Name of the reference that knows the finger, where it competes."""
LOW_N, HIGH_N = 0.3, 0.9
"""Forces a capable finger can be given at its mean load (paper, Sec. 4.2)."""
LEVELS_N, AMPLITUDE_N, FREQUENCY_HZ = (0.4, 0.6, 0.8), 0.1, 1.0
STEP_LEVELS_N, STEP_EVERY_S = (0.35, 0.75), 0.5
"""Levels and pace of the steps (the levels are assumed, the pace is that of Fig. 5b)."""
SPEEDS_MM_S = (20.0, 80.0, 150.0)
START_S, DURATION_S = 1.0, 11.0
STROKE_S, STROKE_MM = 3.0, 240.0
"""Strokes last so long at most, and are as long as those of the report at most."""
RESONANCES = (1.0, 0.95, 1.05)
"""True resonance of finger 0, 1, 2, 3, ... over the bench's, in turn."""
LANDING = {"motion.contact_s": 1.0, "motion.lifted_s": 0.4}
"""Time on the plate and in the air of the landings (assumed)."""
SINES, HOLDS = (tuple(f"{kind} {level:g}" for level in LEVELS_N) for kind in ("sine", "hold"))
STEPPED, LANDINGS = "steps", "landings"
TASKS = (*SINES, *HOLDS, STEPPED, LANDINGS)
_FIT = ("r2_identity", "r2_regression", "slope", "output_noise", "mean_force", "mean_setpoint", "setpoint_spread")
_ALWAYS = ("rms_error", "saturation_index", "scored_periods")
TIMES = ("rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s")


class Condition(NamedTuple):
    """One thing that every entrant does on every finger."""

    speed_mm_s: float
    slip_length_um: float
    """Of every finger."""
    task: str


def setpoint_of(task: str, duration_s: float = DURATION_S) -> Source:
    """Return the set-point of a task."""
    if task == STEPPED:
        times = np.arange(0.0, duration_s, STEP_EVERY_S).round(9)
        return Steps(times_s=tuple(times.tolist()), levels_n=tuple(STEP_LEVELS_N[k % 2] for k in range(times.size)))
    if task == LANDINGS:
        return setpoint_of(SINES[1])
    kind, level = task.split()
    if kind == "hold":
        return Constant(offset_n=float(level))
    return Sine(offset_n=float(level), amplitude_n=AMPLITUDE_N, frequency_hz=FREQUENCY_HZ)


def stroke_mm(speed_mm_s: float) -> float:
    """Return how long strokes are: 60, 240 and 240 mm at 20, 80 and 150 mm/s."""
    return min(STROKE_MM, STROKE_S * speed_mm_s)


def metrics_of(task: str) -> tuple[str, ...]:
    """Return what is kept of a task."""
    if task in SINES:
        return (*_ALWAYS, "perceptual_index", *_FIT)
    return (*_ALWAYS, *(TIMES if task == STEPPED else ("perceptual_index", "turn_peak")))


METRICS = tuple(dict.fromkeys(name for task in TASKS for name in metrics_of(task)))


def overrides_of(condition: Condition, duration_s: float = DURATION_S) -> dict[str, Any]:
    """Return what a condition asks of a bench, for all fingers alike."""
    return {
        "setpoint": setpoint_of(condition.task, duration_s),
        "finger.slip_length_um": condition.slip_length_um,
        "motion.speed_mm_s": condition.speed_mm_s,
        "motion.stroke_mm": stroke_mm(condition.speed_mm_s),
        **(LANDING if condition.task == LANDINGS else {"motion.contact_s": 0.0}),
    }


def noise_seed(seed: int, task: str) -> int:
    """Return the seed of a task's tremor, roughness and noise: another for every task and for every population."""
    return (len(TASKS) * seed + TASKS.index(task)) % 2**63


def population(system: System, count: int, seed: int) -> Fingers:
    """Return the fingers that are scored, each with the resonance it meets; their slip length is the condition's.

    Raises
    ------
    FrictionloopError
        For the tuning seed, a count or a seed out of range, or a bench that is none.
    """
    check_system(system)
    check_finger(system)
    if seed == TUNING_SEED:
        raise must_be("seed", seed, "another than for tuning")
    people = without_lengths(fingers(count, seed))
    if system.sensor.kind != "suspended":
        return people
    shifts = [RESONANCES[i % len(RESONANCES)] * system.sensor.resonance_hz for i in range(len(people))]
    return Fingers(each | {"sensor.resonance_hz": shift} for each, shift in zip(people, shifts, strict=True))


def without_lengths(people: Fingers) -> Fingers:
    """Return fingers without a slip length of their own."""
    path = "finger.slip_length_um"
    return Fingers({name: value for name, value in each.items() if name != path} for each in people)


def lengths_of(system: System) -> tuple[float, ...]:
    """Return the slip lengths that are compared, um: both ends of what a design holds, the longer first."""
    return OperatingGrid(None).lengths_of(system)


def speeds_of(system: System, speeds_mm_s: Iterable[float]) -> tuple[float, ...]:
    """Return the speeds of the strokes, each one that the bench's sensors follow and the strokes leave room for.

    Raises
    ------
    FrictionloopError
        For no speed, one twice, or one out of range.
    """
    found = tuple(float(speed) for speed in speeds_mm_s)
    if not found or len(set(found)) < len(found):
        raise must_be("speeds", list(found), "at least one speed, none of them twice", "mm/s")
    touch = system.touch
    turning = STROKE_MM / (TURN_SHARE * system.motion.reversal_s)  # type: ignore[union-attr]
    least, most = touch.load.least_speed_mm_s, min(touch.position.fastest_mm_s, turning)
    for speed in found:
        if not (least <= speed <= most and speed > 0.0):
            raise must_be("speeds", speed, f"{'from' if least else 'above'} {least:g} to {most:.4g}", "mm/s")
    return found


def check_times(duration_s: float, start_s: float) -> None:
    """Refuse a duration that leaves nothing to score."""
    if not start_s < duration_s < math.inf:
        raise must_be("duration_s", duration_s, f"above {start_s:g} s", "s")


def able(system: System, people: Fingers, speed_mm_s: float, hold_s: float = DURATION_S) -> np.ndarray:
    """Return which fingers are capable at a speed: 0.3 and 0.9 N can be held at the mean load, shape (fingers,)."""
    return np.asarray(reached(system, people, speed_mm_s, hold_s)["capable"].values)


def reached(system: System, people: Fingers, speed_mm_s: float, hold_s: float = DURATION_S) -> xr.Dataset:
    """Return what `capable` says of fingers on the strokes of the protocol."""
    strokes = {"motion.speed_mm_s": speed_mm_s, "motion.stroke_mm": stroke_mm(speed_mm_s)}
    some = with_own(system, Fingers(strokes | each for each in people))
    largest_um = min(system.plate.max_amplitude_um, system.controller.model.max_amplitude_um)
    return capable(some, LOW_N, HIGH_N, max_amplitude_um=largest_um, contact_s=hold_s)


def median_finger(people: Fingers, some: np.ndarray) -> Mapping[str, Any] | None:
    """Return the finger of ``some`` that is `nearest_to_median`, as the report chooses its own; None without any."""
    return people[nearest_to_median(people, some)] if some.any() else None


STROKES = tuple(f"motion.{name}" for name in ("speed_mm_s", "stroke_mm", "contact_s", "lifted_s"))


def check_free(given: Iterable[str]) -> None:
    """Refuse values that the protocol, a finger or a law would replace, by dotted name.

    Raises
    ------
    FrictionloopError
        For the first of them.
    """
    one, timing = fingers(1, 0)[0], {f"controller.{name}" for name in Timing.model_fields}
    for path in given:
        whose = "finger" if path in one else "protocol" if path.startswith(("setpoint.", *STROKES)) else ""
        if path.startswith("controller.") and not path.startswith(tuple(timing)):
            whose = "law"
        if whose:
            raise FrictionloopError(f"{path}: the {whose} sets it")


Overrides = Mapping[str, Any]
Entrant = Callable[[System], Overrides]
"""From a bench to overrides of its controller. It may tune on fingers of `protocol.TUNING_SEED`, never on others."""


def printed_pi(system: System) -> Overrides:
    """Return the gains of the paper, Sec. 2.3."""
    printed = PiController()
    return {"controller.kind": "pi", "controller.kp": printed.kp, "controller.ki": printed.ki}


def retuned_pi(system: System) -> Overrides:
    """Return the gains of `RETUNED` on the bench they were made for, on another those that `retune` finds."""
    own = {path: value for path, value in RETUNED.items() if path.startswith("controller.")}
    plain = system.evolve(printed_pi(system))
    if plain == bench():
        return {"controller.kind": "pi", **own}
    return {"controller.kind": "pi", **retune(plain).overrides}


def designed(law: str, asked: Requirements | None = None) -> Entrant:
    """Return the entrant of a law in `SYNTHESES`, designed as `fl.design.controller` does unless asked otherwise."""

    def entrant(system: System) -> Overrides:
        levels = with_longest_contact(at_levels(system), ())
        return controller_synthesis.synthesised(levels, law, asked or Requirements())[0].overrides

    return entrant


DESIGN_S = {"notch_pi": 3.0, "limit_observer": 40.0, "hinf": 8.0}
"""Time of a synthesis in s (measured once)."""
DESIGNED = {law: designed(law) for law in DESIGN_S}
"""Those whose synthesis takes a while."""
ENTRANTS: dict[str, Entrant] = {
    "lookup": lambda system: {"controller.kind": "lookup"},
    "printed_pi": printed_pi,
    "retuned_pi": retuned_pi,
    **DESIGNED,
}
"""Every entrant by name; one more is one more line."""


def entrants(names: Iterable[str] | Mapping[str, Entrant] | None = None) -> dict[str, Entrant]:
    """Return entrants by name in the order asked for, all of them if None, a mapping as it is.

    Raises
    ------
    FrictionloopError
        For a name that no entrant has, with near ones, one given twice, or no name at all.
    """
    if isinstance(names, Mapping) and names:
        return dict(names)
    known = ENTRANTS | {kind: _from_outside(kind) for kind in sorted(CONTROLLERS.outside)}
    asked = list(known if names is None else names)
    check_known("laws", asked, known)
    check_each_once("laws", "law", asked)
    return {name: known[name] for name in asked}


def _from_outside(kind: str) -> Entrant:
    """Return a law from outside the package (`fl.register`) with the defaults of its own parameters."""
    fields = CONTROLLERS[kind].model_fields
    own = {name: field.get_default(call_default_factory=True) for name, field in fields.items()}
    gains = {f"controller.{name}": value for name, value in own.items() if name not in Timing.model_fields}
    return lambda system: {"controller.kind": kind} | gains


def on_device(system: System, factor: float) -> System:
    """Return a system whose sensor has its resonance times a factor; one without a resonance is as it was."""
    if not isinstance(system.sensor, SuspendedSensor):
        return system
    return system.evolve({"sensor.resonance_hz": factor * system.sensor.resonance_hz})
