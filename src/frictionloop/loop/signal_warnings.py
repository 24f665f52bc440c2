"""What Python warns of where it runs a system: signals read wrongly, strokes too short."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from frictionloop.findings import Condition, Finding
from frictionloop.parameters import Recording, Samples, Strokes, System
from frictionloop.quantities.units import SignalWarning

MEASURED = (Recording, Samples)


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
    from frictionloop.analysis.levels import misread
    from frictionloop.loop.run_findings import contact_turns

    there = [system.evolve({"motion.speed_mm_s": speed}) for speed in speeds_mm_s] or [system]
    turns = next(filter(None, (tuple(contact_turns(each)) for each in there)), ())
    return (*short_strokes(system), *misread(system, signals), *turns)


def signal_findings(system: System) -> Iterator[Finding]:
    """Yield what is in doubt of signals, and that strokes are too short for feedback."""
    yield from short_strokes(system)
    if isinstance(system.setpoint, MEASURED) or isinstance(system.disturbance, MEASURED):
        from frictionloop.analysis.levels import misread  # what few runs need, and what decides no number of any

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
