"""The example of a law from outside: it brings the force to the set-point, and competes as any entrant."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.design.comparison.entrants import entrants
from frictionloop.loop.blocks import forget

FILE = Path(__file__).parents[2] / "examples" / "sliding_mode.py"


@pytest.fixture(scope="module")
def example():
    spec = importlib.util.spec_from_file_location("sliding_mode", FILE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    forget()


def test_on_a_rigid_finger_the_mean_force_is_the_set_point(example):
    plain = {"finger.kind": "rigid", "disturbance": fl.Constant(offset_n=0.05), "setpoint": fl.Constant(offset_n=0.6)}
    run = fl.simulate(fl.bench().evolve({**plain, "controller.kind": "sliding_mode"}), 4.0)
    assert float(run.f_a[10_000:].mean()) == pytest.approx(0.6, abs=2e-3)


def test_the_step_is_implicit_and_ends_in_the_sliding_surface(example):
    """|s| <= k2 dt is taken away whole in a period; beyond it w moves by k2 dt, u by k1 (|s| - k2 dt)^(1/2) more."""
    gains, dt = example.Gains(0.02, 10.0, 0.1, 0.95), 2e-4
    for s in (1e-3, -1e-3, 0.01, -0.01):
        state, command = example.sliding_mode(
            example.State(-0.4), fl.Measurement(0.5 + s, 0, 0, 0, 1.0), 0.5, gains, dt
        )
        moved = -np.sign(s) * min(abs(s), 2e-3)
        assert state.w + 0.4 == pytest.approx(moved, abs=1e-12)
        beyond = np.sign(s) * 0.02 * np.sqrt(max(abs(s) - 2e-3, 0.0))
        assert command.u == pytest.approx(0.95 - 0.4 + moved - beyond, abs=1e-12)


def test_it_is_an_entrant_by_its_kind(example):
    assert list(entrants(["lookup", "sliding_mode"])) == ["lookup", "sliding_mode"]
