"""The observer of the friction force: its model against scipy, its gains, and what it does while no finger slides."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import frictionloop as fl
from frictionloop.control.force_observer import held_step, observe_step, predict_step
from frictionloop.control.observer_gains import observer_gains, observer_start
from frictionloop.sensing.measurement import Measurement

MODEL = fl.Model(nominal_n=0.95, resonance_hz=145.0)
SLIDES = Measurement(0.6, 0.0, 0.02, 0.5, 1.0)


def believes(**changes):
    return fl.ObserverController(**{"delay_s": 200e-6, "model": MODEL, "bandwidth_hz": 640.0} | changes)


def plant(model, commands, delay_s, rate_hz, disturbance_n, times):
    """The equations of the module, integrated by scipy: [p, x1, x2, x3] at ``times``."""
    plate, pole, omega = (2 * np.pi * hz for hz in (model.plate_hz, model.sensor_hz, model.resonance_hz))
    high = model.nominal_n

    def rates(t, x, c):
        p, x1, x2, x3 = x
        force = p + disturbance_n
        return [plate * (c - p), omega * x2, omega * (force - x1 - x2 / model.resonance_q), pole * (x1 - x3)]

    edges = [0.0, *(k / rate_hz + delay_s for k in range(len(commands)))]
    held, x, found = [high, *commands], np.array([high, high + disturbance_n, 0.0, high + disturbance_n]), {}
    for start, stop, c in zip(edges, [*edges[1:], times[-1] + 1e-9], held, strict=True):
        inside = times[(times >= start) & (times < stop)]
        if stop > start:
            run = solve_ivp(rates, (start, stop), x, args=(c,), t_eval=[*inside, stop], rtol=1e-10, atol=1e-12)
            found |= dict(zip(inside, run.y.T, strict=False))
            x = run.y[:, -1]
    return np.array([found[t] for t in times])


@pytest.mark.parametrize("delay_s", [0.0, 130e-6, 200e-6, 470e-6])
def test_the_believed_plant_is_that_of_the_equations(delay_s):
    """Without corrections, under steps of the command that are applied any time after their sample."""
    gains = observer_gains(believes(delay_s=delay_s))._replace(k1=0.0, k2=0.0, k3=0.0, kd=0.0)
    commands, disturbance_n = [0.5, 0.3, 0.9, 0.6, 0.6, 0.2] * 5, 0.13
    times = np.arange(len(commands)) / 5000.0
    expected = plant(MODEL, commands, delay_s, 5000.0, disturbance_n, times)
    state = observer_start(believes(delay_s=delay_s))
    got = []
    for k, command in enumerate(commands):
        reading = 0.95 + disturbance_n if k == 0 else 0.0
        state = observe_step(state, SLIDES._replace(force=reading), gains)
        got.append([state.plate, state.spring, state.rate, state.reading])
        state = predict_step(state, command, gains)
    np.testing.assert_allclose(got, expected, atol=2e-9)


def test_ahead_is_the_plate_once_all_commands_have_acted():
    gains = observer_gains(believes(delay_s=600e-6))
    state = observer_start(believes())
    aheads, plates = [], []
    for command in (0.5, 0.2, 0.9, 0.4, 0.4, 0.4, 0.7):
        state = observe_step(state, SLIDES, gains)
        aheads.append(state.ahead)
        plates.append(state.plate)
        state = predict_step(state, command, gains)
    np.testing.assert_allclose(plates[3:], aheads[:-3], rtol=1e-14)


def test_the_gains_are_those_of_python_control():
    """Against ``control.dlqe`` and a Riccati recursion of our own, on the model read back out of the entries."""
    control = pytest.importorskip("control")
    c = believes()
    g = observer_gains(c)
    transition = np.array(
        [[g.x11, g.x12, 0, g.x1d], [g.x21, g.x22, 0, g.x2d], [g.x31, g.x32, g.x33, g.x3d], [0, 0, 0, 1]]
    )
    noise = np.diag([0, 0, 0, (2 * np.pi * c.bandwidth_hz / c.rate_hz) ** 2])
    reading = np.array([[0.0, 0.0, 1.0, 0.0]])
    predictor, _, _ = control.dlqe(transition, np.eye(4), reading, noise, np.eye(1))
    np.testing.assert_allclose(predictor.ravel(), transition @ [g.k1, g.k2, g.k3, g.kd], rtol=1e-7)
    covariance = np.eye(4)
    for _ in range(4000):
        k = covariance @ reading.T / (reading @ covariance @ reading.T + 1)
        covariance = transition @ (covariance - k @ reading @ covariance) @ transition.T + noise
    np.testing.assert_allclose(k.ravel(), [g.k1, g.k2, g.k3, g.kd], rtol=1e-7)


def test_a_quick_sensor_without_springs_gives_the_scalar_filter():
    """x3 = p + d, a random walk in white noise: K = P/(P + 1), P = (q + sqrt(q^2 + 4 q))/2, q = (2 pi f/rate)^2."""
    quick = MODEL.model_copy(update={"resonance_hz": 0.0, "sensor_hz": 1e6})
    for bandwidth_hz in (20.0, 640.0):
        g = observer_gains(believes(model=quick, bandwidth_hz=bandwidth_hz))
        q = (2 * np.pi * bandwidth_hz / 5000.0) ** 2
        p = (q + np.sqrt(q * q + 4 * q)) / 2
        assert g.kd == pytest.approx(p / (p + 1), rel=1e-6)


readings = st.lists(
    st.tuples(st.floats(-2.5, 2.5), st.floats(-0.2, 0.2), st.sampled_from([0.0, 1.0]), st.floats(0.08, 0.95)),
    min_size=1, max_size=200,
)  # fmt: skip


@given(readings, st.sampled_from([0.0, 200e-6, 350e-6, 1.6e-3]))
def test_no_reading_and_no_command_makes_the_observer_unbounded(sequence, delay_s):
    """d is clamped, the plate lies between its commands, and the suspension is a stable filter of bounded inputs."""
    c = believes(delay_s=delay_s)
    gains, state = observer_gains(c), observer_start(c)
    for force, speed, valid, command in sequence:
        state = observe_step(state, Measurement(force, 0.0, speed, 0.5, valid), gains)
        assert abs(state.rest) <= gains.limit and abs(state.kept) <= gains.limit
        state = predict_step(state, command, gains)
        assert 0.08 - 1e-12 <= state.plate <= 0.95 + 1e-12 and 0.08 - 1e-12 <= state.ahead <= 0.95 + 1e-12
        # 2 Q times the largest force that p, d and corrections make together, 5 N.
        assert max(abs(state.spring), abs(state.rate), abs(state.reading)) < 200.0


def slide(state, gains, force_n, periods, valid=1.0, speed=0.02):
    """Let a plant that is the believed one, with this much unknown force, be observed."""
    for _ in range(periods):
        state = observe_step(state, Measurement(force_n, 0.0, speed, 0.5, valid), gains)
        state = predict_step(state, 0.5, gains)
    return state


def test_what_was_unknown_is_held_while_the_finger_does_not_slide_and_no_kick_follows():
    gains, state = observer_gains(believes()), observer_start(believes())
    state = slide(state, gains, 0.7, 2000)
    assert state.kept == pytest.approx(0.2, abs=1e-6)
    held = state.kept
    lifted = slide(state, gains, 0.0, 1000, valid=0.0)
    assert lifted.kept == held
    assert lifted.reading == pytest.approx(0.0, abs=1e-6)
    landed = slide(lifted, gains, 0.7, 1000, valid=0.0)
    again = observe_step(landed, SLIDES._replace(force=0.7), gains)
    assert again.kept == pytest.approx(held, abs=1e-6)
    assert slide(landed, gains, 0.7, 50).kept == pytest.approx(held, abs=1e-6)


def test_a_reversal_turns_the_forces_on_the_sensor():
    """The same force on the same springs, read the other way round: estimates change sign, and nothing is corrected."""
    gains, state = observer_gains(believes()), observer_start(believes())
    state = slide(state, gains, 0.7, 2000)
    turned = observe_step(state, Measurement(-0.7, 0.0, -0.02, 0.5, 0.0), gains)
    assert turned.spring == pytest.approx(-0.7, abs=1e-6)
    assert turned.plate + turned.rest == pytest.approx(-0.7, abs=1e-6)
    assert turned.kept == state.kept


@given(st.floats(0.08, 0.95), st.floats(0.08, 0.95))
def test_the_held_command_takes_the_plate_there_or_is_at_its_end(ahead, wanted):
    gains = observer_gains(believes())
    command = held_step(ahead, wanted, gains, 0.08, 0.95)
    assert 0.08 <= command <= 0.95
    reached = command + (ahead - command) * gains.pp
    if 0.08 < command < 0.95:
        assert reached == pytest.approx(wanted, abs=1e-12)
    else:
        assert (reached - ahead) * (wanted - ahead) >= -1e-12


def test_a_delay_longer_than_the_commands_that_are_kept_is_refused():
    with pytest.raises(fl.FrictionloopError, match="9 control periods"):
        fl.bench().evolve({"controller.kind": "observer", "controller.delay_s": 1.8e-3})
