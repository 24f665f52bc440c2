"""A lab whose bench is known: recordings of the simulated rigs in any file format, and its project file."""

from __future__ import annotations

import numpy as np
import recorded_files as files

from frictionloop.identification import rigs
from frictionloop.parameters.calibration_bench import CalibrationBench

VOLTS_PER_N = 3.0
BENCH = CalibrationBench().evolve(
    {"sensor.resonance_hz": 173.0, "sensor.q": 26.0, "sensor.cutoff_hz": 820.0, "sensor.noise_density_n_rthz": 3.1e-6,
     "errors.gain_error": 0.0, "errors.nonlinearity": 0.0}
)  # fmt: skip
RATE = 5000.0


def write(folder, name, form, run, columns):
    scaled = {each: run[each].values * (VOLTS_PER_N if each == "f_m" else 1.0) for each in columns}
    files.FORMATS[form](folder / name, scaled, RATE)


def lab(folder, form="time.csv", seed=0):
    """Write three kinds of recordings in one format and the project file; return its path."""
    end = form[form.index(".") :]
    hammer = {"hits": 6, "seed": seed + 1, "peak_n": 0.3}
    masses = [0.04 * k for k in (*range(6), *range(4, -1, -1))]
    write(folder, f"weights{end}", form, rigs.weights_rig(masses, BENCH, dwell_s=2.0, seed=seed), ["mass", "f_m"])
    write(folder, f"hits{end}", form, rigs.hammer_rig(BENCH, **hammer), ["hammer", "f_m"])
    write(folder, f"quiet{end}", form, rigs.floor_rig(BENCH, 5.0, seed=seed + 2), ["f_m"])
    numbered = form == "file.wav"
    first, reading, alone = (0, 1, 0) if numbered else ('"mass"', '"f_m"', '"f_m"')
    hammer_column = 0 if numbered else '"hammer"'
    path = folder / "lab.toml"
    path.write_text(
        f"""
[[recording]]
kind = "weights"
files = ["weights{end}"]
date = "2026-03-04"
tolerance = 5e-5
gravity_m_s2 = 9.80665
[recording.channels]
mass = {{ column = {first}, unit = "kg" }}
f_m = {{ column = {reading}, unit = "V" }}

[[recording]]
kind = "hits"
files = ["hits{end}"]
[recording.channels]
hammer = {{ column = {hammer_column}, unit = "N" }}
f_m = {{ column = {reading}, unit = "V" }}

[[recording]]
kind = "quiet"
files = ["quiet{end}"]
channels.f_m = {{ column = {alone}, unit = "V" }}

[converter]
bits = 16
full_scale = {2.5 * VOLTS_PER_N}

[known]
"sensor.moving_mass_kg" = 0.4
"""
    )
    return path


def truth():
    sensor = BENCH.sensor
    return {
        "sensitivity": VOLTS_PER_N,
        "sensor.resonance_hz": sensor.resonance_hz,
        "sensor.q": sensor.q,
        "sensor.cutoff_hz": sensor.cutoff_hz,
        "sensor.noise_density_n_rthz": sensor.noise_density_n_rthz,
    }


def outside(found, confidence):
    """Return the values whose interval does not hold the truth."""
    ends = {name: found.measured[name].interval(confidence) for name in truth()}
    return {name: ends[name] for name, true in truth().items() if not ends[name].low < true < ends[name].high}


def near(found, share):
    return all(np.isclose(found.measured[name].value, true, rtol=share) for name, true in truth().items())
