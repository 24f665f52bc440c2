"""The bench beside 23 published numbers: what it gives for each, and whether that is within what was published.

``python -m studies.validation`` computes all of them in a few seconds and keeps them for *docs/validation.md*;
``python -m studies.validation 4`` prints those of number 4. Nothing is tuned to meet them.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import xarray as xr

import frictionloop as fl
from frictionloop.experiments import Observer
from frictionloop.hardware.plate.drive_requirements import time_constant_s
from frictionloop.loop.companion_runs import weighted
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.parameters.presets import STILL
from studies.kept import keep
from studies.slide import slide_statistics
from studies.slide_onset import stick_to_slip
from studies.validation_numbers import NUMBERS, Number

BENCH = fl.bench()
CALM = BENCH.evolve(STILL)
"""A finger that does not vary by itself."""
MOIST = CALM.evolve({path: getattr(BENCH.friction, path[9:]) for path in STILL if path.endswith(("ratio", "loss"))})
"""One that grows moist and does not vary otherwise."""
RECORDED = {"motion.speed_mm_s": 40.0, "motion.stroke_mm": 100.0, "motion.reversal_s": 0.48, "motion.load_n": 0.52}
"""Speed, acceleration and load of the one public slide."""
LEVEL = {"friction.nominal_n": 0.205, "motion.tremor_um": 3.0}
"""Its friction, and how still it rested (studies/pages/finger-validation.md)."""
WITHIN, OUTSIDE, BUILT = "within the published interval", "not", "by construction"
UNREAD = "not measured by anyone we could read"


def per_mm_s(of: Callable[[float], float]) -> float:
    """Return by how much a quantity rises per mm/s of sliding speed, from 20 to 80 mm/s."""
    return (of(80.0) - of(20.0)) / 60.0


def at(speed_mm_s: float) -> fl.System:
    """Return the calm bench with long strokes of a speed."""
    return CALM.evolve({"motion.speed_mm_s": speed_mm_s, "motion.stroke_mm": 200.0})


def cutoff_hz(speed_mm_s: float, force_n: float) -> float:
    """Return the cutoff of a first-order lag that has the phase between friction limit and friction at 100 Hz."""
    sine = {"kind": "sine", "offset_n": force_n, "amplitude_n": 0.002, "frequency_hz": 100.0}
    system = at(speed_mm_s).evolve({"controller.kind": "lookup", "setpoint": sine})
    run = fl.simulate(system, 1.0).isel(time=slice(2500, None))
    wave = np.exp(-2j * np.pi * 100.0 * run["time"].values)
    passed = (wave @ run["f_a"].values) / (wave @ fl.friction_force(run["a"].values, system.friction))
    return float(100.0 * passed.real / -passed.imag)


def skin_peak_hz() -> float:
    """Return where the response of the skin to a force is largest, 0 for a damping without a peak."""
    k, c, m = CALM.finger.stiffness_n_m, CALM.finger.damping_n_s_m, CALM.finger.mass_kg
    return math.sqrt(max(k / m - 0.5 * (c / m) ** 2, 0.0)) / (2.0 * math.pi)


@cache
def slides(*, level: bool) -> list[xr.Dataset]:
    """Return 20 slides as the public one, at its friction or at that of the bench."""
    system = BENCH.evolve(RECORDED | (LEVEL if level else {}))
    return [fl.plain_stroke(system, 0.0, 1.6, seed) for seed in range(20)]


def sliding(name: str, *, level: bool = False) -> float:
    """Return the median of a statistic of steady sliding."""
    return float(np.median([getattr(slide_statistics(run, 0.26, 1.46), name) for run in slides(level=level)]))


def onset(name: str) -> float:
    """Return the median of a statistic of the start of a slide."""
    return float(np.median([getattr(stick_to_slip(run, 0.0, 0.2), name) for run in slides(level=True)]))


def half_range(values: np.ndarray) -> float:
    """Return half the range over the mean, in %."""
    return float(50.0 * np.ptp(values) / values.mean())


def coefficient_range() -> float:
    """Return half the range of the friction coefficient within a steady slide over its mean, in %."""
    steady = [run.sel(time=slice(0.26, 1.46)) for run in slides(level=False)]
    return float(np.median([half_range(run["f_a"].values / run["load"].values) for run in steady]))


def friction(speed_mm_s: float, static_ratio: float = 1.0) -> np.ndarray:
    """Return the friction of a calm finger over the last of two seconds of sliding, a slow one of six."""
    changes = {"friction.static_ratio": static_ratio, "motion.start": 0.25}
    duration_s = 6.0 if speed_mm_s < 5.0 else 2.0
    return np.asarray(fl.plain_stroke(at(speed_mm_s).evolve(changes), 0.0, duration_s)["f_a"].values[-5000:])


@cache
def rested(static_ratio: float, rest_s: float = 1.4, speed_mm_s: float = 40.0) -> np.ndarray:
    """Return the friction over 0.2 s of sliding of a calm finger that rested before."""
    loop = fl.Stepper(CALM.evolve({"friction.static_ratio": static_ratio}))
    rest, way_m, forces = round(5000 * rest_s), 1e-3 * speed_mm_s / 5000, []
    for tick in range(rest + 1000):
        slid = max(tick + 1 - rest, 0)
        loop.tick(0.0, fl.Movement(way_m * slid, 1e-3 * speed_mm_s if slid else 0.0, 0.5))
        forces.append(loop.force_n)
    return np.array(forces[rest:])


@cache
def plain(load_n: float = 0.5, duration_s: float = 300.0) -> xr.Dataset:
    """Return a stroke of the finger that grows moist, with its ``limit``, and its ``floor`` at full vibration."""
    return fl.plain_stroke(MOIST.evolve({"motion.load_n": load_n}), 0.0, duration_s)


def coefficient(load_n: float) -> float:
    """Return friction limit over load, just landed."""
    return float(plain(load_n, 0.1)["limit"][0]) / load_n


def saturation_s() -> float:
    """Return when the friction limit has done 95 % of its rise in minutes of contact."""
    limit = plain()["limit"].values
    return float(plain()["time"][int(np.argmax(limit >= limit[0] + 0.95 * (limit[-1] - limit[0])))])


def after(from_um: float, to_um: float) -> np.ndarray:
    """Return the friction of a sliding finger over half a second after the amplitude command changes."""
    loop = fl.Stepper(CALM)
    forces = []
    for tick in range(5000):
        loop.tick(from_um if tick < 2500 else to_um)
        forces.append(loop.force_n)
    return np.array(forces[2499:])


def fall_ms() -> float:
    """Return in which time friction has done 95 % of its fall."""
    force = after(0.0, 2.5)
    return float(np.argmax(force <= force[-1] + 0.05 * (force[0] - force[-1]))) / 5.0


def felt(force_n: np.ndarray) -> float:
    """Return the largest value of a change of force in units of the threshold of touch."""
    return float(np.abs(weighted(force_n - force_n[0], np.ones(force_n.size), 5000.0)).max())


def main(asked: list[str]) -> None:
    """Keep all numbers, or print the values of those asked for."""
    if asked:
        for each in NUMBERS:
            if each.number.rstrip("abc") in asked or each.number in asked:
                print(each.number, each.quantity, told(value(each)), verdict(value(each), each), sep="; ")
        return
    heads = ("number", "quantity", "ours", "published", "verdict", "source", "command")
    keep("validation", "validation", heads, (row(each, value(each)) for each in NUMBERS))


def value(each: Number) -> float | None:
    """Return ours, or None where there is nothing to compute it on."""
    return float(eval(each.how, NAMES)) if each.how else None


def verdict(ours: float | None, each: Number) -> str:
    """Return what the interval says of ours: a parameter taken from the source has to be within it too."""
    if ours is None:
        return UNREAD
    if not each.low <= ours <= each.high:
        return OUTSIDE
    return f"{BUILT}: `{each.built}`" if each.built else WITHIN


def told(ours: float | None) -> str:
    """Return a value with three figures."""
    return "–" if ours is None else f"{ours:.3g}"


def published(each: Number) -> str:
    """Return the interval."""
    return f"at least {each.low:.3g}" if each.high == math.inf else f"{each.low:.3g} to {each.high:.3g}"


def row(each: Number, ours: float | None) -> tuple[str, ...]:
    """Return the row of the table."""
    how = f"`{each.how}`" if each.how else "–"
    shown = "–" if ours is None else published(each)
    return each.number, each.quantity, told(ours), shown, verdict(ours, each), each.source, how


NAMES: dict[str, Any] = globals() | {
    "Observer": Observer,
    "PlateDesign": PlateDesign,
    "time_constant_s": time_constant_s,
}
"""What the expressions of the numbers are written in: this module."""

if __name__ == "__main__":
    main(sys.argv[1:])
