"""The figures that the pages give of the tracker on the fingers it was tuned on, measured again: some minutes.

``python -m studies.tracker_measured [starts learnt lasting steps optimum rows]``; all without a name.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np
from scipy.signal import freqz

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.entrants import told
from frictionloop.design.learnt import learnt_in_run
from frictionloop.design.tracker_loop import Row
from frictionloop.design.tracker_search import RowSearch
from frictionloop.design.tracker_tuning import believed_resonance
from frictionloop.parameters.tracking import PLACES
from frictionloop.physics.fingers import Fingers
from frictionloop.physics.friction import is_gaussian
from studies.linear_reach import linear_reach
from studies.robust_optimum import robust_optimum
from studies.robust_reach import UNMEASURED
from studies.tracker_plant import plant_paths
from studies.wiener_hopf import bins

SPEEDS_MM_S, CONTACTS, LEVELS_N = (20.0, 80.0), ("dahl", "slider"), (0.4, 0.6, 0.8)
BENCH = fl.bench().evolve({"controller.kind": "tracker"})
SEED = 7
LOST = 2.0
"""Ratio to the oracle's residual, over that of the median finger, beyond which one is told."""
BINS, DRIVE_N = 2**12, 0.2
"""Bins of the bounds of rows, and the command that a plate of 0.3 to 0.6 N to give seldom cuts."""
BEYOND = 30
"""Control periods that overshoot is exceeded for: 6 ms."""


def strokes() -> Iterator[tuple[str, dict[str, Any], float]]:
    """Yield name, overrides and speed of each speed and contact."""
    for speed in SPEEDS_MM_S:
        for contact in CONTACTS:
            yield f"{speed:g} mm/s, {contact}", {"motion.speed_mm_s": speed, "finger.contact": contact}, speed


def capable(count: int, speed_mm_s: float) -> Fingers:
    """Return those of ``fingers(count, 3)`` given 0.3 and 0.9 N at their mean load, each told its own resonance."""
    people = fl.fingers(count, protocol.TUNING_SEED)
    able = protocol.able(BENCH, people, speed_mm_s)
    devices = told(BENCH, protocol.each_resonance(BENCH, people), {"controller.kind": "tracker"})
    return Fingers(each for each, can in zip(devices, able, strict=True) if can)


def rms_mn(overrides: dict[str, Any], people: Fingers, duration_s: float, score_from_s: float) -> np.ndarray:
    """Return the rms error of each finger, mN."""
    swept = fl.sweep(
        BENCH.evolve(overrides), people, duration_s, seeds=[SEED], metrics=["rms_error"], score_from_s=score_from_s
    )
    return 1e3 * swept["rms_error"].values.ravel()


def held(level_n: float) -> dict[str, Any]:
    """Return a level that is held on strokes that never lift."""
    return {"setpoint": fl.Constant(offset_n=level_n), "motion.stroke_mm": 240.0, "motion.contact_s": 0.0}


def starts() -> None:
    """Print the largest Ms of three levels with what the tracker starts with."""
    for name, overrides, _ in strokes():
        own = BENCH.evolve(overrides)
        peaks = [fl.linearise(own, force_n=level).margins().sensitivity_peak for level in LEVELS_N]
        print(f"{name}: Ms {max(peaks):.1f}")


def learnt() -> None:
    """Print quartiles of compliance and of susceptibility over the true one, as learnt in 11 s."""
    for name, overrides, speed in strokes():
        found = []
        for finger in capable(120, speed):
            own = learnt_in_run(BENCH.evolve({**held(0.6), **overrides, **finger}), 11.0, SEED)
            assert is_gaussian(own.friction)
            believed, true = own.controller.model.susceptibility_per_um2, own.friction.susceptibility_per_um2
            found.append((float(own.controller.model_dump()["compliance_um_per_n"]), believed / true))
        for what, row in zip(
            ("um/N", "of the true susceptibility"), np.quantile(found, (0.25, 0.5, 0.75), axis=0).T, strict=True
        ):
            print(f"{name}: {row[1]:.3g} {what} ({row[0]:.3g} to {row[2]:.3g})")


def lasting() -> None:
    """Print medians of the rms over the last 8 s of long runs without a lift, beside the oracle's, and ratios."""
    for name, overrides, speed in strokes():
        people = Fingers(list(capable(120, speed))[:30])
        for duration_s in (40.0, 120.0):
            both = [
                rms_mn(held(0.6) | overrides | {"controller.kind": kind}, people, duration_s, duration_s - 8.0)
                for kind in ("tracker", "oracle")
            ]
            (ours, least), ratio = (np.median(each) for each in both), both[0] / both[1]
            worst = f"{np.quantile(ratio, 0.9):.1f} and at most {np.max(ratio):.1f} times the oracle's"
            print(f"{name}, {duration_s:g} s: {ours:.1f} beside {least:.1f} mN, worst decile {worst}")
            for i in np.flatnonzero(ratio > LOST * np.median(ratio)):
                print(f"  lost: finger {i}, {both[0][i]:.0f} beside {both[1][i]:.0f} mN")


def steps() -> None:
    """Print rise and fall (ms), overshoot, undershoot and rms (mN) of steps at 80 mm/s, medians of eight fingers.

    Of the fingers' susceptibility 0.8, 1 and 2 times, and of a model whose own is 1.3 times as large.
    """
    up_down = fl.Steps(times_s=tuple(0.5 * k for k in range(12)), levels_n=(0.35, 0.75) * 6)
    described = {"sensor.resonance_hz": BENCH.sensor.resonance_hz, "motion.stroke_mm": 240.0, "setpoint": up_down}
    for name, overrides, speed in list(strokes())[2:]:
        people = list(capable(240, speed))[:8]
        for share, model in ((0.8, 1.0), (1.0, 1.0), (2.0, 1.0), (1.0, 1.3)):
            rows = [_steps(BENCH.evolve({**overrides, **each, **described}), share, model) for each in people]
            told = ", ".join(f"{value:.3g}" for value in np.median(rows, axis=0))
            print(f"{name}, tau x {share:g}, model's x {model:g}: {told}")


def _steps(system: fl.System, share: float, model: float) -> list[float]:
    """Return rise, fall (ms), overshoot, undershoot and rms (mN) of a run in which susceptibilities are multiplied."""
    tau, believed = system.friction.susceptibility_per_um2, system.controller.model.susceptibility_per_um2
    multiplied = {
        "friction.susceptibility_per_um2": share * tau,
        "controller.model.susceptibility_per_um2": model * believed,
    }
    run = fl.simulate(system.evolve(multiplied), 6.0, 3)
    scored = run.isel(time=run["scored"].values.astype(bool))
    error, above = 1e3 * (scored["f_a"] - scored["f_r"]).values, scored["f_r"].values > 0.5
    beyond = np.sort(error[above])[-BEYOND], -np.sort(error[~above])[BEYOND - 1]
    found = [(step.to_n, 1e3 * step.rise_s) for step in fl.step_times(run)]
    times = [float(np.mean([t for to, t in found if (to > 0.5) == up])) for up in (True, False)]
    return [*times, *map(float, beyond), 1e3 * fl.rms_error(run)]


def optimum() -> None:
    """Print the residual over each finger's own spared linear optimum."""
    for name, overrides, speed in strokes():
        people, squares = capable(120, speed), []
        for level in LEVELS_N:
            own = BENCH.evolve(held(level) | overrides)
            found = linear_reach(own, people, seed=SEED, peaks=(1.7,), levels_n=(level,)).sel(measured="force and load")
            squares.append((rms_mn(held(level) | overrides, people, 11.0, 1.0), 1e3 * found["driven_rms_n"].values[0]))
        ours, least = np.sqrt(np.nanmean(np.square(squares), axis=0))
        row = np.nanquantile(ours / least, (0.25, 0.5, 0.75))
        print(f"{name}: {row[1]:.2f} ({row[0]:.2f} to {row[2]:.2f})")


def rows() -> None:
    """Print what rows leave as predicted, their estimates right, and what no linear law that bears as much gets below.

    Without and with a command of at most 0.2 N rms, the plate's lag divided out (mN); stable tells whether the law
    found with the first is so with every resonance.
    """
    true, turns = BENCH.controller.model, np.linspace(0.0, np.pi, BINS + 1)
    share_of_true, q = believed_resonance(UNMEASURED)
    low = {"resonance_hz": share_of_true * true.resonance_hz, "resonance_q": q}
    for place, row in zip(PLACES, BENCH.controller.schedule, strict=True):
        search = RowSearch(BENCH, true, true.model_copy(update=low), place, UNMEASURED)
        plants, disturbance = search.plants[0]
        search.near, search.plants = 0.0, search.plants[:1]
        paths = {off: plant_paths(plant, search.dt) for off, plant in plants.items()}
        seen = {off: freqz(reading, poles, turns)[1] for off, (reading, _, poles) in paths.items()}
        ratios = np.array([seen[off] / seen[0.0] for off in plants])
        peaks = np.array([UNMEASURED[abs(off)] for off in plants])
        reading, friction, poles = paths[0.0]
        decay = np.exp(-2.0 * np.pi * true.plate_hz * search.dt)
        driven = np.convolve(poles, [1.0, -decay]) / (1.0 - decay)
        spectra = bins(search.f, disturbance, search.noise, 0.5 / search.dt, (reading, friction, driven), BINS)
        free, driven_less = (robust_optimum(spectra, ratios, peaks, most) for most in (np.inf, DRIVE_N))
        told = (
            f"{1e3 * search.residual(Row(*row))[0]:.1f} mN, bound {1e3 * free.bound_rms_n:.1f} (stable: {free.stable})"
        )
        print(f"place {place:g}: {told}, and {1e3 * driven_less.bound_rms_n:.1f} with a command that small")


if __name__ == "__main__":
    for measured in (starts, learnt, lasting, steps, optimum, rows):
        if not sys.argv[1:] or measured.__name__ in sys.argv[1:]:
            print(f"{measured.__name__}: {measured.__doc__}")
            measured()
