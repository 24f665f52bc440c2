"""Speed of the firmware on this machine: its core called by Python, the whole of it at a simulated bench, its image.

`python benchmarks/firmware.py`. A tick of the core is law, lookup and overdrive; asked are 500 000 ticks/s. At a
bench a tick is the whole firmware and the plant; asked of the emulated image are the 5000 ticks/s of real time.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.firmware.compiled_core import host_library
from frictionloop.firmware.image import build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities import flat_tuples

TICKS, ROUNDS = 200_000, 7
ASKED_PER_S = 500_000
SECTION = (0.98, -1.9, 0.93, -1.9, 0.91)
AHEAD = {"model": fl.bench().controller.model, "delay_s": 330e-6, "feedforward": True, "overdrive": True}
CONTROLLERS = {
    "PI": fl.bench().controller,
    "lookup": fl.LookupController(),
    "notch, fed forward, overdriven": fl.NotchPiController(**AHEAD),
    "limit observer": fl.LimitObserverController(model=fl.bench().controller.model, delay_s=200e-6),
    "six sections, fed forward, overdriven": fl.FilteredPiController(sections=(SECTION,) * 6, **AHEAD),
}


def shortest(work: Callable[[], None]) -> float:
    """Seconds of the quickest of some rounds."""
    seconds = []
    for _ in range(ROUNDS):
        start = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - start)
    return min(seconds)


def speed(controller: fl.PiController) -> float:
    """Ticks per second of law, lookup and overdrive."""
    law, rng = law_of(controller), np.random.default_rng(0)
    ffi, library = host_library(law, controller.rate_hz)
    words = firmware_words(fl.bench().evolve({"controller": controller}))
    rows, setpoints = rng.uniform(0.0, 1.0, (TICKS, 5)), rng.uniform(0.0, 1.0, TICKS)
    rows[:, 4] = 1.0
    states, out = np.empty((TICKS, flat_tuples.size(law.state))), np.empty((TICKS, 3))
    table, *given = (ffi.from_buffer("double[]", each) for each in (words, rows, setpoints, states, out))
    return TICKS / shortest(lambda: library.fl_host_run(table, TICKS, 0, *given))


def at_a_bench(address: str, system: fl.System, duration_s: float = 4.0) -> float:
    """Ticks per second of a closed loop with full telemetry, bench and host included; the first run warms up."""
    with fl.connect(address, system) as device:
        device.run(0.6, 0.2)
        start = time.perf_counter()
        device.run(0.6, duration_s)
        return duration_s * 5000 / (time.perf_counter() - start)


def at_benches() -> None:
    """Print how fast a simulated and an emulated board run."""
    print(f"\n{'closed loop at a simulated bench':40s} {'ticks/s':>14s} {'of real time':>14s}")
    for name in ("notch, fed forward, overdriven", "limit observer"):
        system = fl.bench().evolve({"controller": CONTROLLERS[name]})
        with tempfile.TemporaryDirectory() as folder:
            law = board_law(law_of(system.controller))
            image = build("teensy41", firmware_words(system).tolist(), law, Path(folder), rate_hz=5000)
            for what, address in (("library", "sim:"), ("image, emulated", f"emulated:{image.elf}")):
                rate = at_a_bench(address, system)
                print(f"{f'{name}: {what}':40s} {rate:14.0f} {rate / 5000:13.1f}x")


def main() -> None:
    """Print two tables."""
    print(f"{'law':40s} {'ticks/s':>14s}  asked {ASKED_PER_S}")
    for name, controller in CONTROLLERS.items():
        found = speed(controller)
        print(f"{name:40s} {found:14.0f}  {'met' if found >= ASKED_PER_S else 'missed'}")
    at_benches()


if __name__ == "__main__":
    main()
