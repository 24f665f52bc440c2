"""A lab that measures everything but the force sensor: plate, scale, drift, delay, load, position, three fingers."""

from __future__ import annotations

import numpy as np
import vibrated_finger

from frictionloop.identification.rigs import jumps_rig, plate_sweep_rig, plate_switch_rig
from frictionloop.parameters import ResonantPlate

PLATE = ResonantPlate(frequency_hz=41e3, q=180.0, max_amplitude_um=2.2)
DELAY_S = 230e-6
FINGERS = {"ann": (1.3, 0.9), "bob": (0.8, 0.35), "cid": (1.0, 0.55)}
"""f0 in N and tau in um^-2."""
TRUTH = {
    "plate.frequency_hz": 41e3,
    "plate.q": 180.0,
    "controller.model.plate_hz": 41e3 / 360,
    "plate.max_amplitude_um": 2.2,
    "controller.delay_s": DELAY_S,
    "carrier_drift": -3.0,
    "load_sensitivity": 5000.0,
    "crosstalk": 0.012,
    "position_scale": 2e-6,
}


def save(path, run):
    """Write the channels of a recording, at a rate if they are over time."""
    more = {"fs": 1 / float(run.time[1] - run.time[0])} if "time" in run.dims else {}
    np.savez(path, **{name: run[name].values for name in run.data_vars}, **more)


def tables(folder, rng):
    """Write what comes as tables: a scale, a drift, weights on the load cells, a known way."""
    drive = np.linspace(0.1, 0.9, 9)
    um = 2.2 * drive + 2e-3 * rng.normal(size=9)
    minutes = np.linspace(0, 30, 16)
    hertz = 41e3 - 3 * minutes + 0.8 * rng.normal(size=16)
    grams = np.array([0, 20, 50, 100, 150, 200, 150, 100, 50, 20, 0.0])
    newtons = 9.80665e-3 * grams
    counts = 300 + 5000 * newtons + 2 * rng.normal(size=11)
    lateral = 0.012 * newtons + 1e-5 * rng.normal(size=11)
    way = np.linspace(0, 0.2, 12)
    read = way / 2e-6 + 5 * rng.normal(size=12)
    for name, columns in {
        "scale": {"drive": drive, "vibration [um]": um},
        "drift": {"minutes [min]": minutes, "frequency [Hz]": hertz},
        "load": {"mass [g]": grams, "load": counts, "f_m [N]": lateral},
        "way": {"position": way, "reading": read},
    }.items():
        np.savetxt(
            folder / f"{name}.csv", np.column_stack(list(columns.values())), delimiter=",", header=",".join(columns),
            comments="",
        )  # fmt: skip


def lab(folder, seed=0):
    """Write the recordings and the project file; return its path."""
    tables(folder, np.random.default_rng(seed))
    save(folder / "sweep.npz", plate_sweep_rig(PLATE, seed=seed))
    save(folder / "switch.npz", plate_switch_rig(PLATE, switches=6, seed=seed))
    save(folder / "jumps.npz", jumps_rig(DELAY_S, jumps=40, seed=seed))
    text = """
[[recording]]
kind = "plate"
files = ["sweep.npz"]
channels.frequency = { column = "frequency", unit = "Hz" }
channels.vibration = { column = "vibration", unit = "um" }

[[recording]]
kind = "plate"
files = ["switch.npz"]
channels.vibration = { column = "vibration", unit = "um" }

[[recording]]
kind = "plate"
files = ["switch.npz"]
channels.envelope = { column = "envelope", unit = "um" }

[[recording]]
kind = "scale"
files = ["scale.csv"]
full_drive = 1.0
channels.drive = { column = "drive" }
channels.vibration = { column = "vibration", unit = "um" }

[[recording]]
kind = "carrier"
files = ["drift.csv"]
channels.minutes = { column = "minutes" }
channels.frequency = { column = "frequency", unit = "Hz" }

[[recording]]
kind = "delay"
files = ["jumps.npz"]
control_hz = 5000
channels.jump = { column = "jump", unit = "V" }
channels.answer = { column = "answer", unit = "V" }

[[recording]]
kind = "load"
files = ["load.csv"]
gravity_m_s2 = 9.80665
channels.mass = { column = "mass" }
channels.load = { column = "load", unit = "counts" }
channels.f_m = { column = "f_m" }

[[recording]]
kind = "position"
files = ["way.csv"]
channels.position = { column = "position", unit = "m" }
channels.reading = { column = "reading", unit = "counts" }
"""
    for k, (name, (f0, tau)) in enumerate(FINGERS.items()):
        for take in range(2):
            run = vibrated_finger.finger(
                lambda a, tau=tau: np.exp(-tau * a**2),
                f0,
                duration_s=20.0,
                seed=100 * seed + 10 * k + take,
                largest=2.2,
            )
            save(folder / f"{name}-{take}.npz", run)
        text += f"""
[[recording]]
kind = "amplitude"
finger = "{name}"
files = ["{name}-0.npz", "{name}-1.npz"]
channels.f_m = {{ column = "f_m", unit = "N" }}
channels.load = {{ column = "load", unit = "N" }}
channels.amplitude = {{ column = "amplitude", unit = "um" }}
channels.position = {{ column = "position", unit = "m" }}
"""
    path = folder / "lab.toml"
    path.write_text(text)
    return path
