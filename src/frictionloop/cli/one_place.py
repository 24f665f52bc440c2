"""The command that checks a controller, beside the answer of a sweep, which is no result yet."""

from __future__ import annotations

from collections.abc import Iterable

from frictionloop.cli.flags import scalar

WITHOUT_CHECK = {"lookup"}


def without(flags: Iterable[str] | None) -> str:
    """Return that a check leaves out the disturbance that is given with flags, which moves the forces it looks at."""
    return ", without this disturbance" * any(flag.startswith("disturbance.") for flag in flags or ())


def unasked(path: str, value: str) -> bool:
    """Tell whether a flag of runs is left out of the check that they name.

    The disturbance is, and a finger that is still so that a recording is alone: one that does not get moist would
    flatter the gains.
    """
    from frictionloop.parameters.still import STILL

    return path.startswith("disturbance.") or STILL.get(path) == scalar(value)
