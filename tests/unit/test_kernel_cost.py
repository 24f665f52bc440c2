"""What the kernel must not cost: compiling twice, or memory that grows with the duration."""

from __future__ import annotations

import subprocess
import sys
import textwrap
import tracemalloc

import pytest

import frictionloop as fl
from frictionloop.loop.kernel.slab import LANES
from frictionloop.loop.metric import AgainMetric

FRESH_PROCESS = """
    from numba.core import event

    import frictionloop as fl
    from frictionloop.loop.kernel.step_lifting import _compiled

    with event.install_recorder("numba:compile") as compiled, event.install_recorder("numba:run_pass") as passes:
        fl.simulate(fl.paper(), 0.01)
        fl.sweep(fl.paper(), {"controller.kp": [1.0, 2.0, 3.0]}, 0.01)
        fl.Stepper(fl.paper()).tick(1.0)
    # A bench draws its start by steps called from Python, which are compiled for that; its tiles are not.
    fl.simulate(fl.bench(), 0.01)
    fl.sweep(fl.bench(), {"controller.kp": [1.0, 2.0, 3.0]}, 0.01)
    fl.Stepper(fl.bench()).tick(1.0)
    print(len(compiled.buffer), len(passes.buffer))
    for (build, width, *_), tile in _compiled.items():
        print(build.__name__, width, tile.cache_hits)
"""


@pytest.mark.slow
def test_a_second_process_compiles_nothing():
    def fresh():
        script = [sys.executable, "-c", textwrap.dedent(FRESH_PROCESS)]
        return subprocess.run(script, capture_output=True, text=True, check=True).stdout.splitlines()

    events, *tiles = fresh()
    if events != "0 0" or not all(line.endswith(" 1") for line in tiles):  # no test has compiled it before
        events, *tiles = fresh()
    assert events == "0 0"  # no compilation, nor a pass of the compiler, for the paper
    # Every tile comes from the cache, those of both loops and widths among them.
    assert all(line.endswith(" 1") for line in tiles)
    loops = ("build_paper", "build_sense", "build_law", "build_move")
    assert {f"{build} {width} 1" for build in loops for width in (1, LANES)} <= set(tiles)


def peak_bytes(system, duration_s):
    step_times = ("rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s")
    # What compares a run with others keeps their traces, a point at a time.
    streamed = [name for name, each in fl.METRICS.items() if not isinstance(each, AgainMetric)]
    metrics = [name for name in streamed if system.setpoint.kind == "steps" or name not in step_times]
    tracemalloc.start()
    fl.sweep(system, {"controller.kp": [1.0, 2.0, 3.0, 4.0]}, duration_s, metrics=metrics, n_jobs=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return peak


@pytest.mark.parametrize(
    ("disturbance", "short_s"),
    [
        (fl.Sine(offset_n=0.4, amplitude_n=0.4), 10.0),
        (fl.Steps(times_s=(0.0, 1.0), levels_n=(0.1, 0.3)), 30.0),  # two chunks of 13 s of samples
    ],
    ids=["formula", "sampled"],
)
def test_a_sweeps_memory_does_not_grow_with_its_duration(disturbance, short_s):
    system = fl.paper().evolve({"setpoint": fl.Sine(offset_n=0.6, amplitude_n=0.2), "disturbance": disturbance})
    peak_bytes(system, 0.1)  # imports and caches
    short, long = peak_bytes(system, short_s), peak_bytes(system, 100.0)
    # One trace of 90 s more would be 3.6 MB for a single lane.
    assert long < short + 100_000


@pytest.mark.slow
@pytest.mark.parametrize(
    "setpoint",
    [fl.Sine(offset_n=0.6, amplitude_n=0.1), fl.Steps(times_s=(0.0, 0.5, 1.0), levels_n=(0.4, 0.7, 0.5))],
    ids=["formula", "sampled"],
)
def test_nor_does_that_of_a_bench(setpoint):
    system = fl.bench().evolve({"setpoint": setpoint, **fl.RETUNED})
    peak_bytes(system, 0.1)
    short, long = peak_bytes(system, 14.0), peak_bytes(system, 42.0)
    # One trace of 28 s more would be 1.1 MB for a single lane.
    assert long < short + 100_000


def test_a_run_keeps_its_traces_and_little_more():
    system = fl.paper().evolve({"setpoint": fl.Sine(offset_n=0.6, amplitude_n=0.2)})
    fl.simulate(system, 0.1)
    tracemalloc.start()
    run = fl.simulate(system, 20.0)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    # What check_memory promises: twice the traces.
    assert run.nbytes < peak < 2 * 8 * 7 * 100_000
