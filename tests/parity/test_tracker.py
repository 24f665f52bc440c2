"""The tracker in the C core: one step against the float64 step, on the bench and from any state, and closed loops."""

from __future__ import annotations

import math

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.tracker import HIGHEST, LARGEST_BY_C, LARGEST_BY_T, LARGEST_N, LOWEST
from frictionloop.control.tracker_gains import tracker_gains
from frictionloop.control.tracker_state import TrackerState
from frictionloop.firmware.compiled import quantised_gains

SYSTEM = fl.bench().evolve({"controller.kind": "tracker"})
TRACKER = SYSTEM.controller
MODEL = TRACKER.model
SLIDER = {"motion.stroke_mm": 240.0, "finger.contact": "slider"}
FAST = {"motion.speed_mm_s": 80.0}
FORCE_N = 5e-5
"""Allowed difference of the force command: a quarter of what the firmware may differ by."""
STATES = dict(zip(TrackerState._fields, range(len(TrackerState._fields)), strict=True))
RANGES = {
    "amplitude": (0.0, MODEL.max_amplitude_um), "command": (0.0, MODEL.max_amplitude_um),
    "limit": (LOWEST, HIGHEST), "trusted": (LOWEST, HIGHEST), "load": (math.log2(0.04), 4.0),
    "compliance": (0.0, TRACKER.largest_compliance_um_per_n), "fall": (0.2, 3.0),
    "friction": (-LARGEST_N, LARGEST_N), "friction_before": (-LARGEST_N, LARGEST_N),
    "spring": (-20.0, 20.0), "rate": (-67.0, 67.0), "reading": (-13.0, 13.0),
    "rising": (-1e4, 1e4), "falling": (0.0, 1e4), "quick": (-4e4, 4e4),
    "power_c": (0.0, 4e-4), "power_t": (0.0, 16.0), "leapt": (0.0, 1.0),
}  # fmt: skip
"""What is clamped; the sensor as far as wild readings of +-2.5 N drive it (tests/unit/test_tracker_properties)."""
RANGES |= {f"by_c{i}": (-size, size) for i, size in enumerate((0.3, 0.3, 0.1, 0.3, LARGEST_BY_C))}
RANGES |= {f"by_t{i}": (-size, size) for i, size in enumerate((5.0, 5.0, 2.0, 5.0, LARGEST_BY_T))}
"""Sensitivities begin anew where the reading's is above these; the others a sixth of what their formats hold."""


ALLOWED = dict.fromkeys(TrackerState._fields, 7e-7) | {
    "command": 2.6e-6, "rising": 1e-3, "falling": 1e-3, "quick": 1e-3, "compliance": 1e-4, "fall": 1e-6,
    "power_c": 1e-16, "power_t": 5e-15,
    **{f"by_c{i}": 1e-7 for i in range(4)}, "by_c4": 3e-9, **{f"by_t{i}": 7e-7 for i in range(4)}, "by_t4": 2e-8,
}  # fmt: skip
"""Allowed difference of a next state: of forces a hundredth of the converter's step (76 uN), of logarithms alike; of
the command, of what `squares` makes of it, as much from the limit and from the wanted limit, over tau / ln 2 = 0.55
um^-2; of the readings' sensitivities 3e-4 of the roots of what their mean squares are compared with (1e-10 and 5e-9),
of these 1e-6 of that; of compliance and fall 1/20000 and 1/200 of what they move in a tick at most."""


def squares(commands_um, forces):
    """Differences of commands as those of the square of the wanted amplitude, um^2.

    It is the square that is computed from logarithms; a root has no bound on its slope where it begins. The float64 law
    wants the amplitude w that its force stands for, and commands (w - what is left of the last)/(1 - decay).
    """
    wanted_um = np.sqrt(np.log(MODEL.nominal_n / forces) / MODEL.susceptibility_per_um2)
    off_um = commands_um / tracker_gains(TRACKER).own.inverse
    return off_um * (2.0 * wanted_um + off_um)


def along_the_bench(count, seed, changes):
    """Measurements and set-points of a run that the tracker itself controls."""
    run = fl.simulate(SYSTEM.evolve(changes), duration_s=count / 5000.0, seed=seed)
    rows = np.column_stack([run[name].values for name in ("f_m", "position", "speed", "load", "sliding")])
    return rows.astype(float), run["f_r"].values.astype(float)


def any_states(count, seed):
    """States anywhere in their ranges, half of them as small as they usually are, half with a reading as expected."""
    rng = np.random.default_rng(seed)
    states = np.zeros((count, len(STATES)))
    for name, (low, high) in RANGES.items():
        states[:, STATES[name]] = rng.uniform(low, high, count)
    small = 10.0 ** np.where(rng.random((count, 1)) < 0.5, rng.uniform(-6, 0, (count, 1)), 0.0)
    loose = [STATES[name] for name in ("spring", "rate", "rising", "falling", *list(STATES)[15:])]
    states[:, loose] *= small
    states[:, STATES["forward"]] = rng.integers(-1, 2, count)
    return states


def any_inputs(parity, count, seed, states):
    rows, setpoints = parity.wild(count, seed)
    rng = np.random.default_rng(seed)
    rows[:, 2] *= 10.0 ** rng.uniform(-3, 0, count)
    near = rng.random(count) < 0.5
    reading = np.clip(states[:, STATES["reading"]], -2.5, 2.5)
    rows[near, 0] = np.clip(reading + rng.normal(0.0, 0.02, count), -2.5, 2.5)[near]
    return rows, setpoints


def check_any(parity, count, seed):
    states, fixed = any_states(count, seed), parity.FixedLaw(TRACKER)
    counts, back = parity.quantised(*any_inputs(parity, count, seed, states))
    stored = fixed.stored(states)
    _, forces = parity.FloatLaw(TRACKER).each(fixed.meant(stored), *back)
    _, out = fixed.each(stored, *counts)
    assert np.max(np.abs(out[:, 0] / 2.0**28 - forces)) < FORCE_N


COARSE = pytest.mark.xfail(
    strict=True, reason="experimental: with its designed schedule a sensitivity is off by 3.1e-9 instead of 3e-9"
)


@pytest.mark.parametrize(
    "changes",
    [{}, SLIDER, FAST, pytest.param(SLIDER | FAST, marks=COARSE)],
    ids=["turns", "slider", "fast", "fast slider"],
)
def test_force_and_states_agree_on_the_bench(parity, changes):
    difference, forces, states = parity.one_step(TRACKER, along_the_bench(20_000, 1, changes))
    assert np.max(np.abs(difference)) < FORCE_N
    states[:, STATES["command"]] = squares(states[:, STATES["command"]], forces)
    worst = dict(zip(STATES, np.max(np.abs(states), axis=0), strict=True))
    assert {name: value for name, value in worst.items() if value > ALLOWED[name]} == {}


def test_force_agrees_from_any_state(parity):
    check_any(parity, 20_000, 2)


@pytest.mark.slow
def test_force_agrees_from_a_million_states(parity):
    for seed in range(3, 8):
        check_any(parity, 200_000, seed)


def test_force_agrees_along_wild_inputs(parity):
    """Sensitivities leave their formats then; both forms go on from what the formats hold of them."""
    law, fixed = parity.FloatLaw(TRACKER), parity.FixedLaw(TRACKER)
    counts, back = parity.quantised(*parity.wild(50_000, 8))
    stored = fixed.stored(law.along(*back), clip=True)
    _, forces = law.each(fixed.meant(stored), *back)
    _, out = fixed.each(stored, *counts)
    assert np.max(np.abs(out[:, 0] / 2.0**28 - forces)) < FORCE_N


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"largest_jump_n": 0.9}, "controller.largest_jump_n"),
        ({"schedule": ((200.0, *TRACKER.schedule[0][1:]), *TRACKER.schedule[1:])}, "controller.schedule"),
        ({"schedule": (*TRACKER.schedule[:9], (*TRACKER.schedule[9][:5], 1e-3, 0.9))}, "controller.schedule"),
        ({"skin_stiffness_n_m": 1e6}, "controller.skin_stiffness_n_m"),
    ],
)
def test_what_does_not_fit_is_one_line(changes, says):
    with pytest.raises(fl.FrictionloopError) as error:
        quantised_gains(TRACKER.model_copy(update=changes))
    assert str(error.value).startswith(says) and "\n" not in str(error.value)
