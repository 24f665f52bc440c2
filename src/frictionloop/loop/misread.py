"""Signals that are probably read wrongly are warned of where Python runs them, as the command line asks about them."""

from __future__ import annotations

import warnings

from frictionloop.parameters import Recording, Samples, System
from frictionloop.quantities.units import SignalWarning

MEASURED = (Recording, Samples)


def warn_of_signals(system: System) -> None:
    """Warn of the recorded signals and arrays of a system in the name of who called ``simulate`` or ``sweep``.

    Raises
    ------
    FrictionloopError
        As `read_recording`.
    """
    if not isinstance(system.setpoint, MEASURED) and not isinstance(system.disturbance, MEASURED):
        return
    from frictionloop.analysis.levels import misread  # what few runs need, and what decides no number of any

    for each in misread(system):
        warnings.warn(each.in_python(), SignalWarning, stacklevel=3)
