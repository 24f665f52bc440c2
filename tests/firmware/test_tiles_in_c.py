"""The loop in C against `fl.simulate`: every bit of every trace, for each law, contact, effect and more."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.firmware.host_compiler import shared_library
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.loop.tiles_in_c import LoopInC
from frictionloop.rendering.library import LIBRARY

PERIODS, SEED = 2500, 3
BENCH = fl.bench()
KINDS = ("pi", "filtered_pi", "notch_pi", "limit_observer", "lookup")
OTHERS = (
    {"finger.slip_length_um": 0.0}, {"finger.kind": "rigid"}, {"friction.static_ratio": 1.5},
    {"disturbance.kind": "noise"},
    {"controller.jitter_s": 2e-5, "controller.lost_ticks": 0.01}, {"controller.open_until_s": 0.3},
    {"controller.model.table_size": 33}, {"controller.delay_s": 5e-4}, {"sensor.adc_bits": 10},
    {"setpoint.kind": "steps"}, {"setpoint.kind": "log_sweep"}, {"disturbance.kind": "sine"}, fl.fingers(1, 1)[0],
)  # fmt: skip
CASES = {
    **{kind: BENCH.evolve({"controller.kind": kind}) for kind in KINDS},
    **{name: BENCH.evolve(setpoint={"kind": "effect", "effect": effect}) for name, effect in LIBRARY.items()},
    **{", ".join(values)[:40]: BENCH.evolve(values) for values in OTHERS},
}


@pytest.fixture(scope="module")
def lowered(tmp_path_factory):
    """Return each System's numbers, and the library that runs them all."""
    loop, found, path = LoopInC(), {}, tmp_path_factory.mktemp("loop") / "loop.c"
    for name, system in CASES.items():
        traces = np.zeros((len(traces_of(system)), PERIODS))
        found[name] = loop.lower(system, SEED, traces=traces.reshape(-1)), traces
    path.write_text(loop.text(), encoding="utf-8")
    library = ctypes.CDLL(str(shared_library("loop", [path], flags=("-std=c11", "-O2", "-w", "-ffp-contract=off"))))
    library.advance.argtypes = [ctypes.c_void_p, ctypes.c_int32, ctypes.c_int32, ctypes.c_void_p]
    return library, found


@pytest.mark.parametrize("name", CASES)
def test_the_loop_in_c_has_the_bits_of_simulate(lowered, name):
    library, found = lowered
    tile, traces = found[name]
    samples = {"setpoint_samples": tile.setpoint, "disturbance_samples": tile.disturbance}
    tile.shared.point(**{each: np.append(take(0, PERIODS), 0.0) for each, take in samples.items()})
    middle = 777  # in the midst of a block of noise
    for start, stop in ((0, middle), (middle, PERIODS)):
        library.advance(tile.slab.data.ctypes.data, start, stop, tile.shared.record.ctypes.data)
    run = fl.simulate(CASES[name], PERIODS / 5000, seed=SEED)
    expected = np.stack([run[each].values.astype(float) for each in traces_of(CASES[name])])
    assert np.array_equal(traces.view(np.int64), expected.view(np.int64))


def test_the_rig_of_the_paper_is_refused():
    with pytest.raises(fl.FrictionloopError, match="quadrature: the paper's rig") as refused:
        LoopInC().lower(fl.paper())
    assert refused.value.code == "NO-C"
