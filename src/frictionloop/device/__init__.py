"""Talk to a board: what is there, its parameters, a run or an effect on it, its image.

list_ports  info  monitor    what is on a port, who answers, what it reads
configure  clear             parameters by name, gains among them; a fault cleared
run  play  recover           a controller or an effect, recorded; what a killed recording left
flash  instructions          an image onto a board, and what its ticks cost
connect  Device              the board itself
"""

from __future__ import annotations

from frictionloop.quantities.optional_libraries import lazily

HOMES = {
    "board_discovery": "Cleared DeviceInfo Differing Port Ports Reading clear info list_ports monitor opened",
    "parameter_setting": "Configured configure",
    "run_accuracy": "DevicePlay DeviceRun play run",
    "recovered_file": "Recovered recover",
    "flashed": "Flashed flash instructions",
    "device": "Device connect",
}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
