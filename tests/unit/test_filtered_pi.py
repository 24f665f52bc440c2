"""PI behind a cascade of biquads: against scipy and NumPy, by hand, and what it must never do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from held_sections import FREE, HELD, section
from hypothesis import given, settings
from hypothesis import strategies as st
from run_filtered import CLAMP, RATE, TOLD, columns, run
from scipy import signal

import frictionloop as fl
from frictionloop.control.expected_reading import ExpectedState
from frictionloop.control.filtered_pi import filtered_pi_gains, filtered_pi_start, hold_gain, sections_of
from frictionloop.control.laws import law_of
from frictionloop.control.notch import notch_section, section_response
from frictionloop.control.pi import PiGains, PiState, pi_step
from frictionloop.loop.kernel.slab import ROW, law_rows
from frictionloop.quantities.flat_tuples import flat
from frictionloop.sensing.measurement import Measurement


def sos_of(sections):
    return np.array([[b0, b1, b2, 1.0, a1, a2] for b0, b1, b2, a1, a2 in sections])


def filters(count, seed):
    """Stable sections, poles and zeros at random, within -2 to 2."""
    draw = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        radius, angle = draw.uniform(0.2, 0.97), draw.uniform(0.0, np.pi)
        b = draw.uniform(-1.0, 1.0, 3)
        found.append((*b.tolist(), -2 * radius * math.cos(angle), radius**2))
    return tuple(found)


def test_a_law_fits_its_rows():
    law = law_of(fl.NotchPiController())
    states, gains, kept = map(flat, law_rows(law))
    used = [*states, *gains, *kept]
    assert len(set(used)) == len(used) and set(used) <= set(ROW["law"])
    assert len(flat(filtered_pi_gains(fl.NotchPiController(feedforward=True)))) == len(gains)
    assert len(flat(filtered_pi_start(fl.NotchPiController()))) == len(states)
    assert law is law_of(fl.FilteredPiController())


@pytest.mark.parametrize("count", range(7))
def test_filter_and_pi_against_scipy_and_numpy(count):
    """Cumulative sum and sosfilt where nothing clamps."""
    draw = np.random.default_rng(count)
    sections, error = filters(count, count), 0.01 * draw.standard_normal(400)
    controller = fl.FilteredPiController(kp=0.3, ki=50.0, sections=sections)
    got, _ = run(controller, np.full(400, 0.5), 0.5 - error, clamp=(-100.0, 100.0))
    filtered = signal.sosfilt(sos_of(sections), error) if count else error
    integral = 50.0 / RATE * np.concatenate([[0.0], np.cumsum(filtered)[:-1]])
    np.testing.assert_allclose(
        got[:, 0], 0.3 * filtered + integral, rtol=0, atol=1e-12 * np.max(np.abs(filtered)) * 400
    )
    assert not got[:, 1].any()


def test_clamp_and_conditional_integration_in_plain_python():
    """The contract's text on the filtered error, with a notch, through long stretches in the clamp."""
    draw = np.random.default_rng(3)
    setpoint = np.repeat(draw.uniform(0.0, 1.2, 20), 50)
    force = 0.5 + 0.4 * np.sin(np.arange(1000) / 40.0)
    controller = fl.NotchPiController(kp=0.5, ki=300.0, notch_depth=0.1, notch_width=0.5)
    got, states = run(controller, setpoint, force)
    t = np.tan(np.pi * controller.notch_hz / RATE)
    analogue = lambda zeta: [1.0, 2 * zeta * t, t * t]  # noqa: E731  (s in units of 2 rate)
    b, a = signal.bilinear(analogue(controller.notch_depth), analogue(controller.notch_width), fs=0.5)
    filtered = signal.lfilter(b, a, setpoint - force)
    integral = 0.0
    for k, e in enumerate(filtered):
        v = 0.5 * e + integral
        assert got[k, 0] == pytest.approx(min(max(v, CLAMP[0]), CLAMP[1]), abs=1e-12)
        if not ((v > CLAMP[1] and e > 0) or (v < CLAMP[0] and e < 0)):
            integral += 300.0 / RATE * e
        assert states[k, 0] == pytest.approx(integral, abs=1e-11)
    assert 0.2 < got[:, 1].mean() < 0.9  # the clamp did act, and did let go


@pytest.mark.parametrize(("hz", "depth", "width"), [(138.0, 0.1, 0.5), (10.0, 0.0, 10.0), (2400.0, 0.5, 0.5)])
def test_notch_against_scipy(hz, depth, width):
    """Bilinear with prewarping: scipy maps the analogue notch whose centre is warped to 2 rate tan(pi f/rate)."""
    w = 2 * RATE * math.tan(math.pi * hz / RATE)
    b, a = signal.bilinear([1, 2 * depth * w, w * w], [1, 2 * width * w, w * w], fs=RATE)
    got = notch_section(hz, depth, width, RATE)
    np.testing.assert_allclose(got, [*b, *a[1:]], rtol=1e-9, atol=1e-12)
    frequency = np.array([1.0, hz, 0.4 * RATE])
    np.testing.assert_allclose(
        section_response(got, frequency, RATE), signal.freqz(b, a, frequency, fs=RATE)[1], rtol=1e-7, atol=1e-12
    )
    assert abs(section_response(got, hz, RATE)) == pytest.approx(depth / width, abs=1e-12)
    assert sum(got[:3]) / (1 + sum(got[3:])) == pytest.approx(1.0, rel=1e-9)  # at rest
    assert max(map(abs, got)) <= 2.0


@given(st.lists(st.floats(-5, 5), min_size=1, max_size=60), st.integers(0, 2**31))
def test_without_sections_it_is_pi_to_the_bit(forces, seed):
    draw = np.random.default_rng(seed)
    setpoints, valid = draw.uniform(-0.5, 1.5, len(forces)), draw.integers(0, 2, len(forces))
    kp, ki = draw.uniform(0, 20), draw.uniform(0, 500)
    got, states = run(fl.FilteredPiController(kp=kp, ki=ki), setpoints, forces, valid)
    state = PiState(0.0)
    for k, (r, f, ok) in enumerate(zip(setpoints, forces, valid, strict=True)):
        told = Measurement(float(f), 0.0, 0.0, 0.0, float(ok))
        state, command = pi_step(state, told, float(r), PiGains(kp, ki, *CLAMP), 1.0 / RATE)
        assert (command.u, command.saturated, state.integral) == (*got[k], states[k, 0])


@settings(max_examples=150)
@given(TOLD, st.integers(0, 6), st.booleans(), st.booleans(), st.floats(0, 5), st.floats(0, 1000))
def test_it_never_leaves_its_clamp_nor_winds_up(told, count, feedforward, overdrive, kp, ki):
    """For an error e inside |e| <= E: I goes on only while v is inside, so it stays within the clamp and ki dt E."""
    forces, setpoints, valid = columns(told)
    controller = fl.FilteredPiController(
        kp=kp, ki=ki, sections=filters(count, 1), feedforward=feedforward, overdrive=overdrive, delay_s=330e-6
    )
    got, states = run(controller, setpoints, forces, valid)
    assert np.all((got[:, 0] >= CLAMP[0]) & (got[:, 0] <= CLAMP[1]))
    assert np.all(np.isfinite(states))
    first, read = 13, 13 + ExpectedState._fields.index("reading")
    expected = np.concatenate([[0.8], states[:-1, read]]) if feedforward else setpoints
    error = valid * (expected - forces)
    largest = np.max(np.abs(signal.sosfilt(sos_of(filters(count, 1)), error) if count else error))
    ahead = setpoints if feedforward else np.zeros(1)
    room = ki / RATE * largest * (1 + 1e-9) + 1e-9
    assert np.max(states[:, 0]) <= max(0.0, CLAMP[1] - ahead.min()) + room
    assert np.min(states[:, 0]) >= min(0.0, CLAMP[0] - ahead.max()) - room
    # Forces of the expected reading: at most what a resonance of step inputs within the commands can reach.
    if feedforward:
        span = max(CLAMP[1], setpoints.max(), 0.8) - min(CLAMP[0], setpoints.min(), 0.8)
        assert np.ptp(np.append(states[:, first : first + 5], 0.8)) <= span * (1 + 1e-9)


@pytest.mark.slow
@settings(max_examples=30)
@given(st.floats(-5, 5), st.booleans())
def test_a_filter_that_rested_does_not_kick(before, feedforward):
    """While the finger does not slide u holds; back again, the first error meets filters at rest."""
    controller = fl.NotchPiController(kp=0.2, ki=100.0, notch_depth=0.1, notch_width=0.5, feedforward=feedforward)
    valid = np.concatenate([np.ones(50), np.zeros(2000), np.ones(1)])
    force = np.concatenate([np.full(50, before), np.full(2000, 77.0), np.full(1, 0.5)])
    got, states = run(controller, np.full(2051, 0.5), force, valid)
    assert np.ptp(got[50:2050, 0]) == 0.0
    assert np.ptp(states[49:2050, 0]) == 0.0
    assert np.max(np.abs(states[2049, 1:13])) < 1e-12
    ahead = 0.5 if feedforward else 0.0
    reading = states[2049, 20] if feedforward else 0.5
    b0 = notch_section(controller.notch_hz, controller.notch_depth, controller.notch_width, RATE)[0]
    v = ahead + states[2049, 0] + 0.2 * b0 * (reading - 0.5)
    assert got[2050, 0] == pytest.approx(min(max(v, CLAMP[0]), CLAMP[1]), abs=1e-12)


def test_without_feedback_the_setpoint_is_commanded():
    controller = fl.NotchPiController(kp=0.0, ki=0.0, feedforward=True)
    setpoint = np.array([0.5, 0.3, 0.05, 1.3, 0.7])
    got, _ = run(controller, setpoint, np.zeros(5))
    np.testing.assert_allclose(got, np.column_stack([[0.5, 0.3, 0.1, 0.9, 0.7], [0, 0, 1, 1, 0]]), rtol=1e-15)


def test_the_closed_form_of_a_notch_in_z():
    f0, fs, depth, width = 149.0, 4000.0, 0.05, 1.2
    t = math.tan(math.pi * f0 / fs)
    below = 1 + t**2 + 2 * width * t
    b1 = 2 * (t**2 - 1) / below
    expected = ((1 + t**2 + 2 * depth * t) / below, b1, (1 + t**2 - 2 * depth * t) / below)
    found = notch_section(f0, depth, width, fs)
    assert found == pytest.approx((*expected, b1, (1 + t**2 - 2 * width * t) / below), rel=1e-12)


# Sections that the command holds: against a transfer function in scipy, their bounds, and no kick of old errors.


KP, KI = 0.4, 60.0
THROUGH = (1.0, 0.0, 0.0, 0.0, 0.0)

INVERSES = [np.sum(np.abs(signal.lfilter([1.0, *s[3:]], s[:3], np.eye(1, 40000)[0]))) for s in HELD]
"""Largest output of each one's inverse for an input of at most 1."""


def law(held, **changes):
    return fl.FilteredPiController(kp=KP, ki=KI, sections=(*FREE, *held), **changes)


@pytest.mark.parametrize("count", [1, 2, 4])
def test_held_sections_are_hanus_on_a_state_space(count):
    """x+ = A x + B (e + (u - v)/D), v = C x + D e: sections and PI as one, in a realisation of another kind."""
    error = np.cumsum(np.random.default_rng(count).standard_normal(1500)) / 40.0
    got, _ = run(law(HELD[:count]), np.full(1500, 0.5), 0.5 - error)
    A, B, C, D = np.zeros((0, 0)), np.zeros((0, 1)), np.zeros((1, 0)), np.ones((1, 1))
    for b, a in [*((s[:3], [1.0, *s[3:]]) for s in HELD[:count]), ([KP, KI / RATE - KP], [1.0, -1.0])]:
        a2, b2, c2, d2 = signal.tf2ss(b, a)
        A, B = np.block([[A, np.zeros((len(A), len(a2)))], [b2 @ C, a2]]), np.vstack([B, b2 @ D])
        C, D = np.hstack([d2 @ C, c2]), d2 @ D
    x, wanted = np.zeros((len(A), 1)), []
    for e in signal.sosfilt([[*s[:3], 1.0, *s[3:]] for s in FREE], error):
        v = C @ x + D * e
        u = np.clip(v, *CLAMP)
        x = A @ x + B @ (e + (u - v) / D)
        wanted.append(u[0, 0])
    np.testing.assert_allclose(got[:, 0], wanted, rtol=0, atol=1e-9)
    assert 0.1 < got[:, 1].mean() < 0.95


@settings(max_examples=60)
@given(TOLD, st.integers(1, 4), st.booleans())
def test_nothing_winds_up_whatever_the_error(told, count, feedforward):
    """kp y + I is the command, so I moves towards it by ki dt/kp of the way, and never beyond."""
    forces, setpoints, valid = columns(told)
    controller = law(HELD[:count], feedforward=feedforward, overdrive=feedforward)
    assert filtered_pi_gains(controller).hold != 0.0
    got, states = run(controller, setpoints, forces, valid)
    assert np.all((got[:, 0] >= CLAMP[0]) & (got[:, 0] <= CLAMP[1]))
    ahead = setpoints if feedforward else np.zeros(1)
    assert np.max(states[:, 0]) <= max(0.0, CLAMP[1] - ahead.min()) + 1e-9
    assert np.min(states[:, 0]) >= min(0.0, CLAMP[0] - ahead.max()) - 1e-9
    # A held section has the output that leads to the command, and the input that its inverse makes of that.
    y = (np.ptp(np.append(ahead, 0.0)) + CLAMP[1]) / KP
    for i in reversed(range(count)):
        b0, _, b2, _, a2 = HELD[i]
        x = y * INVERSES[i]
        assert np.max(np.abs(states[:, 5 + 2 * i])) <= (y + abs(b0) * x) * (1 + 1e-9)
        assert np.max(np.abs(states[:, 6 + 2 * i])) <= (abs(a2) * y + abs(b2) * x) * (1 + 1e-9)
        y = x


@pytest.mark.parametrize("feedforward", [False, True])
@pytest.mark.parametrize("gap", [1, 40, 400])
def test_a_long_memory_does_not_kick_after_an_invalid_stretch(gap, feedforward):
    """1 N of error for 60 ms, as of a skin that stretches, then no sliding, then no error: u goes on from I."""
    steps = 300 + gap + 1000

    def kick(sections):
        controller = fl.FilteredPiController(kp=KP, ki=KI, sections=sections, feedforward=feedforward)
        valid, error, setpoint = np.ones(steps), np.zeros(steps), np.full(steps, 0.5)
        valid[300 : 300 + gap], error[:300] = 0.0, -1.0
        # The expected reading follows from set-point and clamp alone.
        _, states = run(controller, setpoint, setpoint, valid)
        reading = np.concatenate([[0.8], states[:-1, 20]]) if feedforward else setpoint
        got, states = run(controller, setpoint, reading - error, valid)
        assert got[30:300, 1].all()  # the clamp acted
        rest = np.clip(states[300 + gap - 1, 0] + 0.5 * feedforward, *CLAMP)
        return np.abs(got[300 + gap :, 0] - rest)

    slow = (HELD[1], HELD[0])
    held = kick((THROUGH, THROUGH, *slow))
    assert held[0] < 1e-3
    assert held.max() < 0.06
    # The same sections left free remember the error for longer than that.
    assert kick(slow).max() > 0.1


@pytest.mark.parametrize(
    ("kp", "ki", "held", "wanted"),
    [
        (0.5, 50.0, (), 0.0),
        (0.5, 50.0, (section([0.5, 0.2], [0.9, 0.9], 0.25),), 8.0),
        (0.5, 50.0, (section([1.01, 0.2], [0.9, 0.9]),), 0.0),
        (0.5, 50.0, (section([-1.0, 0.2], [0.9, 0.9]),), 0.0),
        (0.5, 50.0, ((0.0, 0.5, 0.1, -0.5, 0.0),), 0.0),
        (0.5, 2501.0, (section([0.5, 0.2], [0.9, 0.9]),), 0.0),
        (0.0, 0.0, (section([0.5, 0.2], [0.9, 0.9]),), 0.0),
    ],
)
def test_only_what_can_be_inverted_is_held(kp, ki, held, wanted):
    assert hold_gain(kp, ki, (*FREE, *held), 1.0 / RATE) == pytest.approx(wanted, rel=1e-12)


BENCH = fl.bench()
NOTCH = BENCH.evolve({"controller.kind": "notch_pi", "controller.kp": 0.06, "controller.ki": 130.0})
SECTIONS = ((0.9, -1.6, 0.8, -1.6, 0.7), (0.5, 0.5, 0.0, 0.0, 0.0))


def test_out_and_in_again(tmp_path):
    for system in (
        NOTCH.evolve({"controller.notch_hz": 131.5, "controller.feedforward": True}),
        BENCH.evolve({"controller.kind": "filtered_pi", "controller.sections": SECTIONS, "controller.overdrive": True}),
    ):
        path = tmp_path / "mine.toml"
        fl.write_toml(system, path)
        assert fl.read_toml(path) == system
    text = path.read_text()
    assert "sections = [[0.9, -1.6, 0.8, -1.6, 0.7], [0.5, 0.5, 0.0, 0.0, 0.0]]" in text
    assert "notch_hz = 131.5  # Hz" in fl.to_toml(NOTCH.evolve({"controller.notch_hz": 131.5}))


def test_a_change_of_kind_keeps_the_gains_and_the_timing():
    assert (NOTCH.controller.kp, NOTCH.controller.ki) == (0.06, 130.0)
    assert NOTCH.controller.delay_s == BENCH.controller.delay_s
    assert NOTCH.controller.model == BENCH.controller.model
    assert NOTCH.evolve({"controller.kind": "filtered_pi"}).controller.sections == ()


def test_a_delay_of_three_periods_is_followed():
    assert NOTCH.evolve({"controller.feedforward": True, "controller.delay_s": 3 / 5000.0}).controller.feedforward
    assert NOTCH.evolve({"controller.delay_s": 0.1}).controller.delay_s == 0.1  # without it any delay will do


def test_a_sweep_over_the_notch_is_its_runs_one_by_one():
    grid = fl.sweep(
        NOTCH, {"controller.notch_hz": [60.0, 120.0, 138.0, 150.0], "controller.notch_width": [0.2, 0.8]}, 0.2,
        metrics=["rms_error"],
    ).rms_error  # fmt: skip
    assert np.unique(grid.values).size == 8
    for hz, width in ((60.0, 0.8), (150.0, 0.2)):
        system = NOTCH.evolve({"controller.notch_hz": hz, "controller.notch_width": width})
        alone = fl.sweep(system, [{}], 0.2, metrics=["rms_error"]).rms_error.item()
        got = grid.sel({"controller.notch_hz": hz, "controller.notch_width": width}).item()
        assert got == alone
    with pytest.raises(fl.FrictionloopError, match=r"notch_depth = 0\.3: .*notch_width, 0\.2"):
        fl.sweep(NOTCH, {"controller.notch_width": [0.8, 0.2], "controller.notch_depth": [0.1, 0.3]}, 0.2)


def test_both_kinds_run_alike_in_one_tile_and_alone():
    """Filters, delays and feed-forward of their own in each lane; a notch is its one section."""
    sections = sections_of(NOTCH.controller)
    assert len(sections) == 1
    base = NOTCH.evolve(
        {"controller.kind": "filtered_pi", "controller.kp": NOTCH.controller.kp, "controller.ki": NOTCH.controller.ki}
    )
    points = [
        {"controller.sections": sections},
        {"controller.sections": sections * 3},
        {"controller.sections": SECTIONS, "controller.delay_s": 590e-6, "controller.feedforward": True},
        {"controller.sections": (), "controller.overdrive": True, "controller.feedforward": True},
    ]
    got = fl.sweep(base, points, 0.2, metrics=["rms_error"]).rms_error.values.ravel()
    alone = [fl.sweep(base.evolve(p), [{}], 0.2, metrics=["rms_error"]).rms_error.item() for p in points]
    assert got.tolist() == alone
    assert alone[0] == fl.sweep(NOTCH, [{}], 0.2, metrics=["rms_error"]).rms_error.item()
    plain = fl.simulate(BENCH.evolve(fl.RETUNED), 0.2)
    unfiltered = fl.simulate(BENCH.evolve({"controller.kind": "filtered_pi", **fl.RETUNED}), 0.2)
    for name in ("u", "f_a", "saturated"):
        np.testing.assert_array_equal(plain[name], unfiltered[name])
