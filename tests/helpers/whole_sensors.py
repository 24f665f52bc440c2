"""Hours of fingers on a bench whose sensors are whole, and what the board says to what they tell."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import numpy as np

import frictionloop as fl
from frictionloop.control.law import Law
from frictionloop.control.laws import LAWS
from frictionloop.device.simulated_boards import ENDS
from frictionloop.firmware.compiled_core import host_sources, law_of_table
from frictionloop.firmware.host_compiler import shared_library
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import n_per_count
from frictionloop.parameters.presets import RETUNED
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.protocol_schema import named

TICK_HZ = 5000
FINGERS, EACH_S = 1000, 36.0
SPEEDS_MM_S = 3.0, 150.0
REPLAYED = Path(__file__).parents[1] / "firmware" / "replayed.c"


class Raised(NamedTuple):
    """A fault: of which finger, at which tick, its name, its value, and the force on the finger then."""

    finger: int
    tick: int
    name: str
    value: float
    force_n: float


FIRST = 11
"""Seed of a population."""


@cache
def population(seed: int = FIRST) -> fl.Fingers:
    """Return the fingers."""
    return fl.fingers(FINGERS, seed)


def slid(finger: int, seed: int = FIRST) -> fl.System:
    """Return a finger on the bench: its law, set-point, speed, strokes and contact go through all kinds in turn."""
    rng = np.random.default_rng((seed + 12, finger))
    plain = fl.bench().evolve(RETUNED).model_dump()
    law = list(LAWS)[finger % len(LAWS)]
    if law != "pi":
        plain["controller"] = {"kind": law, "delay_s": 200e-6, "model": plain["controller"]["model"]}
    plain["setpoint"] = _setpoint(finger // len(LAWS), rng)
    slowest, fastest = SPEEDS_MM_S
    changed: dict[str, Any] = {
        "motion.speed_mm_s": float(slowest * (fastest / slowest) ** rng.random()),
        "motion.stroke_mm": float(rng.choice([30.0, 60.0])),
        "motion.reversal_s": float(rng.choice([0.03, 0.1])),
        "motion.start": float(rng.random()),
        "motion.landing_s": float(rng.choice([0.01, 0.03, 0.05])),
        "motion.contact_s": float(rng.choice([0.0, 0.3, 1.0, 4.0])),
        "motion.lifted_s": float(rng.choice([0.05, 0.3])),
        "finger.slip_length_um": float(rng.choice([11.5, 0.0, 30.0])),
        "friction.static_ratio": float(rng.choice([1.0, 1.0, 1.4])),
    }
    return fl.System.model_validate(plain).evolve(changed | population(seed)[finger])


def _setpoint(number: int, rng: np.random.Generator) -> dict[str, Any]:
    """Return a set-point: held, slow, steps as quick as they come, textures, a sweep through the mains, noise."""
    if number % 6 == 0:
        return {"kind": "constant", "offset_n": float(rng.uniform(0.3, 0.9))}
    if number % 6 == 1:
        return {"kind": "sine", "offset_n": 0.6, "amplitude_n": 0.3, "frequency_hz": float(rng.uniform(0.3, 8.0))}
    if number % 6 == 2:
        times = np.cumsum(rng.choice([0.01, 0.02, 0.1, 0.5], 400))
        return {
            "kind": "steps",
            "times_s": (0.0, *times.tolist()),
            "levels_n": tuple(rng.uniform(0.2, 1.0, 401).tolist()),
        }
    if number % 6 == 3:
        hz = float(rng.choice([rng.uniform(20.0, 120.0), 50.0, 60.0]))
        return {"kind": "sine", "offset_n": 0.6, "amplitude_n": float(rng.uniform(0.01, 0.35)), "frequency_hz": hz}
    if number % 6 == 4:
        return {
            "kind": "log_sweep", "offset_n": 0.6, "amplitude_n": 0.3, "start_hz": 1.0, "stop_hz": 100.0,
            "sweep_s": EACH_S,
        }  # fmt: skip
    return {"kind": "noise", "offset_n": 0.6, "rms_n": 0.1, "low_hz": 1.0, "high_hz": 200.0}


class Told(NamedTuple):
    """What the converters told at each tick, (ticks, 4) of int32; set-point, amplitude and force of the run."""

    samples: np.ndarray
    setpoints: np.ndarray
    amplitude_um: np.ndarray
    force_n: np.ndarray


def told(system: fl.System, seed: int, duration_s: float = EACH_S) -> Told:
    """Return what sensors tell of a simulated run, position and load with their noise."""
    run, rng, board = fl.simulate(system, duration_s, seed), np.random.default_rng((29, seed)), system.board
    count = run.sizes["time"]
    position = run["position"].values + 1e-6 * system.touch.position.noise_um * rng.standard_normal(count)
    load = run["load"].values + 2.0 * system.touch.load.noise_n * rng.standard_normal(count)
    columns = (
        run["f_m"].values / n_per_count(system), np.zeros(count), position / board.position_m_per_count,
        load / board.load_n_per_count,
    )  # fmt: skip
    samples = np.clip(np.rint(np.stack(columns, axis=1)), *ENDS).astype(np.int32)
    setpoints, amplitude_um = np.clip(run["f_r"].values, 0.0, 7.9), np.ascontiguousarray(run["a"].values)
    return Told(np.ascontiguousarray(samples), setpoints, amplitude_um, run["f_a"].values)


def raised(readings: Told, words: np.ndarray, finger: int = 0) -> list[Raised]:
    """Return the faults that a board raises; after each it is idle for a second."""
    ffi, library = _library(law_of_table(words))
    room = 100
    found = np.zeros((room, 3))
    arrays = words, readings.setpoints, readings.amplitude_um, found
    pointers = [ffi.from_buffer("double[]", array) for array in arrays]
    samples = ffi.from_buffer("int32_t[]", readings.samples)
    count = len(readings.setpoints)
    many = library.fl_replayed(pointers[0], count, samples, *pointers[1:3], room, pointers[3])
    faults = named("faults")
    rows = found[: min(many, room)].tolist()
    return [
        Raised(finger, int(tick), faults[int(fault)], value, float(readings.force_n[int(tick)]))
        for tick, fault, value in rows
    ]


@cache
def _library(law: Law) -> tuple[Any, Any]:
    ffi = needed("cffi", "cffi", "firmware").FFI()
    ffi.cdef(
        "int32_t fl_replayed(const double *words, int32_t count, const int32_t *samples, const double *setpoints, "
        "const double *amplitudes, int32_t room, double *told);"
    )
    sources, folders = host_sources()
    core = [source for source in sources if source.parent.name == "core"]
    with TemporaryDirectory() as folder:
        own = board_law(law).write(Path(folder))
        return ffi, ffi.dlopen(str(shared_library("replayed", [*core, own, REPLAYED], folders)))
