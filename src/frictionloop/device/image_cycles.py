"""What the cycles of a tick go to, traced on an image in the emulator."""

from __future__ import annotations

import os
from importlib.util import find_spec


def cycles(image: str | os.PathLike[str]) -> dict[str, dict[str, int]] | None:
    """Return the cycles of a tick period by what they go to, for each assumption of the waits.

    None without the packages of the emulator. ``tick`` and ``interrupts`` are the most that was seen, ``background``
    the mean, ``sum`` all three; ``effect`` is the tick with the longest effect, ``flood`` the background of a host
    that never stops to ask, ``longest_interrupt`` what a tick may have to wait for.
    """
    if not (find_spec("unicorn") and find_spec("capstone")):
        return None
    from frictionloop.device.emulator import budget

    return budget.traced(image).table()
