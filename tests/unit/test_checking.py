"""A controller that is there: what `check` finds of it, of less gain, of other fingers, and of laws from outside."""

from __future__ import annotations

import json
import math
import tomllib

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH
from own_laws import register_both

import frictionloop as fl
from frictionloop.analysis.margins import gain_factor
from frictionloop.analysis.operating_point import moistest
from frictionloop.design.bench_file import changed_since, read_designed, write_controller
from frictionloop.design.controller_check import check
from frictionloop.design.controller_findings import beyond_range, noisy, of_assumed, unbelieved
from frictionloop.design.grid_corners import broken, corners
from frictionloop.design.operating_grid import ITSELF, with_longest_contact
from frictionloop.design.requirements import Requirements
from frictionloop.loop.companion_runs import swing_n
from frictionloop.loop.registered_blocks import forget
from frictionloop.parameters.motion import one_stroke_a_contact

LIMITED = ITSELF._replace(limits=Requirements().limits)
PI = {"controller.kind": "pi", "controller.kp": 0.05, "controller.ki": 60.0}
ONE_PLACE = {"finger": {"kind": "rigid"}}
LIMIT_OBSERVER = {
    "controller.kind": "limit_observer",
    "controller.model.resonance_hz": 132.0,
    "controller.model.sensor_hz": 550.0,
}
"""Believing in springs below the true ones, as a design does."""
NYQUIST_HZ = 2500.0
GRID = np.linspace(1.0, 2499.0, 500)


def codes(found):
    return {each.code for each in found.findings}


def of(found, code):
    (one,) = [each for each in found.findings if each.code == code]
    return one


@pytest.fixture(scope="module")
def checked():
    return check(fl.bench().evolve(PI))


def test_the_factor_of_a_gain_that_is_real_and_of_one_that_turns():
    # |1 - k c| = 1/Ms first at k = (1 - 1/Ms)/c.
    found = gain_factor(lambda f: np.full(np.shape(f), -0.5 + 0j), GRID, NYQUIST_HZ, 2.0)
    assert found == pytest.approx((1.0 - 1.0 / 2.0) / 0.5)
    # G = exp(-j w) of constant size 1: -1 is reached at w = pi, and the circle of 1/Ms around it first there.
    turning = gain_factor(lambda f: np.exp(-2j * np.pi * np.asarray(f) / 1000.0), GRID, NYQUIST_HZ, 2.0)
    assert turning == pytest.approx(0.5, rel=1e-6)
    # A lag of first order never comes near.
    assert math.isinf(gain_factor(lambda f: 1 / (1 + 1j * np.asarray(f) / 100.0), GRID, NYQUIST_HZ, 1.5))


@pytest.mark.slow
def test_python_control_has_the_margins_of_a_corner(checked):
    """A dry slider is P S with the gain 1 of a model that is right, the resonance 10 % lower."""
    control = pytest.importorskip("control")
    system = fl.bench().evolve(PI)
    (place,) = [each for each in checked.places if (each.slip_length_um, each.speeds_mm_s) == (0.0, (20.0,))]
    (corner,) = [
        each
        for each in place.corners
        if each.off == -0.1 and each.loop.elements.occluded == 0.0 and each.loop.elements.force_n == pytest.approx(0.6)
    ]
    s, ts, m = control.tf("s"), 1.0 / 5000.0, system.sensor
    w = 2 * np.pi * 0.9 * m.resonance_hz
    plate = 1 / (1 + s * 2 * system.plate.q / (2 * np.pi * system.plate.frequency_hz))
    sensor = 1 / (1 + s / (m.q * w) + s**2 / w**2) / (1 + s / (2 * np.pi * m.cutoff_hz))
    held = control.sample_system(control.ss(plate * sensor), ts, "zoh") * control.ss(0, 1, 1, 0, ts)  # 200 us: a period
    kp, ki = PI["controller.kp"], PI["controller.ki"]
    series = control.ss(control.tf([kp, ki * ts - kp], [1, -1], ts)) * held
    assert (np.abs(control.feedback(series).poles()) < 1).all()
    G = series(np.exp(2j * np.pi * np.union1d(np.arange(0.5, 2499, 0.1), np.arange(100, 160, 0.002)) * ts))
    assert corner.sensitivity_peak == pytest.approx(np.max(1 / np.abs(1 + G)), rel=1e-4)
    real = G.real[:-1][(np.diff(np.sign(G.imag)) != 0) & (G.real[:-1] < 0)]  # its own margins lose digits here
    assert corner.loop.margins().gain_margin == pytest.approx(min(-1 / real, key=lambda k: abs(np.log(k))), rel=1e-3)
    factor = corner.loop.gain_factor(corner.limit)
    assert np.max(1 / np.abs(1 + factor * G)) == pytest.approx(corner.limit, rel=1e-4)


@pytest.mark.slow
def test_gains_that_ring_on_a_slider_are_said_not_to_hold_with_those_that_do(checked):
    assert not checked.holds
    assert {place.how for place in checked.places if place.slip_length_um == 0.0} == {"unstable"}
    assert checked.would_hold["controller.ki"] / checked.would_hold["controller.kp"] == pytest.approx(1200.0, rel=1e-3)
    less = check(fl.bench().evolve({**PI, **checked.would_hold}))
    assert less.holds and less.would_hold == {}
    assert min(less.gain_factors) == pytest.approx(1.0, abs=0.005)  # and hardly more would


@pytest.mark.slow
def test_less_gain_never_turns_what_holds_into_what_does_not(checked):
    slider = fl.bench().evolve({**PI, "finger.slip_length_um": 0.0})
    for share in (1.0, 0.83, 0.31, 0.07, 0.002):
        gains = {path: share * value for path, value in checked.would_hold.items()}
        assert broken(corners(slider.evolve(gains), LIMITED)) is None
    more = {path: 1.02 * value for path, value in checked.would_hold.items()}
    assert broken(corners(slider.evolve(more), LIMITED)) is not None


def test_a_place_may_hold_where_another_does_not(checked):
    for place, gain in zip(checked.places, checked.gain_factors, strict=True):
        assert (gain >= 0.999) == (place.how == "within")


def test_the_table_lookup_has_no_loop():
    found = check(fl.bench().evolve({**ONE_PLACE, "controller.kind": "lookup"}))
    assert found.holds and found.gain_factors == (math.inf,)
    assert "NO-LOOP" in codes(found) and not {"PEOPLE-RING", "RING-MOIST"} & codes(found)


@pytest.mark.slow
def test_a_limit_observer_gets_a_margin_that_holds():
    there = fl.bench().evolve({**ONE_PLACE, **LIMIT_OBSERVER, "controller.susceptibility_margin": 0.5})
    found = check(there)
    assert not found.holds
    assert 0.5 < found.would_hold["controller.susceptibility_margin"] < 2.0
    assert check(there.evolve(dict(found.would_hold))).holds


@pytest.mark.slow
@pytest.mark.parametrize("law", [DESIGNED_NOTCH, {"controller.kind": "filtered_pi", "controller.feedforward": True}])
def test_the_gain_of_a_law_with_filters_is_that_of_kp_and_ki(law):
    there = fl.bench().evolve({**ONE_PLACE, **law})
    found = check(there)
    factor = 0.9 * min(found.gain_factors)
    gains = {f"controller.{name}": factor * getattr(there.controller, name) for name in ("kp", "ki")}
    assert min(check(there.evolve(gains)).gain_factors) == pytest.approx(1.0 / 0.9, rel=1e-5)


WEAK = fl.bench().evolve({"controller.kind": "pi", "controller.kp": 0.0, "controller.ki": 7.0})
ON_DAHL = Requirements(slip_lengths_um=(11.5,))


@pytest.fixture
def outside():
    """The bench with laws of somebody's own."""
    register_both()
    yield fl.bench()
    forget()


@pytest.mark.parametrize(("kp", "ki"), [(2.0, 400.0), (0.3, 60.0), (0.15, 100.0)])
def test_a_dead_band_is_not_certified_by_a_slope_of_nothing(outside, kp, ki):
    """Within 2 mN its slope is 0, so Ms is 1; on a smooth finger the force swings nevertheless."""
    found = check(
        outside.evolve({"controller.kind": "dead_band_pi", "controller.kp": kp, "controller.ki": ki}), ON_DAHL
    )
    assert {place.how for place in found.places} == {"within"} and not found.holds and not found.holds_everywhere
    smooth = {"motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "friction.roughness_rms": 0.0}
    run = fl.simulate(found.system.evolve({"setpoint": fl.Constant(offset_n=0.6), **smooth}), 10.0)
    swing_mn = 1e3 * np.ptp(run["f_a"].values[run["scored"].values][-500:])
    against = of(found, "LAW-CONTRADICTS")
    assert against.value == pytest.approx(swing_mn, rel=0.35) and against.value > against.limit
    beyond, within = found.tracking.reach.rms_error_beyond_n, found.tracking.reach.rms_error_within_n
    assert math.hypot(beyond, within) == pytest.approx(found.tracking.rms_error_n)
    assert found.rows()[1][0] == "DOES NOT HOLD" and found.would_hold == {} and found.findings[0] is against
    assert json.loads(found.to_json())["holds"] is False


@pytest.mark.parametrize(
    "motion", [{}, {"stroke_mm": 1.3}, {"contact_s": 0.2}, {"speed_mm_s": 200.0}, {"contact_s": 0.15, "lifted_s": 0.3}]
)
def test_a_loop_that_is_stable_does_not_swing_whatever_the_motion(motion):
    assert swing_n(fl.bench().evolve(fl.RETUNED, motion=motion), 0.6) < 2e-3


def test_a_dead_band_is_not_certified_on_short_strokes_either(outside):
    short = {"controller.kind": "dead_band_pi", "controller.kp": 2.0, "controller.ki": 400.0, "motion.stroke_mm": 4.0}
    assert "LAW-CONTRADICTS" in codes(check(outside.evolve(short), ON_DAHL))


@pytest.mark.slow
def test_what_would_hold_of_an_integral_of_ones_own_is_that_of_the_built_in(outside):
    own, built_in = (
        check(outside.evolve({"controller.kind": kind, "controller.ki": 200.0, **kp}))
        for kind, kp in (("integral", {}), ("pi", {"controller.kp": 0.0}))
    )
    assert not own.holds and own.would_hold == {"controller.ki": pytest.approx(built_in.would_hold["controller.ki"])}
    assert own.would_hold["controller.ki"] == pytest.approx(200.0 * min(own.gain_factors), rel=3e-3)
    less = check(own.system.evolve(own.would_hold))
    assert less.holds_everywhere and less.would_hold == {} and "LAW-CONTRADICTS" not in codes(less)


def test_people_unlike_the_finger_of_the_file_are_told_and_no_verdict_contradicts_a_count():
    light = WEAK.evolve({"friction.susceptibility_per_um2": 1.6, "controller.model.susceptibility_per_um2": 1.6})
    people = fl.fingers(6, 0)
    found = check(light.evolve({"controller.ki": 60.0}), ON_DAHL, people)
    values = [each["friction.susceptibility_per_um2"] for each in people]
    unlike = of(found, "PEOPLE-UNLIKE")
    assert (unlike.value, unlike.more["high"]) == (1.6, max(values)) and max(values) < 1.6
    held = int(found.fingers["holds"].sum())
    assert found.holds == (held == 6 and all(place.how == "within" for place in found.places[: found.asked]))
    assert (found.rows()[1][0] == "HOLDS") == found.holds
    assert held < 6 and of(found, "PEOPLE-HOLD").value == held and "PEOPLE-NONE" not in codes(found)
    less = check(found.system.evolve(found.would_hold), ON_DAHL, people)
    assert less.holds and "PEOPLE-HOLD" not in codes(less) and "PEOPLE-UNLIKE" in codes(less)
    assert "PEOPLE-UNLIKE" not in codes(check(WEAK, ON_DAHL, people))


def test_a_finger_that_never_lifts_stands_in_json_fully_moist():
    strong = check(WEAK.evolve({"controller.ki": 40.0}))
    moist = [each for each in json.loads(strong.to_json())["findings"] if each["code"] == "RING-MOIST"]
    (at,) = moist
    there = strong.system.evolve({"finger.slip_length_um": at["where"]["slip_length_um"]})
    peaks = [loop.sensitivity_peak() for loop in fl.operating_band(there, occluded=(1.0,))]
    assert at["value"] == pytest.approx(max(peaks), rel=0.01) and at["value"] > at["limit"]
    assert at["remedy"] == {"motion.contact_s": 10.0}
    lifted = check(strong.system.evolve(at["remedy"]))
    assert "RING-MOIST" not in codes(lifted)


def test_fields_of_a_place_are_those_of_the_loop_there():
    found = check(WEAK)
    at = [(place.slip_length_um, *place.speeds_mm_s) for place in found.places]
    assert at[: found.asked] == [(11.5, 20.0), (0.0, 20.0)]
    assert set(at) == {(length_um, speed) for length_um in (11.5, 0.0) for speed in (10.0, 20.0, 80.0)}
    for place in json.loads(found.to_json())["places"]:
        worst = place["worst"]
        there = {"finger.slip_length_um": place["slip_length_um"], "motion.speed_mm_s": worst["speed_mm_s"]}
        there["sensor.resonance_hz"] = 145.0 * (1 + worst.get("resonance_off", 0.0))
        loop = fl.linearise(WEAK.evolve(there), force_n=worst["force_n"], occluded=worst["occluded"])
        assert worst["sensitivity_peak"] == pytest.approx(loop.margins().sensitivity_peak, rel=1e-5)


def test_friction_without_vibration_beyond_the_range_of_the_sensor_is_told():
    top_n = WEAK.friction.nominal_n * WEAK.friction.occlusion_ratio
    told = list(beyond_range(WEAK.evolve({"sensor.range_n": 0.9 * top_n}), Requirements()))
    assert [(each.value, each.limit) for each in told] == [(pytest.approx(top_n), 0.9 * top_n)]
    assert list(beyond_range(WEAK.evolve({"sensor.range_n": 1.1 * top_n}), Requirements())) == []
    (heavy,) = beyond_range(WEAK.evolve({"sensor.range_n": 1.1 * top_n}), Requirements(loads_n=(0.4, 1.0)))
    assert heavy.where.load_n == 1.0 and heavy.where.occluded == 1.0


def test_what_is_as_the_bench_has_it_is_assumed_unless_it_is_given():
    (told,) = of_assumed(fl.bench(), ())
    assert told.more["values"]["sensor.q"] == fl.bench().sensor.q and told.value == len(told.more["values"])
    (less,) = of_assumed(fl.bench().evolve({"sensor.cutoff_hz": 777.0}), {"sensor.q"})
    assert set(told.more["values"]) - set(less.more["values"]) == {"sensor.cutoff_hz", "sensor.q"}
    lifts = fl.bench().evolve({"motion.contact_s": 1.0})
    assert (
        "motion.lifted_s" in next(of_assumed(lifts, ())).more["values"] and "motion.lifted_s" not in told.more["values"]
    )


@pytest.mark.parametrize(("density", "told"), [(1e-6, 0), (1e-2, 1)])
def test_a_command_that_is_louder_than_a_synthesis_may_make_it_is_told(density, told):
    system = fl.bench().evolve(fl.RETUNED | {"controller.kp": 0.1, "sensor.noise_density_n_rthz": density})
    found = list(noisy(system))
    assert len(found) == told
    assert [each.value for each in found] == [1e3 * fl.command_noise_rms_n(fl.linearise(system))] * told


def test_a_law_that_believes_the_friction_of_another_load_is_told_that_of_this_one():
    heavy = WEAK.evolve({"motion.load_n": 0.8})
    (told,) = unbelieved(heavy)
    there = 0.95 * 1.6**0.9
    assert told.value == pytest.approx(there, rel=1e-3) and told.limit == 0.95
    assert list(unbelieved(heavy.evolve(told.remedy))) == [] == list(unbelieved(WEAK))


def test_a_finger_that_does_not_get_moist_is_told():
    dry = WEAK.evolve({"friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0})
    assert "FINGER-DRY" in codes(check(dry, ON_DAHL))


@pytest.mark.parametrize(("contact_s", "lifted_s"), [(5.0, 0.5), (2.0, 10.0), (30.0, 3.0)])
def test_a_finger_that_lands_again_and_again_is_as_moist_as_contact_after_contact_leaves_it(contact_s, lifted_s):
    bench = fl.bench().evolve({"motion.contact_s": contact_s, "motion.lifted_s": lifted_s, "friction.drying_s": 8.0})
    friction, occluded = bench.friction, 0.0
    for _ in range(2000):
        occluded *= np.exp(-lifted_s / friction.drying_s)  # in the air
        occluded = 1.0 - (1.0 - occluded) * np.exp(-contact_s / friction.occlusion_s)
    assert moistest(friction, bench.motion) == pytest.approx(occluded, rel=1e-9)
    never = -np.expm1(-10.0 / friction.occlusion_s)
    assert moistest(friction, fl.bench().motion) == pytest.approx(never, rel=1e-9), "one that never lifts, after 10 s"


def test_strokes_that_are_contacts_last_longer_where_they_are_slower():
    lifts = fl.bench().evolve({"motion.contact_s": 2.0, "motion.lifted_s": 1.0, "motion.speed_mm_s": 30.0})
    strokes = lifts.evolve(lifts.motion.in_contacts())
    assert one_stroke_a_contact(strokes.motion) and not one_stroke_a_contact(lifts.motion)
    longest = with_longest_contact(strokes, (15.0, 45.0))
    assert longest.motion.contact_s == 4.0 and one_stroke_a_contact(longest.motion)
    assert longest.motion.contact_s * 15.0 == strokes.motion.contact_s * strokes.motion.speed_mm_s
    for other in (lifts, fl.bench(), fl.feasible()):
        assert with_longest_contact(other, (15.0, 45.0)) is other
    assert with_longest_contact(strokes, (30.0, 45.0)) is with_longest_contact(strokes, ()) is strokes


def test_what_was_checked_is_saved_with_what_was_asked_found_and_given(tmp_path):
    must = Requirements(1.6, slip_lengths_um=(11.5,), ends=(("sensor.q", 15.0),))
    found, path = check(WEAK, must), tmp_path / "c.toml"
    write_controller(found, path, {"sensor.q", "motion.load_n"})
    table = read_designed(path)
    assert fl.read_toml(path) == WEAK
    assert (table.requirements, table.given) == (must, {"sensor.q", "motion.load_n"})
    assert changed_since(fl.read_toml(path), table) == ()
    (changed,) = changed_since(WEAK.evolve({"controller.ki": 8.0}), table)
    assert changed.code == "SPEC-CHANGED" and changed.value == {"controller.ki": 7.0}
    assert fl.described(path).stated == table.given
    (again,) = fl.described(path, overrides={"controller.ki": 8.0}).findings
    assert again == changed
    bench = {"controller.rate_hz": 4000.0, "controller.delay_s": 1e-4, "friction.nominal_n": 1.1}
    (moved,) = changed_since(WEAK.evolve(bench), table)
    assert moved.value == {
        name: fl.read_toml(path).model_dump()[name.split(".")[0]][name.split(".")[1]] for name in bench
    }


def test_whom_fingers_are_is_in_the_answer_and_in_the_file(tmp_path):
    people = fl.fingers(2, 3, coefficients=(1.0, 2.0))
    found, path = check(WEAK, ON_DAHL, people), tmp_path / "c.toml"
    drawn = {"n": 2, "seed": 3, "population": None, "loads_n": None, "coefficients": (1.0, 2.0)}
    assert found.drawn == drawn and found.to_dict()["drawn"] == {**drawn, "coefficients": [1.0, 2.0]}
    write_controller(found, path)
    assert tomllib.loads(path.read_text())["designed"]["people"] == {"n": 2, "seed": 3, "coefficients": [1.0, 2.0]}
    low, high = found.looked_at["force_over_load"]
    assert (low, high) == tuple(each / WEAK.motion.load_n for each in found.looked_at["force_n"])


def test_a_loop_that_adds_to_the_error_is_told():
    """Where the table fits and nothing varies but the sensor's noise, feedback can only add to the error."""
    still = {f"motion.{name}": 0.0 for name in ("tremor_um", "tremor_n", "load_drift")}
    still |= {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}
    still |= {"friction.load_exponent": 1.0, "setpoint": fl.Constant(offset_n=0.6), "sensor.noise_density_n_rthz": 2e-4}
    found = check(fl.bench().evolve(fl.RETUNED).evolve(still), ON_DAHL)
    told = of(found, "LOOP-WORSE")
    assert told.value == 1e3 * found.tracking.rms_error_n > 1e3 * found.tracking.open_loop_rms_error_n == told.limit
    assert "LOOP-WORSE" not in codes(check(fl.bench().evolve(fl.RETUNED), ON_DAHL))


@pytest.mark.slow
def test_a_look_at_people_that_is_stopped_keeps_those_who_were_looked_at(monkeypatch):
    from frictionloop.design import population_margins

    seen, of_one = [], population_margins._of

    def look(*given):
        seen.append(given)
        if len(seen) > 3:
            raise KeyboardInterrupt
        return of_one(*given)

    monkeypatch.setattr(population_margins, "_of", look)
    found = check(WEAK, ON_DAHL, fl.fingers(8, 0))
    stopped = of(found, "STOPPED")
    assert (stopped.value, stopped.limit) == (3, 8) and found.fingers.sizes["finger"] == 3
