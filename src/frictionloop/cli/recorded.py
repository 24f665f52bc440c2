"""What a person is told of a recorded signal besides what was read: the part that runs, and what comes on top."""

from __future__ import annotations

import textwrap

from frictionloop.analysis.levels import at_levels
from frictionloop.cli import recorded_jumps
from frictionloop.cli.scores import between
from frictionloop.parameters import (
    Constant,
    Recording,
    Samples,
    Sine,
    SuspendedSensor,
    System,
    bench,
    feasible,
    paper,
)
from frictionloop.parameters.still import stirring

WIDTH = 100
UNLIKE = 0.7
"""Share of the finger's friction below which that of the recording is another's (chosen)."""


def notes(system: System, duration_s: float) -> list[str]:
    """Return what is said of the recorded signals of a run of this length."""
    said = [_part(name, getattr(system, name), duration_s) for name in ("setpoint", "disturbance")]
    told = (
        *said,
        of_finger(system),
        recorded_jumps.said(system, duration_s) or uncut(system),
        beyond_range(system),
        on_top(system),
    )
    return [line for each in told for line in textwrap.wrap(each, WIDTH)]


def of_finger(system: System) -> str:
    """Return on top of which friction a recorded disturbance comes, which sets how much of it a loop leaves."""
    signal, friction = system.disturbance, system.friction
    if not isinstance(signal, Recording) or system.controller.kind == "lookup" or not hasattr(friction, "nominal_n"):
        return ""
    from frictionloop.recordings.told import found

    believed_n = getattr(getattr(system.controller, "model", None), "nominal_n", friction.nominal_n)
    table = f"for which the lookup table is made (controller.model.nominal_n = {believed_n:g} N)"
    if believed_n != friction.nominal_n:
        table = f"and the lookup table is made for {believed_n:g} N, another finger: --controller.model.nominal_n "
        table += f"{friction.nominal_n:g} makes it for this one"
    mean_n = found(signal).raw_mean_n
    said = f"The recorded disturbance comes on a finger of friction.nominal_n = {friction.nominal_n:g} N, {table}. The "
    said += f"mean in the file is {mean_n:.3g} N, the zero of its sensor included"
    as_preset = friction.nominal_n in {each().friction.nominal_n for each in (bench, feasible, paper)}
    if as_preset and 0.0 < mean_n < UNLIKE * friction.nominal_n:
        said += ". Has the recorded finger less friction? Give finger and table its own, --friction.nominal_n F "
        said += "--controller.model.nominal_n F, and a set-point that it can be given"
    return f"{said}."


def uncut(system: System) -> str:
    """Return that all of a recorded disturbance counts; empty of one that was cut, or whose cut was asked about."""
    signal = system.disturbance
    if not isinstance(signal, Recording) or signal.start_s is not None or signal.stop_s is not None:
        return ""
    from frictionloop.recordings.told import found

    if found(signal).on_plate_s is not None:
        return ""
    return (
        "The recorded disturbance is used uncut: landing, rests and lifting count as friction where it has them. "
        "--disturbance.start_s and --disturbance.stop_s cut out the slide."
    )


def beyond_range(system: System) -> str:
    """Return that the sensor cannot read a recorded set-point, which is known only from its file; empty if it can."""
    if not (isinstance(system.setpoint, Recording) and isinstance(system.sensor, SuspendedSensor)):
        return ""
    from frictionloop.recordings.told import found

    highest_n, range_n = found(system.setpoint).highest_n, system.sensor.range_n
    if highest_n <= range_n:
        return ""
    ends = f"the sensor's range ends at sensor.range_n = {range_n:g} N."
    return f"The recorded setpoint reaches {highest_n:.3g} N, and {ends}"


def _part(name: str, signal: object, duration_s: float) -> str:
    """Return how much of a recording the run leaves out, if it does."""
    if not isinstance(signal, Recording):
        return ""
    from frictionloop.recordings.read import lasting_s
    from frictionloop.recordings.told import found

    lasts_s = lasting_s(signal)
    if duration_s >= lasts_s * (1 - 1e-6):
        return ""
    said = f"The run takes the first {duration_s:g} s of the {lasts_s:.4g} s of the recorded {name}."
    if signal.remove_mean:
        stop_s = found(signal).from_s + duration_s
        said += f" The mean of all of it is removed; --{name}.stop_s {stop_s:g} removes that of the part that runs."
    return said


def at_design(system: System) -> list[str]:
    """Return what of a recorded signal counts where a controller is designed or checked."""
    levels, said = at_levels(system), []
    for name in ("setpoint", "disturbance"):
        if not isinstance(getattr(system, name), (Recording, Samples)):
            continue
        level, taken = getattr(levels, name), "its level"
        if isinstance(level, Constant):
            taken = f"its level, {level.offset_n:.3g} N,"
        if isinstance(level, Sine):
            low_n, high_n = level.offset_n - level.amplitude_n, level.offset_n + level.amplitude_n
            taken = f"its levels, {between(low_n, high_n)},"
        said.append(
            f"From the recorded {name} this takes {taken} alone; `simulate` with the controller says what the loop "
            "makes of it."
        )
    return said


def on_top(system: System) -> str:
    """Return that the bench's finger varies by itself too, and how a recording alone is had; empty if it does not."""
    recorded = [name for name in ("disturbance", "setpoint") if isinstance(getattr(system, name), (Recording, Samples))]
    flags = [f"--{path} {value:g}" for path, value in stirring(system).items()]
    if not recorded or not flags:
        return ""
    said = {
        "disturbance": "The recorded disturbance comes on top of this finger's own tremor, drift and roughness. It",
        "setpoint": "This finger's own tremor, drift and roughness count in the error. The recorded setpoint",
    }[recorded[0]]
    return f"{said} is alone with {' '.join(flags)}"
