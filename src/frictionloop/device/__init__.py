"""Talk to a board: what is there, its parameters, a run or an effect on it, its image.

list_ports  info  monitor    what is on a port, who answers, what it reads
configure  clear             parameters by name, gains among them; a fault cleared
run  play  recover           a controller or an effect, recorded; what a killed recording left
flash  instructions          an image onto a board, and what its ticks cost
connect  Device              the board itself
"""

from __future__ import annotations

from frictionloop.quantities.lazily import lazily

HOMES = {
    "board_info": "Cleared DeviceInfo Differing Port Ports Reading clear info list_ports monitor opened",
    "configured": "Configured configure",
    "measured_run": "DevicePlay DeviceRun play run",
    "recovered_file": "Recovered recover",
    "flashed": "Flashed flash instructions",
    "device": "Device connect",
}
__getattr__ = lazily(__name__, HOMES)
__all__ = [name for names in HOMES.values() for name in names.split()]


def __dir__() -> list[str]:
    return sorted(__all__)
