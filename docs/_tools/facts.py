"""Every number of the notes and of the model that is ours: computed here, held as text by the pages (`filled`)."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import bench_facts
import numpy as np
from scipy.signal import dlsim
from tables import table

import frictionloop as fl

ROOT = Path(__file__).parents[2]
GAINS = (1.0, 5.0, 10.0, 20.0, 40.0)


def score(system: fl.System) -> tuple[float, float]:
    """Return R2 and saturation index of 10 s."""
    run = fl.simulate(system, 10.0, seed=0)
    return fl.r2_identity(run), fl.saturation_index(run)


def readings() -> str:
    """Return what each reading of the printed amplitudes allows, and what the loop makes of it."""
    systems = {name: fl.paper().evolve(overrides) for name, overrides in fl.READINGS.items()}
    return table(
        ("Reading", "$f_r$ (N)", "$d$ (N)", "Band at all times (N)", "In reach", "Best $R^2$", "$R^2$ at 10, 2"),
        (_reading(name, system) for name, system in (systems | {"`fl.feasible()`": fl.feasible()}).items()),
    )


def _reading(name: str, system: fl.System) -> Iterable[Any]:
    run = fl.simulate(system, 10.0, seed=0)
    d = run["d"].values
    low, high = fl.reachable(system, d)
    band = f"[{low:.3f}, {high:.3f}]" + (", empty" if low > high else "")
    floor_n, nominal_n = fl.reachable(system)
    in_reach = np.mean((run["f_r"] >= floor_n + d) & (run["f_r"] <= nominal_n + d))
    signals = (f"{s.offset_n:g} ± {s.amplitude_n:g}" for s in (system.setpoint, system.disturbance))
    return name, *signals, band, f"{in_reach:.0%}", f"{fl.r2_bound(run):.3f}", f"{fl.r2_identity(run):.3f}"


def delays() -> str:
    """Return phase margin and largest stable kp over the delay."""
    rows = []
    for delay_s in (0.0, 100e-6, 200e-6, 300e-6, 400e-6):
        loop = fl.linearise(fl.paper().evolve({"controller.delay_s": delay_s}))
        margins = loop.margins()
        state = "stable" if margins.stable else "unstable"
        phase = f"{margins.phase_margin_deg:.0f}°"
        rows.append((f"{delay_s * 1e6:g}", f"{delay_s * 1e6 + 100:g}", phase, f"{fl.kp_limit(loop):.1f}", state))
    header = "`delay_s` (µs)", "with half the hold (µs)", "phase margin at 10, 2", "largest stable $K_p$", "10, 2 is"
    return table(header, rows)


WHOLE = "tests/firmware/test_whole_sensors.py"
SENSOR_FAULTS = {
    "stuck with a bit of dither": "the force stays, but for its last bit",
    "random codes": "any code, at random",
    "reversed sign": "two wires of the force exchanged",
    "open input": "the force's input is open and reads about 0",
    "an offset": "the force is 1 N too large",
    "half the gain": "the force is halved; told above 0.35 N",
    "a tenth of the gain": "the force is a tenth",
    "intermittent overload": "the force at an end, 10 ticks on and 10 off",
    "position jumps": "the position jumps by 60 mm",
    "no load": "the load is 0",
    "mains, 50 Hz": "mains of 50 Hz, 0.5 N",
    "mains, 60 Hz": "mains of 60 Hz, 0.5 N",
    "mains, strong": "mains of 50 Hz, 1 N",
    "floating": "the force's cable is off: drift of 1.5 N/s, hum of 0.3 N (assumed)",
}


def sensor_faults() -> str:
    """Return what the stored campaigns found of sensors that break."""
    file = "tests/firmware/test_broken_sensors.py"
    stored, rows = json.loads((ROOT / "tests" / "soak.json").read_text(encoding="utf-8")), []
    for name, fault in SENSOR_FAULTS.items():
        found = stored[f"{file}::test_it_is_told_of_many_fingers[{name}]"]["figures"]
        codes = ", ".join(f"`{code}`" for code in found["faults"].split(", "))
        of_100 = f"{found['found, of 100']}, {found['in time, of 100']} in time"
        after = (f"{found[what]:g} ms" for what in ("found after, median, ms", "plate at rest after, worst, ms"))
        rows.append((fault, codes, of_100, *after, f"`-k {max(name.replace(',', ' ').split(), key=len)}`"))
    hours = [each for name, each in stored.items() if name.startswith(f"{WHOLE}::test_an_hour")]
    alarms = sum(each["figures"]["false alarms"] for each in hours)
    last = max(each["figures"]["date"] for each in hours)
    said = f"false faults: {alarms} in {len(hours)} hours of {100 * len(hours)} fingers, until {last}"
    rows.append(("none: the sensors are whole", said, "", "", "run goes on", "see above"))
    heads = "fault", "what happens", "found, of 100 fingers", "found, median", "time to safe, worst", "shown by"
    return table(heads, rows)


UNTOLD = {
    "test_what_may_not_be_told": "while the loop is closed",
    "test_what_was_broken_before_the_loop_was_closed": "before the loop is closed",
}


def sensor_faults_untold() -> str:
    """Return what the stored campaigns found of faults that are told of some fingers or none, and what then happens."""
    file = "tests/firmware/test_broken_sensors.py"
    stored, rows = json.loads((ROOT / "tests" / "soak.json").read_text(encoding="utf-8")), []
    for name, each in stored.items():
        test, _, fault = name.removeprefix(f"{file}::").rstrip("]").partition("[")
        if test in UNTOLD:
            found = each["figures"]
            then = (
                " to ".join(f"{x:g}" for x in found.get(what, ())) for what in ("force over set-point", "amplitude, um")
            )
            codes = ", ".join(f"`{code}`" for code in found["faults"].split(", ") if code)
            rows.append((f"{fault}, {UNTOLD[test]}", f"{found['found, of 10']}", codes, *then))
    return table(("fault", "told, of 10", "as", "force over set-point", "amplitude, um"), rows)


def noise_gains() -> str:
    """Return sigma_f / sigma_n of equation (3), printed and as the loop runs, and sigma_u / sigma_n."""
    rows = []
    for kp in GAINS:
        loop = fl.linearise(fl.paper().evolve({"controller.kp": kp}))
        sigma = loop.system.sensor.noise_rms_n
        frequency = np.geomspace(1e-3, loop.nyquist_hz, 20_001)
        through = np.abs(loop.responses(frequency, "printed")["f_a_from_n"])
        printed = math.sqrt(2.0 * loop.plant.period_s * np.trapezoid(through**2, frequency))
        sampled = fl.output_noise_rms_n(loop) / sigma, fl.command_noise_rms_n(loop) / sigma
        rows.append((f"{kp:g}", f"{printed:.2f}", *(f"{x:.2f}" if math.isfinite(x) else "unstable" for x in sampled)))
    force, command = r"$\sigma_f/\sigma_n$", r"$\sigma_u/\sigma_n$"
    return table(("$K_p$", f"{force}, continuous", f"{force}, sampled", f"{command}, sampled"), rows)


def numbers() -> dict[str, str]:
    """Return the single numbers that the pages quote."""
    paper = fl.paper()
    run = fl.simulate(paper, 10.0, seed=0)
    low, high = fl.reachable(paper, run["d"].values)
    f0, floor = paper.friction.nominal_n, fl.reachable(paper).low_n
    wide = fl.simulate(paper.evolve(fl.READINGS["disturbance of Sec. 2.1"]), 10.0)
    literal_r2, lumped_r2, apart_n = literal_and_lumped()
    loud = fl.feasible().evolve({"controller.kp": 40.0})
    steepest = fl.amplitude_for(f0 * math.exp(-0.5), paper.friction)
    output_n = fl.output_noise_rms_n(paper.evolve({"sensor.noise_rms_n": 5e-5}))
    return (
        {
            "bound": f"{fl.r2_bound(run):.3f}",
            "r2": f"{fl.r2_identity(run):.3f}",
            "regression": f"{fl.r2_regression(run):.3f}",
            "slope": f"{fl.regression(run).slope:.2f}",
            "low": f"{low:.3f}",
            "high": f"{high:.3f}",
            "floor": f"{floor:.4f}",
            "reduction": f"{1 - floor / f0:.0%}",
            "half": f"{float(fl.amplitude_for(f0 / 2, paper.friction)):.2f}",
            "steepest": f"{float(steepest):.2f}",
            "amplitude_for_floor_of_device": f"{float(fl.amplitude_for(f0 / 3, paper.friction)):.2f}",
            "lowest_d": f"{float(wide['d'].min()):.1f}",
            "lowest_possible": f"{floor + float(wide['d'].min()):.2f}",
            "lowest_f": f"{float(wide['f_a'].min()):.2f}",
            "kp_limit": f"{fl.kp_limit(paper):.1f}",
            "kp_limit_late": f"{fl.kp_limit(paper.evolve({'controller.delay_s': 200e-6})):.1f}",
            "output_noise": f"{output_n * 1e5:.1f}",
            "noise_harm_mn": f"{harmful_noise_n(0.01) * 1e3:.1f}",
            "feasible_r2": f"{score(fl.feasible())[0]:.3f}",
            "loud_r2": f"{score(loud)[0]:.2f}",
            "loud_r2_noiseless": f"{score(loud.evolve({'sensor.noise_rms_n': 0.0}))[0]:.2f}",
            "literal_r2": f"{literal_r2:.4f}",
            "lumped_r2": f"{lumped_r2:.4f}",
            "apart_mn": f"{apart_n * 1e3:.1f}",
        }
        | bench_facts.numbers()
        | sensor_numbers()
    )


def literal_and_lumped() -> tuple[float, float, float]:
    """Return R2 with the low-pass before the friction law and with both lumped into P(s), and the rms between (N)."""
    system = fl.feasible().evolve({"sensor.noise_rms_n": 0.0})
    run = fl.simulate(system, 10.0)
    f_r, d = run["f_r"].values, run["d"].values
    space = fl.linearise(system).state_space(("f_r", "d"))
    matrices = space.A, space.B, space.C, space.D, space.period_s
    lumped = dlsim(matrices, np.column_stack([f_r, d]))[1][:, 0]
    settled = run["time"].values >= 0.1
    apart = np.sqrt(np.mean((lumped - run["f_a"].values)[settled] ** 2))
    return fl.r2_identity(run, settled), fl.r2_identity(run.assign(f_a=("time", lumped)), settled), float(apart)


def harmful_noise_n(loss: float) -> float:
    """Return the rms of sensor noise that lowers R2 by ``loss``."""
    rms_n = np.geomspace(1e-3, 1.0, 61)
    r2 = fl.sweep(fl.feasible(), {"sensor.noise_rms_n": rms_n}, 10.0, progress=False)["r2_identity"].values[:, 0]
    lost = score(fl.feasible().evolve({"sensor.noise_rms_n": 0.0}))[0] - r2
    return float(np.exp(np.interp(loss, np.maximum.accumulate(lost), np.log(rms_n))))


def sensor_numbers() -> dict[str, str]:
    """Return the arithmetic of Section 3, from its printed values."""
    mass_kg, stiffness_n_per_m, resonance_hz, floor_n, range_n = 0.4, 1e6, 145.0, 5e-5, 2.5
    measured_n_per_m = mass_kg * (2 * math.pi * resonance_hz) ** 2
    noise_band_hz = math.pi / 2 * 300.0  # equivalent noise bandwidth of a first-order pole
    return {
        "design_hz": f"{math.sqrt(stiffness_n_per_m / mass_kg) / (2 * math.pi):.1f}",
        "measured_stiffness": f"{measured_n_per_m / 1e6:.2f}",
        "measured_mass": f"{stiffness_n_per_m / (2 * math.pi * resonance_hz) ** 2:.1f}",
        "floor_pm": f"{floor_n / stiffness_n_per_m * 1e12:.0f}",
        "floor_measured_pm": f"{floor_n / measured_n_per_m * 1e12:.0f}",
        "range_db": f"{20 * math.log10(range_n / floor_n):.2f}",
        "ratio": f"{range_n / floor_n:,.0f}",
        "density_as_rms_mn": f"{floor_n * math.sqrt(noise_band_hz) * 1e3:.1f}",
        "rms_as_density": f"{floor_n / math.sqrt(noise_band_hz) * 1e6:.1f}",
    }
