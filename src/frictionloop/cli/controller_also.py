"""What a designed controller meets besides its corners: a finger fully moist, noise, the sensor's range, guesses."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from frictionloop.analysis import command_noise_rms_n, linearise, output_noise_rms_n
from frictionloop.analysis.operating import asked, law_at, reach_n
from frictionloop.analysis.reach import missed
from frictionloop.design.corners import corners, moistest
from frictionloop.design.elsewhere import NEAR
from frictionloop.parameters import FingerFriction, Strokes, SuspendedSensor
from frictionloop.parameters.motion import one_stroke_a_contact
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from pathlib import Path

    from frictionloop.analysis.linear import LinearLoop
    from frictionloop.design.wanted import Wanted
    from frictionloop.parameters import System

Row = tuple[str, ...]
TOLD = 0.05
"""Share by which the friction at the mean load is off what a law believes, from which it is told (chosen)."""
SETTLED = 3.0
"""Time constants after which occlusion is called complete: 95 %."""
MATTER = {
    "friction.nominal_n": "N", "friction.susceptibility_per_um2": "um^-2",
    "friction.occlusion_ratio": "", "friction.occlusion_s": "s", "friction.moist_loss": "",
    "plate.max_amplitude_um": "um",
    "sensor.cutoff_hz": "Hz", "sensor.q": "", "controller.delay_s": "s", "motion.load_n": "N",
    "motion.lifted_s": "s", "setpoint.offset_n": "N", "setpoint.amplitude_n": "N",
}  # fmt: skip
"""Values that move the gains of a design and that a bench is often described without, with their units."""

ASSUMED = "as in bench(), assumed unless it is yours"
"""Begins the line that lists those of them which nobody gave."""


def fully_moist(system: System, wanted: Wanted) -> str:
    """Return how the loop is on a finger that never lifts, once it is fully moist; empty of another."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)) or motion.contact_s > 0:
        return ""
    said = f"the file's finger at 100 % occlusion (not lifted for about {SETTLED * friction.occlusion_s:.3g} s)"
    there = wanted.over(3, 3).systems(system)
    beyond = [each for place in there for each in missed(place, [1.0])]
    if len(beyond) == sum(len(set(asked(place))) for place in there):
        forces = ", ".join(dict.fromkeys(f"{each.in_words[0]} N" for each in beyond))
        nearest = min(beyond, key=lambda each: abs(each.instead_n - each.force_n)).in_words[1]
        lift = "" if any(missed(place, [0.0]) for place in there) else ", or lift the finger before"
        return (
            f"{said}: {forces} are out of reach, {nearest} N is the nearest: the command stays at its limit, and no "
            f"loop is closed; ask for another force{lift}"
        )
    try:
        found = corners(system, wanted.limits, wanted.over(3, 3), states=(1.0,))
    except FrictionloopError as error:
        return f"{said} cannot be looked at: {error}"
    unstable = [each.off for each in found if math.isinf(each.sensitivity_peak)]
    if unstable:
        how = f"{said}: UNSTABLE{off_said(min(unstable, key=abs))}"
        dry = [each for each in there if _rings(each, wanted)]
        if dry:
            return f"{how}, as on a finger just landed{_contact(dry, there)}"
        return f"{how}: lift the finger before, or give `motion.contact_s`"
    worst = max(found, key=lambda each: each.excess)
    how = "CLOSE TO UNSTABLE" if worst.sensitivity_peak > NEAR else "stable"
    return (
        f"{said}: {how}, Ms is {worst.sensitivity_peak:.3g}{off_said(worst.off)}; {worst.limit:.3g} is the limit of a "
        "finger that lifts in time"
    )


def _rings(system: System, wanted: Wanted) -> bool:
    """Tell whether a loop is unstable on a finger just landed, at the place of the system."""
    return any(math.isinf(each.sensitivity_peak) for each in corners(system, wanted.limits, states=(0.0,)))


def moist_row(system: System, wanted: Wanted, said: str, people: bool) -> list[Row]:
    """Return the row of a verdict with that line, or with what a moist finger is that lands again and again.

    ``people``: other people's fingers were looked at, which are not fully moist.
    """
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return []
    if said:
        stays = f"`--motion.contact_s {SETTLED * friction.occlusion_s:.3g}` looks at the other fingers so"
        less = "which are less moist above: run it if people stay on the plate"
        return [("fully moist", said), *([("", f"{stays}, {less}")] if people else [])]
    one, many = -math.expm1(-motion.contact_s / friction.occlusion_s), moistest(friction, motion)
    return [
        (
            "moist",
            f"contacts of {motion.contact_s:.4g} s{_of_slowest(motion, wanted)}, {motion.lifted_s:g} s apart, in the "
            f"end leave a finger {many:.0%} occluded, a single one {one:.0%}{_slowest(motion, wanted)}",
        )
    ]


def _of_slowest(motion: Strokes, wanted: Wanted) -> str:
    """Return whose contacts were looked at, where each is a stroke and slower ones last longer; else nothing."""
    slowest = min(wanted.speeds_mm_s, default=motion.speed_mm_s)
    long = one_stroke_a_contact(motion) and slowest < motion.speed_mm_s
    return f", as long as a stroke at {slowest:.3g} mm/s" if long else ""


def _slowest(motion: Strokes, wanted: Wanted) -> str:
    """Return how long the slowest of strokes of one length lasts, where slower ones were looked at; else nothing."""
    slowest = min(wanted.speeds_mm_s, default=motion.speed_mm_s)
    if slowest >= motion.speed_mm_s or one_stroke_a_contact(motion):
        return ""
    stroke_mm = motion.contact_s * motion.speed_mm_s
    longest_s = stroke_mm / slowest
    return (
        f". At every speed a contact lasts {motion.contact_s:g} s here; if each is a stroke of {stroke_mm:.3g} mm, "
        f"the slowest lasts {longest_s:.3g} s and leaves the finger moister: `--motion.contact_s {longest_s:.4g}` "
        "looks at it"
    )


def _contact(some: Sequence[System], there: Sequence[System]) -> str:
    """Return the slip lengths that some systems have; nothing where they have all that are looked at."""
    found, every = ({getattr(each.finger, "slip_length_um", 0.0) for each in group} for group in (some, there))
    return f", slip length {' and '.join(f'{each:g}' for each in sorted(found))} um" if found != every else ""


def off_said(share: float) -> str:
    """Return how far the resonance is off, behind what is told; nothing where it is as described."""
    return f" with the resonance {100 * abs(share):.3g} % {'higher' if share > 0 else 'lower'}" if share else ""


def noise(loop: LinearLoop) -> Row:
    """Return the row of what the sensor's noise makes of force and command in a loop."""
    force, command = (1e3 * rms_n(loop) for rms_n in (output_noise_rms_n, command_noise_rms_n))
    from frictionloop.design.hinf import COMMAND_NOISE_N

    said = f"rms in the force, of this loop; {command:.3g} mN in the command"
    most = 1e3 * COMMAND_NOISE_N
    loud = f", more than the {most:g} mN that hinf is held to"
    return ("sensor noise", f"{force:.3g} mN", said + loud * (command > most))


def noisy(after: System) -> str:
    """Return a line where the sensor's noise makes more of the command than a synthesis may; else nothing."""
    from frictionloop.design.hinf import COMMAND_NOISE_N

    command_n = command_noise_rms_n(linearise(after))
    if command_n <= COMMAND_NOISE_N:
        return ""
    other = ". Try `--law pi` too; `frictionloop sweep FILE --fingers 100` of both has rms_error and perceptual_index"
    return (
        f"the sensor's noise makes {1e3 * command_n:.3g} mN rms of the command, which touch feels and which strays "
        f"into its limits{other * (after.controller.kind != 'pi')}"
    )


def range_said(system: System, wanted: Wanted) -> str:
    """Return a line where friction without vibration exceeds the range of the sensor; empty where it does not.

    That is of the moistest finger, pressed with the largest load that is looked at.
    """
    friction, motion = system.friction, system.motion
    if not isinstance(system.sensor, SuspendedSensor):
        return ""
    who, state = "the finger", 0.0
    if isinstance(friction, FingerFriction):
        who, state = "a fully moist finger", 1.0
    if isinstance(motion, Strokes):
        load_n = max(wanted.loads_n, default=motion.load_n)
        there, pressed = system.evolve({"motion.load_n": load_n}), f" pressed with {load_n:g} N"
        if state and isinstance(friction, FingerFriction) and motion.contact_s > 0:
            state = moistest(friction, motion)
            who = f"a finger {state:.0%} occluded"
    else:
        there, pressed = system, ""
    top_n, range_n = reach_n(there, law_at(there, state))[1], system.sensor.range_n
    if top_n <= range_n:
        return ""
    return (
        f"{who}{pressed} has {top_n:.3g} N without vibration, as with the loop off, and sensor.range_n is "
        f"{range_n:.3g} N; the board stops with a fault when its sensor saturates"
    )


def unbelieved(system: System) -> str:
    """Return a line where a law believes the friction at the reference load, of a finger with another; or nothing."""
    friction, motion, model = system.friction, system.motion, system.controller.model
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return ""
    there_n = law_at(system.evolve({"motion.speed_mm_s": friction.reference_speed_mm_s})).nominal_n
    if model.nominal_n != friction.nominal_n or abs(there_n / friction.nominal_n - 1.0) < TOLD:
        return ""
    ratio = there_n / model.nominal_n
    same = f"; kp and ki times {ratio:.3g} are then the same loop" if hasattr(system.controller, "kp") else ""
    return (
        f"the law believes {model.nominal_n:.3g} N without vibration, that of friction.reference_load_n = "
        f"{friction.reference_load_n:g} N; at the motion.load_n of this file the finger has {there_n:.3g} N, which "
        f"`--controller.model.nominal_n {there_n:.3g}` tells it{same}"
    )


def never_moist(system: System) -> list[str]:
    """Return a line on a finger whose friction moisture does not change; none of another."""
    friction = system.friction
    if not isinstance(friction, FingerFriction) or (friction.occlusion_ratio, friction.moist_loss) != (1.0, 0.0):
        return []
    return [
        "this finger does not get moist (friction.occlusion_ratio = 1, moist_loss = 0): what is said of a moist one "
        "says nothing of a real finger"
    ]


def replaced(given: Collection[str], before: System, after: System) -> str:
    """Return a line with what of the controller was given as flags and the design sets itself; empty without any."""
    names = [path.removeprefix("controller.") for path in given if path.startswith("controller.")]
    values = {name: getattr(after.controller, name, None) for name in names if name != "kind" and "." not in name}
    own = [f"controller.{name} = {value}" for name, value in values.items()
           if value is not None and value != getattr(before.controller, name, None)]  # fmt: skip
    return f"the design sets what was given otherwise: {', '.join(own)}" if own else ""


def assumed(system: System, stated: Collection[str]) -> str:
    """Return a line with what is as in `bench()`, which is assumed, and moves the gains; empty if all is given.

    What is ``stated``, by dotted name, is somebody's own whatever its value.
    """
    same = _as_usual(system, stated)
    if not getattr(system.motion, "contact_s", 0.0):  # a finger that never lifts
        same.pop("motion.lifted_s", None)
    return f"{ASSUMED}: {', '.join(same.values())}" if same else ""


def assumed_in_file(system: System, stated: Collection[str]) -> str:
    """Return the same line for the head of a file that is written whole, from which `given_in` tells them again."""
    return f"{ASSUMED}: {', '.join(_as_usual(system, stated).values()) or 'none'}"


def given_in(file: Path | None) -> set[str]:
    """Return those of the values that matter which somebody gave, by the head of a file that a design or check wrote.

    The file itself is written whole. Empty of any other file.
    """
    said = next((each for each in (head_of(file) if file else ()) if each.startswith(ASSUMED)), None)
    return set() if said is None else {path for path in MATTER if f" {path} = " not in said}


def _as_usual(system: System, stated: Collection[str]) -> dict[str, str]:
    """Return what is as in `bench()` and not stated, in words by dotted name."""
    from frictionloop.parameters import bench

    own, usual = _values(system), _values(bench())
    return {path: f"{path} = {own[path]:g} {unit}".rstrip() for path, unit in MATTER.items()
            if path in own and own[path] == usual.get(path) and path not in stated}  # fmt: skip


def head_of(file: Path) -> list[str]:
    """Return the comment lines of a file."""
    lines = file.read_text(encoding="utf-8-sig").splitlines()
    return [line.removeprefix("# ") for line in lines if line.startswith("# ")]


def _values(system: System) -> dict[str, Any]:
    blocks = system.model_dump()
    return {f"{name}.{key}": value for name in blocks if isinstance(blocks[name], dict)
            for key, value in blocks[name].items()}  # fmt: skip
