"""What a person should know of the signals of a run: read wrongly, recorded or too fast, and strokes too short."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, Strokes, SuspendedSensor, System, bench, feasible, paper
from frictionloop.parameters.motion import one_stroke_a_contact
from frictionloop.parameters.presets import stirring
from frictionloop.quantities.units import SignalWarning

if TYPE_CHECKING:
    import numpy as np

    from frictionloop.recordings.force_channel import Taken

MEASURED = (Recording, Samples)
SEVERAL = 2.0
"""Strokes of a contact from which on it is meant to be back and forth (chosen)."""


def warn_of_signals(system: System) -> None:
    """Warn of the recorded signals and arrays of a system in the name of who called ``simulate`` or ``sweep``.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    for each in signal_findings(system):
        warnings.warn(f"{each.code}: {in_python(each)}", SignalWarning, stacklevel=3)


def doubts(
    system: System, signals: Sequence[str] = ("setpoint", "disturbance"), speeds_mm_s: Sequence[float] = ()
) -> tuple[Finding, ...]:
    """Return what is in doubt of a System that runs: recorded signals, strokes too short, turns within contacts.

    Parameters
    ----------
    system
        What runs.
    signals
        Those of which recordings are looked at.
    speeds_mm_s
        Speeds that are swept, of which the first that turns within contacts is told.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    from frictionloop.analysis.operating_point import misread

    there = [system.evolve({"motion.speed_mm_s": speed}) for speed in speeds_mm_s] or [system]
    turns = next(filter(None, (tuple(contact_turns(each)) for each in there)), ())
    return (*short_strokes(system), *misread(system, signals), *turns)


def signal_findings(system: System) -> Iterator[Finding]:
    """Yield what is in doubt of signals, and that strokes are too short for feedback."""
    yield from short_strokes(system)
    if isinstance(system.setpoint, MEASURED) or isinstance(system.disturbance, MEASURED):
        from frictionloop.analysis.operating_point import (
            misread,  # what few runs need, and what decides no number of any
        )

        yield from misread(system)


def in_python(found: Finding) -> Finding:
    """Return a finding whose remedy is what Python calls."""
    return replace(found, remedy=f"evolve({found.remedy!r})") if isinstance(found.remedy, Mapping) else found


def short_strokes(system: System) -> Iterator[Finding]:
    """Yield that the strokes are no longer than a turn takes, so that no law sees a valid reading."""
    turn_mm, motion = 2.0 * system.touch.load.developed_mm, system.motion
    if isinstance(motion, Strokes) and motion.stroke_mm <= turn_mm and system.controller.kind != "lookup":
        where = Condition(channel="motion.stroke_mm")
        yield Finding("NO-FEEDBACK", value=motion.stroke_mm, unit="mm", limit=turn_mm, where=where)


UNLIKE = 0.7
"""Share of the finger's friction below which that of the recording is another's (chosen)."""
REMOVED = 0.02
"""Share of a recording (rms) from which on it is told that resampling removed it (chosen)."""
NAMED = 3
"""Most jumps that are named (chosen)."""


def recordings(system: System) -> dict[str, Taken]:
    """Return what was read of each recorded signal, by its name.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    signals = {name: getattr(system, name) for name in ("setpoint", "disturbance")}
    read = {name: each for name, each in signals.items() if isinstance(each, Recording)}
    if not read:
        return {}
    from frictionloop.recordings.force_channel import scaled

    return {name: scaled(each) for name, each in read.items()}


def of_recorded(system: System, duration_s: float) -> Iterator[Finding]:
    """Yield what is known of the recorded signals of a run of this length."""
    read = recordings(system)
    for name, taken in read.items():
        yield from (one for one in taken.findings if one.code in ("RESAMPLED", "TAKEN-FOR"))
        yield from _part(name, getattr(system, name), taken, duration_s)
        yield from _resampled(name, taken, system)
    if "disturbance" in read:
        yield from _another_finger(system, float(read["disturbance"].raw.mean()))
        yield from _jumps(system, read["disturbance"], duration_s)
    if "setpoint" in read and isinstance(system.sensor, SuspendedSensor):
        yield from _beyond_range(read["setpoint"].force, system.sensor.range_n)
    own = stirring(system)
    if own and any(isinstance(getattr(system, name), MEASURED) for name in ("disturbance", "setpoint")):
        yield Finding("RECORDED-ON-TOP", remedy=own)


def _beyond_range(force_n: np.ndarray, range_n: float) -> Iterator[Finding]:
    """Yield that the sensor cannot read a recorded set-point, which is known only from its file."""
    if (highest_n := float(force_n.max())) > range_n:
        share, where = 100.0 * float((force_n > range_n).mean()), Condition(recording="setpoint")
        yield Finding("RANGE-EXCEEDED", value=highest_n, unit="N", limit=range_n, where=where, more={"share": share})


def _part(name: str, signal: Recording, taken: Taken, duration_s: float) -> Iterator[Finding]:
    """Yield how much of a recording the run leaves out."""
    from frictionloop.recordings.force_channel import lasting_s

    lasts_s, where = lasting_s(signal), Condition(recording=name)
    if duration_s < lasts_s * (1 - 1e-6):
        cut = {f"{name}.stop_s": round(float(taken.part.at_s[0]) + duration_s, 9)} if signal.remove_mean else ""
        yield Finding("RECORDED-PART", value=duration_s, unit="s", limit=lasts_s, where=where, remedy=cut)


def _resampled(name: str, taken: Taken, system: System) -> Iterator[Finding]:
    """Yield how much of a recorded signal is faster than the control rate can hold, where that counts."""
    from frictionloop.recordings.sampling import removed_share

    rate_hz = system.controller.rate_hz
    share = removed_share(taken.force, taken.rate_hz, rate_hz, getattr(system, name).path)
    if share > REMOVED:
        yield Finding("TOO-FAST", value=100.0 * share, unit="%", limit=rate_hz / 2.0, where=Condition(recording=name))


def _another_finger(system: System, mean_n: float) -> Iterator[Finding]:
    """Yield that a recorded disturbance comes on a finger of another friction, or the law believes in another."""
    friction, model = system.friction, getattr(system.controller, "model", None)
    if system.controller.kind == "lookup" or model is None or not hasattr(friction, "nominal_n"):
        return
    own_n, where = friction.nominal_n, Condition(recording="disturbance")
    as_preset = own_n in {preset().friction.nominal_n for preset in (bench, feasible, paper)}
    if as_preset and 0.0 < mean_n < UNLIKE * own_n:
        yield Finding("RECORDED-FINGER", value=mean_n, unit="N", limit=own_n, where=where)
    if model.nominal_n != own_n:
        told = {"controller.model.nominal_n": own_n}
        yield Finding("BELIEF-FRICTION", value=own_n, unit="N", limit=model.nominal_n, where=where, remedy=told)


def _jumps(system: System, taken: Taken, duration_s: float) -> Iterator[Finding]:
    """Yield where the part of a recorded disturbance that runs jumps; not where contact is in doubt already."""
    from frictionloop.recordings.friction_defects import jumps
    from frictionloop.recordings.plausibility import on_plate

    signal: Any = system.disturbance
    if on_plate(signal, taken) is not None:
        return
    found = jumps(taken.force[: round(duration_s * taken.rate_hz)], taken.rate_hz)
    if found:
        at_s = tuple(round(float(taken.part.at_s[0]) + at / taken.rate_hz, 4) for at, _ in found)
        more = {"at_s": at_s[:NAMED], "jumps": len(found)}
        where = Condition(recording="disturbance")
        yield Finding("RECORDED-JUMPS", value=1e3 * found[0][1], unit="mN", where=where, more=more)


def contact_turns(system: System) -> Iterator[Finding]:
    """Yield that strokes end within contacts, and what makes each contact one stroke.

    Nothing of a finger that stays, goes back and forth within a contact, or turns in the air.
    """
    motion = system.motion
    if not isinstance(motion, Strokes) or motion.contact_s == 0.0:
        return
    half_s = 0.5 * motion.cycle_s
    if one_stroke_a_contact(motion) or motion.contact_s >= SEVERAL * half_s:
        return
    changes = motion.in_contacts()
    changes |= with_longer_stroke(changes["motion.stroke_mm"], system)
    rounded = {path: float(f"{value:.6g}") for path, value in changes.items()}
    where = Condition(speed_mm_s=motion.speed_mm_s)
    yield Finding("TURNS-IN-CONTACT", value=motion.contact_s, unit="s", limit=half_s, where=where, remedy=rounded)


def with_longer_stroke(stroke_mm: float, system: System) -> dict[str, float]:
    """Return what a stroke takes besides: a longer plate, and for a board the scale that reads all of it."""
    from frictionloop.firmware.board_compatibility import scale_for  # what few runs need

    longer = {"touch.load.length_mm": stroke_mm} if stroke_mm > system.touch.load.length_mm else {}
    return longer | scale_for(stroke_mm, system)
