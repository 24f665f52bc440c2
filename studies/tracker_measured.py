"""What the tracker learns, how it lasts, and how its steps end, on the fingers it was tuned on: some minutes.

``python -m studies.tracker_measured [starts learnt lasting steps]``; all without a name.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import Any

import numpy as np

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.design.comparison.entrants import told
from frictionloop.design.learnt import learnt_in_run
from frictionloop.physics.fingers import Fingers
from frictionloop.physics.friction import is_gaussian
from studies.kept import keep

SPEEDS_MM_S, CONTACTS, LEVELS_N = (20.0, 80.0), ("dahl", "slider"), (0.4, 0.6, 0.8)
BENCH = fl.bench().evolve({"controller.kind": "tracker"})
SEED = 7
LOST = 2.0
"""Ratio to the oracle's residual, over that of the median finger, beyond which one is told."""
MULTIPLIED = (
    ("finger's × 0.8", 0.8, 1.0),
    ("as it is", 1.0, 1.0),
    ("finger's × 2", 2.0, 1.0),
    ("model's × 1.3", 1.0, 1.3),
)
"""By what the finger's susceptibility, and the model's, are multiplied for steps."""
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
    """Keep rise and fall (ms), overshoot, undershoot and rms (mN) of steps at 80 mm/s, medians of eight fingers.

    Of the fingers' susceptibility 0.8, 1 and 2 times, and of a model whose own is 1.3 times as large.
    """
    up_down = fl.Steps(times_s=tuple(0.5 * k for k in range(12)), levels_n=(0.35, 0.75) * 6)
    described = {"sensor.resonance_hz": BENCH.sensor.resonance_hz, "motion.stroke_mm": 240.0, "setpoint": up_down}
    rows = []
    for name, overrides, speed in list(strokes())[2:]:
        people = list(capable(240, speed))[:8]
        for what, share, model in MULTIPLIED:
            found = [_steps(BENCH.evolve({**overrides, **each, **described}), share, model) for each in people]
            rows.append([what, name.split(", ")[1], *(f"{value:.3g}" for value in np.median(found, axis=0))])
    heads = ("susceptibility", "contact", "rise, ms", "fall, ms", "over, mN", "under, mN", "rms, mN")
    keep("tracker-steps", "tracker_measured steps", heads, rows)


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


if __name__ == "__main__":
    for measured in (starts, learnt, lasting, steps):
        if not sys.argv[1:] or measured.__name__ in sys.argv[1:]:
            print(f"{measured.__name__}: {measured.__doc__}")
            measured()
