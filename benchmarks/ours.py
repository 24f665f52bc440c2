"""Every call to frictionloop that the benchmark makes, so that a change of its interface is followed here alone."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

from paper import Array

METRICS = ("r2_identity", "saturation_index")


def version() -> str | None:
    """Version of frictionloop, None when it is not installed."""
    try:
        import frictionloop as fl
    except ModuleNotFoundError:
        return None
    return str(fl.__version__)


def _system(noise: bool, duration_s: float, gains: dict[str, float] | None = None) -> Any:
    import frictionloop as fl

    changes: dict[str, float] = dict(gains or {})
    if not noise:
        changes["sensor.noise_rms_n"] = 0.0
    if duration_s > fl.paper().setpoint.sweep_s:  # the sweep refuses to run past its end, so long runs sweep slowly
        changes["setpoint.sweep_s"] = duration_s
    return fl.paper().evolve(changes) if changes else fl.paper()


def one(kp: float, ki: float, duration_s: float = 10.0, noise: bool = True) -> Array:
    """One run with all traces; returns f_a."""
    import frictionloop as fl

    system = _system(noise, duration_s, {"controller.kp": kp, "controller.ki": ki})
    return fl.simulate(system, duration_s=duration_s, seed=0)["f_a"].values


def grid(kp_axis: Array, ki_axis: Array, threads: int, duration_s: float = 10.0, noise: bool = False) -> Array:
    """R2_identity on a grid of gains, Kp outer; with noise, all lanes share seed 0 (common random numbers)."""
    import frictionloop as fl

    points = {"controller.kp": kp_axis, "controller.ki": ki_axis}
    system = _system(noise, duration_s)
    swept = fl.sweep(system, points, duration_s=duration_s, seeds=1, metrics=METRICS, n_jobs=threads)
    return swept["r2_identity"].values.ravel()


def seeds(lanes: int, threads: int, duration_s: float = 10.0) -> Array:
    """One point, a different noise seed in every lane."""
    import frictionloop as fl

    points = {"controller.kp": np.array([10.0])}
    system = _system(True, duration_s)
    swept = fl.sweep(system, points, duration_s=duration_s, seeds=lanes, metrics=METRICS, n_jobs=threads)
    return swept["r2_identity"].values.ravel()


def bench_steps() -> dict[str, tuple[Any, tuple[str, ...]]]:
    """Systems that add one block of the bench after the other, and the metrics asked of them."""
    import frictionloop as fl

    bench, held = fl.bench().evolve(fl.RETUNED), ("r2_identity",)
    still = {"motion.kind": "sliding", "finger.kind": "rigid", "friction.kind": "gaussian"}
    level = {"setpoint": bench.setpoint, "disturbance": bench.disturbance}
    found = {
        "the loop of Section 2": (fl.paper().evolve(level), held),
        "+ resonant sensor, noise, converter, delay": (bench.evolve(still), held),
        "+ strokes, tremor, roughness, touch sensors": (bench.evolve({"finger.kind": "rigid"}), held),
        "+ skin, slip length": (bench, held),
        "  without slip length": (bench.evolve({"finger.slip_length_um": 0.0}), held),
        "+ perceptual index": (bench, (*held, "perceptual_index")),
    }
    late = bench.evolve({"controller.jitter_s": 2e-5, "controller.lost_ticks": 0.01})
    return found | {"+ jitter, lost ticks": (late, (*held, "perceptual_index"))}


def effect_steps() -> dict[str, tuple[Any, tuple[str, ...]]]:
    """The bench, and the same with a map as its set-point."""
    import frictionloop as fl

    bench, held = fl.bench().evolve(fl.RETUNED), ("r2_identity",)
    map_n = tuple((0.45 + 0.15 * np.sin(2 * np.pi * np.arange(2048) / 20.0)).tolist())
    effect = fl.rendering.Map(values_n=map_n, pitch_mm=0.1, start_mm=-102.4)
    played = bench.evolve(setpoint={"kind": "effect", "effect": effect})
    return {"the bench": (bench, held), "+ effect, map of 2,048 points": (played, held)}


def bench(system: Any, metrics: tuple[str, ...], lanes: int, threads: int, duration_s: float = 10.0) -> Array:
    """One system with a seed of its own in every lane."""
    import frictionloop as fl

    swept = fl.sweep(system, [{}], duration_s=duration_s, seeds=lanes, metrics=metrics, n_jobs=threads)
    return swept["r2_identity"].values.ravel()


def population(fingers: int, threads: int, duration_s: float = 10.0) -> Array:
    """A population on the bench: every finger and its noise different."""
    import frictionloop as fl

    system = fl.bench().evolve(fl.RETUNED)
    metrics = ("r2_identity", "rms_error", "perceptual_index")
    swept = fl.sweep(system, fl.fingers(fingers, 1), duration_s=duration_s, metrics=metrics, n_jobs=threads)
    return swept["r2_identity"].values.ravel()


def stepped(fingers: int, threads: int, duration_s: float) -> Array:
    """A population on the bench that follows steps every 0.5 s, scored as touch has it and by its step times."""
    import frictionloop as fl

    times_s = np.arange(0.0, duration_s, 0.5)
    levels_n = np.where(np.arange(times_s.size) % 2, 0.7, 0.5)
    steps = fl.Steps(times_s=tuple(times_s.tolist()), levels_n=tuple(levels_n.tolist()))
    system = fl.bench().evolve(fl.RETUNED | {"setpoint": steps})
    times = ("rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s")
    metrics = ("r2_identity", "rms_error", "perceptual_index", *times)
    swept = fl.sweep(system, fl.fingers(fingers, 1), duration_s=duration_s, metrics=metrics, n_jobs=threads)
    return swept["rise_63_s"].values.ravel()


def commands() -> dict[str, list[str]]:
    """Command lines whose whole process is timed."""
    program = str(Path(sys.executable).with_name("frictionloop"))
    return {
        "frictionloop --help": [program, "--help"],
        "frictionloop simulate": [program, "simulate", "--preset", "paper"],
    }
