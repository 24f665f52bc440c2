"""The laws on the observer of the friction force: one step of the C core against the float64 step, and ranges."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.force_observer import ObserverState
from frictionloop.control.laws import NUMBERED, law_of
from frictionloop.control.observer_gains import observer_gains
from frictionloop.firmware.compiled import host_library, quantised_gains, state_places
from frictionloop.quantities import trees

MODEL = fl.bench().controller.model
NO_RESONANCE = MODEL.model_copy(update={"resonance_hz": 0.0})
MUCH = MODEL.model_copy(update={"nominal_n": 2.2, "resonance_hz": 139.0, "sensor_hz": 350.0})
CONTROLLERS = {
    "observer": fl.ObserverController(delay_s=200e-6, model=MODEL),
    "observer, much friction": fl.ObserverController(delay_s=330e-6, model=MUCH),
    "observer, no resonance, no delay": fl.ObserverController(overdrive=False, model=NO_RESONANCE),
    "observer, longest delay": fl.ObserverController(delay_s=1790e-6, bandwidth_hz=100.0, model=MODEL),
    "super-twisting": fl.SuperTwistingController(delay_s=200e-6, model=MODEL),
    "super-twisting, much friction": fl.SuperTwistingController(delay_s=330e-6, overdrive=False, model=MUCH),
    "super-twisting, gentle": fl.SuperTwistingController(k1=30.0, k2=300.0, model=NO_RESONANCE),
}
FORCE_N = 2e-5
"""Allowed difference of the force command: a tenth of what the firmware may differ by."""
STEPS = 5
"""Allowed difference of a next state in steps of its places, for gains of 0: a row of seven products, each of a number
off by half a step and a coefficient below 1, and its own rounding. The reading is rounded too, times the gains."""


def random_states(controller, count, seed):
    """States anywhere in what the law is made for: forces within the clamp, the sensor ringing to 7 N."""
    rng, model = np.random.default_rng(seed), controller.model
    low, high = model.floor_n, model.nominal_n
    states = rng.uniform(low, high, (count, trees.size(law_of(controller).state)))
    states[:, 2:5] = rng.uniform(-7.0, 7.0, (count, 3)) * 10.0 ** rng.uniform(-3, 0, (count, 1))
    states[:, 5:7] = rng.uniform(-2.0 * high, 2.0 * high, (count, 2))
    states[:, 7], states[:, 8] = rng.integers(0, 2, count), rng.integers(-1, 2, count)
    if states.shape[1] > len(ObserverState._fields):
        states[:, 18] = rng.uniform(-0.2, 0.2, count)
        states[:, 19], states[:, 20] = states[:, 6] + rng.normal(0.0, 0.05, count), rng.uniform(0.0, 2.0, count)
    return states


def check(controller, difference, states):
    assert np.max(np.abs(difference)) < FORCE_N
    gains = observer_gains(controller)
    steps = STEPS * (1.0 + max(gains.k1, gains.k2, gains.k3, gains.kd))
    allowed = steps * 2.0 ** -np.array(state_places(controller), dtype=float)
    # The command that is held is 1/(1 - p) of a difference of forces.
    allowed[[1, *range(9, len(ObserverState._fields))]] *= 1.0 + gains.inverse
    assert np.all(np.abs(states) <= allowed)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree(parity, name):
    for inputs in (parity.wild(20_000, 1), parity.realistic(20_000, 2)):
        difference, _, states = parity.one_step(CONTROLLERS[name], inputs)
        check(CONTROLLERS[name], difference, states)


@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree_from_any_state(parity, name):
    controller, count = CONTROLLERS[name], 20_000
    counts, back = parity.quantised(*parity.wild(count, 3))
    fixed, law = parity.FixedLaw(controller), parity.FloatLaw(controller)
    stored = fixed.stored(random_states(controller, count, 4))
    after, forces = law.each(fixed.meant(stored), *back)
    state, out = fixed.each(stored, *counts)
    check(controller, out[:, 0] / 2.0**28 - forces, fixed.meant(state) - after)


@pytest.mark.slow
@pytest.mark.parametrize("name", CONTROLLERS)
def test_force_and_states_agree_a_million_times(parity, name):
    for inputs in (parity.wild(500_000, 5), parity.realistic(500_000, 6)):
        difference, _, states = parity.one_step(CONTROLLERS[name], inputs)
        check(CONTROLLERS[name], difference, states)


@pytest.mark.parametrize("kind", ["observer", "super_twisting"])
def test_both_sides_mean_the_same_places(kind):
    controller = fl.bench().evolve({"controller.kind": kind}).controller
    _, library = host_library()
    places, number = state_places(controller), 1 + NUMBERED.index(law_of(controller))
    assert library.fl_host_states(number) == len(places)
    assert [library.fl_host_places(number, i) for i in range(len(places))] == list(places)


def test_too_much_friction_for_the_format_is_one_line():
    model = MODEL.model_copy(update={"nominal_n": 4.5})
    with pytest.raises(fl.FrictionloopError, match=r"^largest disturbance[^\n]* = 9: [^\n]*fit the firmware$"):
        quantised_gains(fl.ObserverController(model=model))
