"""What a device reads, sample by sample, without asking the plate for anything."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from frictionloop.device.addressed import opened
from frictionloop.quantities import must_be

if TYPE_CHECKING:
    from frictionloop.device.device import Device

MOST_HZ = 100.0


class Reading(NamedTuple):
    """A sample of a device."""

    time_s: float
    """By its ticks."""
    f_r_n: float
    f_m_n: float
    u_n: float
    a_um: float
    position_mm: float
    speed_mm_s: float
    load_n: float
    state: str
    """idle, open or closed; at a fault its name."""


def monitor(where: str | Device, duration_s: float = 10.0, rate_hz: float = 10.0) -> Iterator[Reading]:
    """Yield readings of a device as they come, at most 100 a second.

    Raises
    ------
    FrictionloopError
        For a rate or duration out of range, and as `connect`.
    """
    if not 0 < rate_hz <= MOST_HZ:
        raise must_be("rate_hz", rate_hz, f"above 0, at most {MOST_HZ:g}", "Hz")
    if not 0 < duration_s < math.inf:
        raise must_be("duration_s", duration_s, "above 0 and finite", "s")
    with opened(where) as device:
        from frictionloop.device.fault_codes import fault_name
        from frictionloop.device.recorder import fault_of, state_of
        from frictionloop.quantities.schema import named

        states, tick_hz = named("states"), device.info.tick_hz
        for block in device.stream(duration_s, max(round(tick_hz / rate_hz), 1)):
            faults, modes = fault_of(block["flags"]), state_of(block["flags"])
            for k, tick in enumerate(block["tick"]):
                fault, state = fault_name(int(faults[k])), str(states[int(modes[k])])
                yield Reading(
                    tick / tick_hz,
                    float(block["f_r"][k]),
                    float(block["f_m"][k]),
                    float(block["u"][k]),
                    float(block["a"][k]),
                    1e3 * float(block["position"][k]),
                    1e3 * float(block["speed"][k]),
                    float(block["load"][k]),
                    (state if fault == "none" else fault).replace("_", " "),
                )
