"""Reference and bound of step times: closed forms, another integrator, and commands at random that get past neither."""

from __future__ import annotations

import math

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH
from hypothesis import given, settings
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.design.comparison import protocol
from frictionloop.parameters import Skin, Steps
from frictionloop.physics.friction import amplitude_for
from studies.extremes import forces_from_rest, undisturbed
from studies.step_limits import step_limits
from studies.step_reference import drive_time_s, skin_time_s
from studies.time_optimal import passage_s, time_optimal

LEVELS_N, PERIOD_S, LENGTHS_UM = protocol.STEP_LEVELS_N, 2e-4, (11.5, 30.0)
NAMES = ("rise_63_s", "rise_10_90_s", "fall_63_s", "fall_10_90_s")


def bench(speed_mm_s, length_um, **changes):
    moving = {"motion.speed_mm_s": speed_mm_s, "motion.stroke_mm": 240.0, "finger.slip_length_um": length_um}
    return fl.bench().evolve(moving | changes)


def tuning_finger(number, speed_mm_s):
    people = fl.fingers(60, 3)
    able = protocol.able(fl.bench(), people, speed_mm_s)
    return [each for each, is_able in zip(people, able, strict=True) if is_able][number]


def test_references_by_hand():
    """0.32 N over 1000 N/m at 20 mm/s; an envelope of 100 Hz under full drive."""
    skin = Skin(stiffness_n_m=1000.0)
    assert skin_time_s(0.32, skin, 20.0) == pytest.approx(0.32 / (1e3 * 0.02))
    needed = drive_time_s(0.7, 1.5, 2.5, 100.0)
    assert 2.5 + (0.7 - 2.5) * math.exp(-2 * math.pi * 100 * needed) == pytest.approx(1.5, rel=1e-12)
    assert math.isnan(drive_time_s(0.7, 2.5, 2.5, 100.0))
    assert math.isnan(drive_time_s(math.nan, 1.0, 2.5, 100.0))


@pytest.mark.parametrize("delay_s", [0.0, 2e-4, 2.5e-4])
def test_the_limit_of_a_slider_under_full_drive_meets_reference_and_bound(delay_s):
    """f = f0 e^(-tau a^2) from 0.75 to 0.35 N, followed over time, passes 10, 63 and 90 % when both say."""
    own = {"friction.nominal_n": 1.1, "friction.load_exponent": 0.0, "controller.delay_s": delay_s}
    t = np.linspace(0.0, 5e-3, 500_001)
    start = math.sqrt(math.log(1.1 / 0.75) / 0.38)
    cutoff_hz = fl.bench().plate.cutoff_hz
    force = 1.1 * np.exp(-0.38 * (2.5 + (start - 2.5) * np.exp(-2 * np.pi * cutoff_hz * t)) ** 2)
    at = {share: t[np.argmax(force <= 0.75 - share * 0.4)] for share in (0.1, 0.632, 0.9)}
    found = step_limits(bench(20.0, 0.0), [own])
    for each, error_s in ((found.reference, 3e-8), (found.bound, 1e-6)):
        assert each.fall_63_s == pytest.approx(delay_s + at[0.632], abs=error_s)
        assert each.fall_10_90_s == pytest.approx(at[0.9] - at[0.1], abs=error_s)
    assert found.reference.rise_63_s == pytest.approx(found.reference.rise_10_90_s * 0.632 / 0.8)


def test_a_rigid_finger_is_as_fast_as_its_plate():
    """a decays from that of a level to that of another: ln(a1/a2)/(2 pi f), after the delay."""
    own = undisturbed(bench(20.0, 11.5).evolve({"friction.load_exponent": 0.0, "friction.nominal_n": 1.1}))
    found = time_optimal([own.evolve({"finger.kind": "rigid"})], LEVELS_N)
    rate = 2.0 * math.pi * own.plate.cutoff_hz
    a = {share: math.sqrt(math.log(1.1 / (0.35 + 0.4 * share)) / 0.38) for share in (0.0, 0.1, 0.632, 0.9)}
    assert found.rise_63_s[0] == pytest.approx(2e-4 + math.log(a[0.0] / a[0.632]) / rate, abs=1e-6)
    assert found.rise_10_90_s[0] == pytest.approx(math.log(a[0.1] / a[0.9]) / rate, abs=1e-6)


@pytest.mark.parametrize("damping_n_s_m", [0.1, 1.0, 4.0])
def test_a_stuck_skin_without_mass_follows_spring_and_damper(damping_n_s_m):
    """F - F0 = k w t + c w once a plate without inertia has let go."""
    fast = {"plate.kind": "lowpass", "plate.cutoff_hz": 2e5, "plate.max_amplitude_um": 2.5, "controller.delay_s": 0.0}
    light = {"finger.mass_kg": 1e-9, "finger.damping_n_s_m": damping_n_s_m}
    own = undisturbed(bench(20.0, 0.0).evolve(fast | light | {"friction.nominal_n": 1.1}))
    found = time_optimal([own], LEVELS_N)
    lead_s = damping_n_s_m / 1e3
    for time_s, way_n in ((found.rise_63_s, 0.632 * 0.4), (found.rise_10_90_s, 0.32)):
        assert time_s[0] == pytest.approx(way_n / (1e3 * 0.02) - lead_s, abs=5e-5)


def test_rest_is_rest_and_passages_lie_between_samples():
    own = undisturbed(bench(20.0, 11.5).evolve(tuning_finger(0, 20.0)), 0.1)
    held_um = float(amplitude_for(0.5, own.friction))
    forces, period_s = forces_from_rest([own], 0.5, held_um, 0.02)
    assert period_s == pytest.approx(2e-5)
    np.testing.assert_allclose(forces, 0.5, atol=1e-9)
    ramps = np.array([[0.0, 1.0, 0.0], [1.0, 0.5, 0.0], [2.0, 0.0, 0.0]])
    np.testing.assert_allclose(passage_s(ramps, 2.0, 0.75), [1.5, 1.0, np.nan])


def test_a_population_is_its_fingers_and_none_has_what_it_cannot_reach():
    people = [*fl.fingers(3, 3), {"friction.nominal_n": 0.5}, {"motion.load_n": 0.01}]
    together = step_limits(bench(80.0, 11.5), people, 0.2)
    for i, each in enumerate(people):
        alone = step_limits(bench(80.0, 11.5), [each], 0.2)
        for name in NAMES:
            for one, all_ in ((alone.reference, together.reference), (alone.bound, together.bound)):
                np.testing.assert_allclose(getattr(all_, name)[i], getattr(one, name)[0], rtol=1e-9)
    assert all(np.isnan(getattr(together.bound, name)[3:]).all() for name in NAMES)
    assert np.isnan(together.reference.fall_63_s[3:]).all()


def followed(own, rises, commands):
    """Return the times of a step to 63 % and from 10 to 90 %, at control periods, of commands to a finger at rest."""
    start, stop = LEVELS_N if rises else LEVELS_N[::-1]
    loop = fl.Stepper(own)
    for _ in range(400):
        loop.tick(float(amplitude_for(start, own.friction)))
    assert loop.force_n == pytest.approx(start, abs=1e-4)
    forces = np.array([loop.force_n, *[loop.tick(each) and loop.force_n for each in commands]])
    way = (forces - start) / (stop - start)
    at = [int(np.argmax(way >= share)) if (way >= share).any() else math.inf for share in (0.1, 0.632, 0.9)]
    return at[1] * PERIOD_S, (at[2] - at[0]) * PERIOD_S if at[2] < math.inf else math.inf


def never_turning_back(own, rises, shares, extreme):
    """Return commands under which the amplitude goes one way: each share 0 holds it, 1 drives it as fast as can be."""
    a, most = float(amplitude_for(LEVELS_N[not rises], own.friction)), own.plate.max_amplitude_um
    decay, found = math.exp(-2.0 * math.pi * own.plate.cutoff_hz * PERIOD_S), []
    for share in [*shares, *[1.0] * extreme]:
        command = (1.0 - share) * a if rises else a + share * (most - a)
        found.append(command)
        a = command + (a - command) * decay
    return found


LONG = st.lists(st.tuples(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0), st.integers(1, 8)), max_size=8)


@pytest.mark.parametrize("rises", [True, False])
@pytest.mark.parametrize("length_um", LENGTHS_UM)
@settings(max_examples=25)
@given(shares=LONG, number=st.integers(0, 5))
def test_no_drive_that_never_turns_back_beats_the_bound(length_um, rises, shares, number):
    own = undisturbed(bench(80.0, length_um).evolve(tuning_finger(number, 80.0)), 0.1)
    bound = time_optimal([own], LEVELS_N)
    commands = never_turning_back(own, rises, [share for share, times in shares for _ in range(times)], 75)
    to_63_s, whole_s = followed(own, rises, commands)
    assert to_63_s >= (bound.rise_63_s if rises else bound.fall_63_s)[0] - 2e-6
    assert whole_s >= (bound.rise_10_90_s if rises else bound.fall_10_90_s)[0] - PERIOD_S


@pytest.mark.parametrize("length_um", LENGTHS_UM)
@settings(max_examples=25)
@given(commands=st.lists(st.sampled_from([0.0, 2.5]) | st.floats(0.0, 2.5), max_size=12), number=st.integers(0, 5))
def test_no_commands_at_all_fall_to_63_sooner(length_um, commands, number):
    own = undisturbed(bench(20.0, length_um).evolve(tuning_finger(number, 20.0)), 0.1)
    to_63_s, _ = followed(own, False, [*commands, *[2.5] * 15])
    assert to_63_s >= time_optimal([own], LEVELS_N).fall_63_s[0] - 2e-6


@pytest.mark.parametrize("law", [DESIGNED_NOTCH, {"controller.kind": "oracle"}], ids=["notch_pi", "oracle"])
@pytest.mark.parametrize("length_um", LENGTHS_UM)
def test_laws_on_an_undisturbed_finger_are_near_the_bound_and_not_past_it(length_um, law):
    """Within a control period; the best of them needs no more than 1.3 times, but for whole periods."""
    own = undisturbed(bench(20.0, length_um).evolve(tuning_finger(1, 20.0)), 0.1)
    bound = time_optimal([own], LEVELS_N)
    steps = Steps(times_s=tuple(np.arange(0.0, 2.0, 0.25)), levels_n=LEVELS_N * 4)
    run = fl.simulate(own.evolve(law | {"setpoint": steps}), 2.0)
    found = [each for each in fl.step_times(run) if each.start_s > 0.9]
    assert len(found) >= 3
    for each in found:
        way = "rise" if each.to_n > each.from_n else "fall"
        for name, time_s in (("63", each.to_63_s), ("10_90", each.rise_s)):
            shortest_s = getattr(bound, f"{way}_{name}_s")[0]
            assert shortest_s - PERIOD_S <= time_s <= 1.3 * shortest_s + 2.0 * PERIOD_S
