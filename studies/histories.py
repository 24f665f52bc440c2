"""Does a law ring after what a hand and a set-point may do? Random histories, then a hold, beside the hold alone.

``python -m studies.histories 20 100 2`` runs 20 histories on each of 100 capable fingers, two of them under a variant,
writes *results/histories.csv* and draws the worst ten in *runs/histories.png*. A finger rings where half a second of
the hold has more rms from 100 to 400 Hz than twice what the same stroke has there without the history, and than 5 mN.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import butter, sosfiltfilt

import frictionloop as fl
from frictionloop.design.comparison import trial_protocol
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.simulate import traced
from frictionloop.parameters import Constant, Steps, System, bench
from frictionloop.physics.fingers import fingers
from studies.conditions import LENGTHS_UM, LIMIT_OBSERVER
from studies.kept import keep
from studies.other_friction import OTHER, OtherFriction

HISTORY_S, HOLD_S, WINDOW_S, LEVEL_N = 4.0, 3.0, 0.5, 0.6
BAND_HZ, FLOOR_N = (100.0, 400.0), 5e-3
FRESH_SEED = 4711
"""Of fingers that nothing was tuned or compared on."""
PICTURE = Path(__file__).parent / "runs" / "histories.png"
VARIANTS: dict[str, dict[str, Any]] = {
    "as described": {},
    "resonance 10 % lower": {"sensor.resonance_hz": 0.9},
    "resonance 10 % higher": {"sensor.resonance_hz": 1.1},
    "sensor's pole at 300 Hz": {"sensor.cutoff_hz": 0.3},
    "skin's damping times 4": {"finger.damping_n_s_m": 4.0},
    "load 20 % higher": {"motion.load_n": 1.2},
    "load 20 % lower": {"motion.load_n": 0.8},
    "no roughness": {"friction.roughness_rms": 0.0},
    "position noise times 10": {"touch.position.noise_um": 10.0},
    "susceptibility times 1.5": {"friction.susceptibility_per_um2": 1.5},
    "friction falls with a^1.8": {"other": {"exponent": 1.8}},
    "a tenth of friction stays": {"other": {"floor": 0.1}},
}
"""Factors on what there is, or another friction law; the law is not told."""


class Ringing(NamedTuple):
    """One finger after one history."""

    excess: float
    """Largest rms of a window over the larger of twice that without the history and 5 mN: above 1 it rings."""
    rms_n: float
    window: int
    case: Mapping[str, Any]
    after: np.ndarray
    """f_a of the hold, N."""
    alone: np.ndarray


def histories(count: int, seed: int) -> Iterator[tuple[Steps, dict[str, Any]]]:
    """Yield random steps (levels, and times from 20 to 500 ms apart), and the stroke they happen in."""
    draw = np.random.default_rng(seed)
    for _ in range(count):
        quick, slow = np.sort(np.exp(draw.uniform(np.log(0.02), np.log(0.5), 2)))
        gaps = np.exp(draw.uniform(np.log(quick), np.log(slow) + 1e-9, 400))
        times = np.append(0.0, np.cumsum(gaps)).round(4)
        times = np.append(times[times < HISTORY_S], HISTORY_S)
        levels = np.append(draw.uniform(0.35, 0.8, times.size - 1), LEVEL_N)
        stroke = {
            "motion.speed_mm_s": float(draw.choice([20.0, 40.0, 80.0, 150.0])),
            "motion.stroke_mm": float(draw.choice([40.0, 120.0, 240.0])),
            "motion.contact_s": float(draw.choice([0.0, 0.0, 1.0])),
            "finger.slip_length_um": float(draw.choice(LENGTHS_UM)),
        }
        yield Steps(times_s=tuple(times.tolist()), levels_n=tuple(levels.tolist())), stroke


def windows(run: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return the rms of `BAND_HZ` in each window of a run, N."""
    sos, width = butter(4, BAND_HZ, "bandpass", fs=rate_hz, output="sos"), round(WINDOW_S * rate_hz)
    return np.sqrt(np.mean(sosfiltfilt(sos, run)[: run.size // width * width].reshape(-1, width) ** 2, axis=1))


def ringing(system: System, points: Sequence[Mapping[str, Any]], history: Steps, seed: int) -> list[Ringing]:
    """Return how much each finger rings after a history."""
    after, alone = (_holds(system.evolve({"setpoint": each}), points, seed) for each in (history, CONSTANT))
    found = []
    for point, held, plain in zip(points, after, alone, strict=True):
        rms = windows(held, system.controller.rate_hz)
        over = rms / np.maximum(2.0 * windows(plain, system.controller.rate_hz), FLOOR_N)
        k = int(np.argmax(over))
        found.append(Ringing(float(over[k]), float(rms[k]), k, point, held, plain))
    return found


CONSTANT, NOTHING = Constant(offset_n=LEVEL_N), np.empty(0)  # a hold, and one that is not drawn
NONE: Mapping[str, Any] = {}


def _holds(system: System, points: Sequence[Mapping[str, Any]], seed: int) -> Iterator[np.ndarray]:
    for start in range(0, len(points), LANES):
        systems = [system.evolve(dict(point)) for point in points[start : start + LANES]]
        for run in traced(systems, [seed] * len(systems), HISTORY_S + HOLD_S):
            yield run["f_a"].values[run["time"].values >= HISTORY_S]


def scaled(system: System, point: Mapping[str, Any], factors: Mapping[str, Any]) -> dict[str, Any]:
    """Return a finger with factors on its values, or on those of the system."""
    found = dict(point)
    for path, factor in factors.items():
        if path == "other":
            there: Any = system.evolve(found)
            same = {name: value for name, value in there.friction if name != "kind"}
            found |= {"friction": OtherFriction(**same, **factor)}
            continue
        value: Any = system.evolve(found)
        for name in path.split("."):
            value = getattr(value, name)
        found[path] = factor * value
    return found


def campaign(
    count: int, people: int, factors: Mapping[str, Any], own: Mapping[str, Any] = NONE, seed: int = 1
) -> list[Ringing]:
    """Return every finger after every history, under one variant; ``own`` are more overrides of the limit observer."""
    found = []
    drawn = fingers(5 * people, FRESH_SEED)
    for k, (history, stroke) in enumerate(histories(count, seed)):
        system = bench().evolve({**stroke, **LIMIT_OBSERVER, **own})
        able = trial_protocol.able(system, drawn, stroke["motion.speed_mm_s"]).nonzero()[0][:people]
        points = [scaled(system, drawn[i], factors) for i in able]
        found += [each._replace(case={**each.case, **stroke}) for each in ringing(system, points, history, k)]
        found.sort(key=lambda each: -each.excess)
        found[10:] = [each._replace(after=NOTHING, alone=NOTHING) for each in found[10:]]
    return found


def draw(
    worst: Sequence[Ringing], path: Path = PICTURE, names: tuple[str, str] = ("after it", "without the history")
) -> None:
    """Draw the windows that rang most."""
    import matplotlib.pyplot as plt

    path.parent.mkdir(exist_ok=True)
    figure, axes = plt.subplots(5, 2, figsize=(9, 10), sharex=True, layout="constrained")
    for axis, each in zip(axes.T.ravel(), worst, strict=False):
        shown = slice(2500 * each.window, 2500 * (each.window + 1))
        time = np.arange(2500) / 5.0
        axis.plot(time, each.alone[shown], color="0.7", lw=0.8, label=names[1])
        axis.plot(time, each.after[shown], color="C0", lw=0.8, label=names[0])
        case = each.case
        person, z, speed = (case[name] for name in ("motion.person", "finger.slip_length_um", "motion.speed_mm_s"))
        stroke = f"finger {person:g}, {z:g} um, {speed:g} mm/s"
        axis.set_title(f"{stroke}: {1e3 * each.rms_n:.1f} mN, {each.excess:.2f}", fontsize=8)
    axes[0, 0].legend(fontsize=7)
    figure.supxlabel("ms of the window")
    figure.supylabel("friction (N)")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def rows(count: int, people: int, each: int) -> Iterator[list[Any]]:
    """Yield the rows of the table, and draw the worst of those as described."""
    for name, factors in VARIANTS.items():
        runs = campaign(each if factors else count, people, factors)
        runs.sort(key=lambda run: -run.excess)
        rang, loudest = sum(run.excess > 1.0 for run in runs), max(run.rms_n for run in runs)
        if not factors:
            draw(runs[:10])
        yield [name, len(runs), rang, f"{runs[0].excess:.2f}", f"{1e3 * loudest:.1f}"]


def main(count: int = 40, people: int = 24, each: int = 4) -> None:
    """Run all variants, ``each`` with so many of the histories."""
    fl.register(OTHER, OtherFriction)
    heads = ["what differs", "runs", "rang", "largest excess", "loudest window, mN"]
    keep("histories", f"histories {count} {people} {each}", heads, rows(count, people, each))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
