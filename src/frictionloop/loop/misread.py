"""What Python warns of where it runs a system, as the command line does: signals read wrongly, strokes too short."""

from __future__ import annotations

import warnings

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
    if short := no_feedback(system):
        warnings.warn(short, SignalWarning, stacklevel=3)
    if not isinstance(system.setpoint, MEASURED) and not isinstance(system.disturbance, MEASURED):
        return
    from frictionloop.analysis.levels import misread  # what few runs need, and what decides no number of any

    for each in misread(system):
        warnings.warn(each.in_python(), SignalWarning, stacklevel=3)


def no_feedback(system: System) -> str:
    """Return that the strokes are no longer than a turn takes, so that no law sees a valid reading; else empty."""
    turn_mm, motion = 2.0 * system.touch.load.developed_mm, system.motion
    if not isinstance(motion, Strokes) or motion.stroke_mm > turn_mm or system.controller.kind == "lookup":
        return ""
    stroke = f"motion.stroke_mm = {motion.stroke_mm:g} mm"
    return f"{stroke}: no feedback, a turn takes {turn_mm:g} mm (touch.load.developed_mm)"
