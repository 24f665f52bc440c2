"""Section 4.2 as a protocol: one finger, five strokes at each of three levels. All of it was fixed before any run.

The paper had one person slide at 20 mm/s, five times for each of three set-points, and recorded 50 periods of 1 Hz.
Read as ten periods a stroke: 200 mm of the plate's 255. Everything else here is assumed.

The finger: of ``fl.fingers(1000, 1)`` those that reach 0.3 and 0.9 N throughout a stroke, and of these the one whose f0
and tau are nearest to the medians of all 1000, on logarithmic scales in units of their standard deviations.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from frictionloop.loop.parallel_runs import Job, simulate_all
from frictionloop.parameters import RETUNED, Sine, Steps, System, bench
from frictionloop.parameters.presets import PAPER_SLIP_LENGTH_UM
from frictionloop.physics.fingers import Fingers, fingers, nearest_to_median
from frictionloop.physics.reach import capable

FINGERS, POPULATION_SEED = 1000, 1
LOW_N, HIGH_N = 0.3, 0.9
"""Forces that are "reliably achievable" (paper, Sec. 4.2)."""
LEVELS_N, AMPLITUDE_N, FREQUENCY_HZ = (0.4, 0.6, 0.8), 0.1, 1.0
"""Set-points: three sines (paper, Sec. 4.2)."""
START_S, SCORED_S = 1.0, 10.0
"""A stroke starts with a second that does not count, then come ten periods."""
STROKE_S = START_S + SCORED_S
STROKE_MM = 240.0
"""A path that the stroke of 11 s does not reach the end of."""
LOADS = (1.0, 1.21, 0.83, 1.08, 0.92)
"""Mean load of each stroke over the finger's own: quantiles of a log-normal of 15 % in mixed order."""
EVERY_S = 20.0
"""One stroke begins so long after the other; the finger dries in the air between."""
STEP_LEVELS_N, STEP_EVERY_S = (0.4, 0.8), 0.5
"""Levels and pace of the steps of Fig. 5b: the lowest and the highest middle of the sines."""
POPULATION = 26
"""Fingers of the population that are run, the first ones: as many as the paper has trials in Fig. 1a."""
F0, TAU = "friction.nominal_n", "friction.susceptibility_per_um2"


def population() -> Fingers:
    """Return the 1000 fingers, all with one slip length."""
    own = {"finger.slip_length_um": PAPER_SLIP_LENGTH_UM}
    return Fingers(each | own for each in fingers(FINGERS, POPULATION_SEED))


def chosen(people: Fingers) -> int:
    """Return the number of the finger that the rule picks."""
    able = capable(people, LOW_N, HIGH_N, contact_s=SCORED_S)["capable"].values
    return nearest_to_median(people, able)


def occluded(system: System, w0: float) -> System:
    """Return a system whose finger starts with occlusion at w0 instead of 0, 0 to 1.

    1 + (M - 1) w and 1 - l w are linear in w, and w goes on from w0 as w0 + (1 - w0) w' with w' starting at 0, so f0,
    M, tau and l of the same law stand for it exactly.
    """
    friction: Any = system.friction
    gain, loss = 1.0 + (friction.occlusion_ratio - 1.0) * w0, 1.0 - friction.moist_loss * w0
    return system.evolve(
        {
            F0: friction.nominal_n * gain,
            "friction.occlusion_ratio": 1.0 + (friction.occlusion_ratio - 1.0) * (1.0 - w0) / gain,
            TAU: friction.susceptibility_per_um2 * loss,
            "friction.moist_loss": friction.moist_loss * (1.0 - w0) / loss,
        }
    )


def occlusion_at_starts(system: System) -> list[float]:
    """Return how occluded the finger is at the start of each stroke, 0 at the first."""
    friction: Any = system.friction
    dry, found = float(np.exp(-(EVERY_S - STROKE_S) / friction.drying_s)), [0.0]
    for _ in LOADS[1:]:
        at_end = 1.0 - (1.0 - found[-1]) * float(np.exp(-STROKE_S / friction.occlusion_s))
        found.append(at_end * dry)
    return found


def occlusion_at_end(system: System) -> float:
    """Return how occluded the finger is at the end of the last stroke."""
    friction: Any = system.friction
    return 1.0 - (1.0 - occlusion_at_starts(system)[-1]) * float(np.exp(-STROKE_S / friction.occlusion_s))


def the_bench() -> System:
    """Return the bench with the slip length of the report."""
    return bench().evolve({"finger.slip_length_um": PAPER_SLIP_LENGTH_UM})


def finger_system(finger: Mapping[str, float]) -> System:
    """Return the bench under a finger that makes one long stroke at a time."""
    return the_bench().evolve({**finger, "motion.stroke_mm": STROKE_MM})


def strokes(system: System) -> list[System]:
    """Return the five strokes of one finger, which differ in load and in how moist the finger is by then."""
    load_n: float = system.motion.load_n  # type: ignore[union-attr]
    moist = zip(LOADS, occlusion_at_starts(system), strict=True)
    return [occluded(system, w0).evolve({"motion.load_n": share * load_n}) for share, w0 in moist]


def steps() -> Steps:
    """Return the set-point of Fig. 5b."""
    times = np.arange(0.0, STROKE_S, STEP_EVERY_S).round(9)
    return Steps(times_s=tuple(times.tolist()), levels_n=tuple(STEP_LEVELS_N[k % 2] for k in range(times.size)))


def sine(level_n: float) -> Sine:
    """Return the set-point of one level."""
    return Sine(offset_n=level_n, amplitude_n=AMPLITUDE_N, frequency_hz=FREQUENCY_HZ)


def seed_of(level: int, stroke: int) -> int:
    """Return the seed of a stroke: every one passes over another place and trembles anew, whatever controls it."""
    return len(LOADS) * level + stroke


OPEN, PRINTED, RETUNED_GAINS, IDEAL = "open loop", "printed gains", "re-tuned gains", "ideal sensor, no delay"
SLOW, WITH_KP = "Ki = 30 1/s", "with Kp = 0.1"
CONTROLLERS: dict[str, Mapping[str, Any]] = {
    OPEN: {"controller.kind": "lookup"},
    PRINTED: {},
    RETUNED_GAINS: RETUNED,
    SLOW: {"controller.kp": 0.0, "controller.ki": 30.0},
    IDEAL: {"sensor.kind": "lowpass", "controller.delay_s": 0.0},
}
"""What commands the plate. The integral of 30 1/s (assumed) is stable at all contacts and speeds of a design.

The last is a control: the printed gains, the sensor of Section 2, no computing delay.
"""
PROPORTIONAL = {**RETUNED, "controller.kp": 0.1}
"""The re-tuned gains with as much Kp as to Ki = 111 1/s is in the printed ratio, if Ki is per sample."""
CLOSED = (PRINTED, RETUNED_GAINS, SLOW, IDEAL)
KEPT = ("f_r", "f_a", "a", "u", "saturated", "scored")


def run_all(jobs: Iterable[Job]) -> list[xr.Dataset]:
    """Return the scored part of the stroke of every (system, seed)."""
    runs = simulate_all(jobs, STROKE_S, KEPT, START_S)
    return [run.assign_coords(time=run["time"] - START_S) for run in runs]


def tracking(system: System, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return f_r, f_a (N), a (um) and saturated over ``level``, ``stroke`` and ``time`` for a bench with a finger."""
    some = strokes(system.evolve(overrides))
    jobs = [
        (stroke.evolve({"setpoint": sine(level_n)}), seed_of(i, j))
        for i, level_n in enumerate(LEVELS_N)
        for j, stroke in enumerate(some)
    ]
    runs, n = run_all(jobs), len(some)
    levels = [xr.concat(runs[n * i : n * (i + 1)], "stroke") for i in range(len(LEVELS_N))]
    return xr.concat(levels, "level").assign_coords(level=list(LEVELS_N))


def stepping(system: System, overrides: Mapping[str, Any]) -> xr.Dataset:
    """Return the same over ``stroke`` and ``time`` for a set-point that steps."""
    some = strokes(system.evolve({**overrides, "setpoint": steps()}))
    return xr.concat(run_all((stroke, seed_of(0, j)) for j, stroke in enumerate(some)), "stroke")


class Fit(NamedTuple):
    """Goodness of fit to f_a = f_r, of a regression of f_a on f_r, its slope, and the rms of f_a - f_r in N."""

    r2_identity: float
    r2_regression: float
    slope: float
    error_n: float
    spread_n: float
    """Standard deviation of f_a about its regression on f_r, N."""


def fit(runs: xr.Dataset) -> Fit:
    """Return both kinds of R2 over all that counts in a Dataset (as in loop/metrics, for several runs together)."""
    r, f = (runs[name].values[runs["scored"].values] for name in ("f_r", "f_a"))
    error2, spread = np.mean((f - r) ** 2), r.var()
    covariance = np.mean((r - r.mean()) * (f - f.mean()))
    regression = float(covariance**2 / (spread * f.var()))
    return Fit(
        float(1.0 - error2 / spread),
        regression,
        float(covariance / spread),
        float(np.sqrt(error2)),
        float(np.sqrt((1.0 - regression) * f.var())),
    )
