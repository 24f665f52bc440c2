"""What holds of the tracker whatever the finger does: clamp, bounds, recovery, no kick, and what is wrong input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.laws import law_of
from frictionloop.control.tracker import HIGHEST, LOWEST, tracker_step
from frictionloop.control.tracker_gains import observed, sensor_matrices, tracker_gains, tracker_start
from frictionloop.design.synthesis import design_controller
from frictionloop.loop.kernel.slab import ROW, law_rows
from frictionloop.parameters.tracking import SCHEDULE, TrackerController
from frictionloop.quantities import trees
from frictionloop.sensing.measurement import Measurement

DT = 1.0 / 5000
MODEL = fl.bench().controller.model
C = TrackerController(model=MODEL, rate_hz=5000, delay_s=2e-4)
GAINS = tracker_gains(C)
START = tracker_start(C)
TRUST = max(1.0, *(row[6] for row in SCHEDULE))
BEYOND = (TRUST - 1.0) / (2.0 - TRUST) * (HIGHEST - LOWEST)
"""How far a mean with a gain of 1 to 2 leaves the range [L, H] of what it follows: e = (t - 1)(H - L + e)."""
BOUNDS = {
    "amplitude": (0.0, MODEL.max_amplitude_um), "command": (0.0, MODEL.max_amplitude_um),
    "limit": (LOWEST, HIGHEST), "trusted": (LOWEST - BEYOND, HIGHEST + BEYOND), "forward": (-1.0, 1.0),
    "load": (math.log2(0.04), 4.0),
    "compliance": (0.0, C.largest_compliance_um_per_n), "fall": (0.2, 3.0),
}  # fmt: skip
"""Hard bounds of what is clamped."""
LOOSE = {"friction": 6.0, "spring": 60.0, "rate": 200.0, "reading": 40.0, "friction_before": 6.0, "rising": 3e4,
         "falling": 3e4, "power_c": 0.1, "power_t": 1e3}  # fmt: skip
LOOSE |= {f"by_c{i}": 1e3 for i in range(5)} | {f"by_t{i}": 1e4 for i in range(5)}
"""Scales for Q31 of what follows readings of +-2.5 N, some three times what 300 wild sequences reached."""

phases = st.lists(
    st.tuples(
        st.integers(1, 120),  # ticks
        st.floats(-2.5, 2.5), st.floats(0.0, 2.5), st.integers(0, 2**16),  # mean, spread and seed of the readings
        st.one_of(st.just(0.0), st.floats(-0.5, 0.5)),  # speed
        st.one_of(st.just(0.0), st.floats(0.0, 5.0)),  # load
        st.sampled_from([0.0, 1.0]), st.floats(0.0, 2.0),
    ),
    min_size=1, max_size=12,
)  # fmt: skip


def tick(state, y, speed, load, valid, setpoint_n):
    after, (u, saturated) = tracker_step(state, Measurement(y, 0.0, speed, load, valid), setpoint_n, GAINS, DT)
    return after, u, saturated


def driven(phases):
    """Yield every state and command."""
    state = START
    for ticks, mean, spread, seed, speed, load, valid, setpoint_n in phases:
        noise = np.random.default_rng(seed).uniform(-spread, spread, ticks)
        for y in np.clip(mean + noise, -2.5, 2.5):
            state, u, _ = tick(state, float(y), speed, load, valid, setpoint_n)
            yield state, u


@given(phases)
def test_nothing_leaves_its_bounds(phases):
    for state, u in driven(phases):
        assert MODEL.floor_n <= u <= MODEL.nominal_n
        assert all(map(math.isfinite, state))
        for name, (low, high) in BOUNDS.items():
            assert low - 1e-9 <= getattr(state, name) <= high + 1e-9, name
        for name, most in LOOSE.items():
            assert abs(getattr(state, name)) < most, name


class Slider:
    """A finger without bristles behind the believed sensor."""

    def __init__(self, limit_n=0.95, tau=0.38):
        self.limit_n, self.tau, self.a, self.command, self.f, self.x = limit_n, tau, 0.0, 0.0, 0.0, np.zeros(3)
        self.A, self.b0, self.b1 = sensor_matrices(observed(C), DT)
        self.pole = math.exp(-2 * math.pi * MODEL.plate_hz * DT)

    def period(self, command):
        after = self.command + (self.a - self.command) * self.pole
        f = self.limit_n * math.exp(-self.tau * after * after)
        self.x = self.A @ self.x + self.b0 * self.f + self.b1 * f
        self.f, self.a, self.command = f, after, command
        return float(self.x[2])


RANG = (
    [(24, 2.0, 0.0, 0, 0.0, 0.0, 1.0, 0.0)],
    [(36, 1.0, 0.0, 0, -0.5, 0.0, 1.0, 0.0), (1, 0.0, 2.0, 0, 0.0, 0.0, 0.0, 0.0), (1, 0.0, 0.0, 0, *[0.0] * 4)],
)
"""Histories after which gains for Ms 2.0, calmed by steep net falls alone, rang on: four ticks a turn, 0.2 N off."""


@pytest.mark.slow
@settings(max_examples=40)
@given(phases)
@example(RANG[0])
@example(RANG[1])
def test_it_follows_again_after_anything(phases):
    """0.8 s after whatever it was, a normal finger is within 60 mN of 0.6 N: nothing has wound up.

    The contact may have to be learnt anew: half a second is not enough for every history.
    """
    state = START
    for reached, _ in driven(phases):
        state = reached
    finger, y = Slider(), 0.0
    for _ in range(4000):
        state, _, _ = tick(state, y, 0.03, 0.5, 1.0, 0.6)
        y = finger.period(state.command)
    assert abs(finger.f - 0.6) < 0.06


@pytest.mark.parametrize("off_ticks", [1, 5, 50, 500])
def test_no_kick_when_valid_comes_and_goes(off_ticks):
    """At rest an unchanged reading leaves nothing to correct, so u stays to rounding, off, on and after."""
    state, finger, y = START, Slider(), 0.0
    for _ in range(20000):
        state, u, _ = tick(state, y, 0.03, 0.5, 1.0, 0.6)
        y = finger.period(state.command)
    held = u
    for valid in [0.0] * off_ticks + [1.0] * 500:
        state, u, _ = tick(state, y, 0.03, 0.5, valid, 0.6)
        assert u == pytest.approx(held, rel=2e-4)


def test_frozen_states_are_the_estimates():
    """The analysis holds compliance, susceptibility and the mean squares that scale their steps, and no more."""
    law = law_of(C)
    assert law.frozen == ("compliance", "fall", "power_c", "power_t")
    assert set(law.frozen) <= set(trees.names(law.state))


def test_it_fits_its_rows():
    law = law_of(C)
    states, gains, kept = map(trees.flat, law_rows(law))
    used = [*states, *gains, *kept]
    assert len(set(used)) == len(used) and set(used) <= set(ROW["law"])
    assert (len(states), len(gains)) == (len(START), len(trees.flat(GAINS)))


def one_line(error):
    assert "\n" not in str(error.value)
    return str(error.value)


def with_tracker(**changes):
    changed = {f"controller.{name}": value for name, value in changes.items()}
    return fl.bench().evolve({"controller.kind": "tracker", **changed})


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"delay_s": 201e-6}, "at most one control period, 0.0002 s"),
        ({"schedule": (*SCHEDULE[:9], (1, 1, 1, 1, 1, 0.0, 0.9))}, "share of the error above 0"),
        ({"schedule": (*SCHEDULE[:9], (1, 1, 1, 1, 1, 1.1, 0.9))}, "at most 1"),
        ({"schedule": (*SCHEDULE[:9], (1, 1, 1, 1, 1, 1.0, 0.0))}, "trust above 0"),
        ({"schedule": (*SCHEDULE[:9], (-1, 1, 1, 1, 1, 1.0, 0.9))}, "gains must be at least 0"),
        ({"schedule": SCHEDULE[:4]}, "schedule"),
        ({"schedule": (*SCHEDULE[:9], (1, 1, 1, 1, 1, 1.0))}, "schedule"),
        ({"compliance_um_per_n": -1.0}, "compliance_um_per_n"),
        ({"compliance_um_per_n": 90.0}, "largest_compliance_um_per_n"),
    ],
)
def test_bad_parameters_are_one_line(changes, says):
    with pytest.raises(fl.FrictionloopError) as error:
        with_tracker(**changes)
    assert says in one_line(error)


def test_a_model_without_resonance_is_one_line():
    with pytest.raises(fl.FrictionloopError, match=r"^controller\.model\.resonance_hz = 0 Hz: [^\n]*$"):
        fl.simulate(with_tracker(**{"model.resonance_hz": 0.0}), duration_s=0.01)


def test_a_tracker_is_not_designed_for_a_sensor_without_springs():
    with pytest.raises(fl.FrictionloopError, match=r'^sensor\.kind = "lowpass"[^\n]*$'):
        design_controller(fl.paper(), "tracker")
