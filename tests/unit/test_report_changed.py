"""What is told of a changed Fig. 5a besides its numbers."""

from __future__ import annotations

import re

import pytest

import frictionloop as fl
from frictionloop.loop.run_findings import contact_turns
from frictionloop.report import changed_told, protocol
from frictionloop.report.device import CONTROLLERS, IDEAL, OPEN, PRINTED, RETUNED_GAINS
from frictionloop.report.stability import asked_for

ROWS = (OPEN, RETUNED_GAINS)
MIDDLE = protocol.Sines(levels_n=(0.6,), amplitude_n=0.01)
"""What fingers can be given, of which nothing is told."""


def told(changes, base, rows, sines=MIDDLE):
    """Return the lines of a figure whose numbers say nothing, but that on the loop gain, which has its own test."""
    return [line for line in all_told(changes, base, rows, sines) if not line.startswith("loop gain")]


def all_told(changes, base, rows, sines=MIDDLE):
    return changed_told.told(changes, base, {name: {} for name in rows}, {}, sines)


@pytest.fixture(scope="module")
def base():
    return protocol.finger_system(protocol.population()[0]).evolve(
        {"friction.nominal_n": 0.95, "friction.susceptibility_per_um2": 0.38, "motion.load_n": 0.5}
    )


@pytest.mark.parametrize(("slope", "does"), [(-0.12, "falls"), (0.05, "rises")])
def test_a_changed_speed_tells_how_friction_goes_with_speed(base, slope, does):
    sloped = base.evolve({"friction.speed_slope": slope})
    path, line, tremor, pole = told({"motion.speed_mm_s": 40.0}, sloped, ROWS)
    assert path == "strokes stay one long one at a time, on a path of 480 mm"
    assert line == (
        f"this finger's friction {does} with speed, friction.speed_slope = {slope}: the open loop changes with it"
    )
    assert "by way of that slope it shakes the force less" in tremor and "stops" not in tremor
    assert "of the contact at 0.6 N, from 106 Hz to 212 Hz: a higher one" in pole
    line, tremor, _ = told({"motion.speed_mm_s": 10.0}, sloped, ("printed gains",))
    assert "open loop" not in line and "by way of that slope it shakes the force more" in tremor


def test_friction_that_does_not_depend_on_speed_and_a_speed_that_stays_tell_nothing(base):
    calm = base.evolve({"friction.speed_slope": 0.0, "motion.tremor_um": 0.0})
    (pole,) = told({"motion.speed_mm_s": 10.0}, calm, ROWS)
    assert pole.startswith("the change moves the pole of the contact at 0.6 N, from 106 Hz to 53.1 Hz: a lower one")
    assert told({"motion.speed_mm_s": base.motion.speed_mm_s}, base, ROWS) == []
    assert told({"sensor.q": 100.0}, base, ROWS) == []
    pole, line = told({"plate.q": 100.0}, base, ROWS)
    assert pole.startswith(
        "the change moves the pole of the plate, f0/(2 Q) with Q 100, from 100 Hz to 230 Hz: a higher"
    )
    assert line.startswith("plate.max_amplitude_um stays 2.5, as of another drive")


def test_how_often_the_tremor_stops_a_slow_finger_is_as_the_simulation_has_it(base):
    shaken = base.evolve({"friction.speed_slope": 0.0, "motion.tremor_um": 90.0, "motion.stroke_mm": 250.0})
    tremor, *_ = told({"motion.speed_mm_s": 10.0}, shaken, ROWS)
    assert "slope" not in tremor
    rms, share = re.search(r"about ([\d.]+) mm/s rms .* for ([\d.]+)% of the time", tremor).groups()
    run = fl.simulate(shaken.evolve({"motion.speed_mm_s": 10.0}), duration_s=24.0, seed=3)
    speed = 1e3 * run.speed.sel(time=slice(1.0, 23.0)).values
    assert float(rms) == pytest.approx(speed.std(), rel=0.1)
    assert float(share) / 100.0 == pytest.approx((speed < 0.0).mean(), rel=0.25)


@pytest.mark.parametrize(
    ("change", "up"),
    [
        ({"plate.frequency_hz": 25e3}, False),
        ({"plate.q": 100.0}, True),
        ({"motion.speed_mm_s": 60.0}, True),
        ({"finger.slip_length_um": 0.0}, True),
        ({"sensor.resonance_hz": 100.0}, True),
        ({"motion.load_n": 0.3}, False),
    ],
)
def test_what_a_change_does_to_the_sensors_resonance_in_the_loop_is_told(base, change, up):
    def gain(system):
        loop = fl.linearise(system.evolve(CONTROLLERS[RETUNED_GAINS]), force_n=0.4)
        return abs(loop.responses([system.sensor.resonance_hz])["G"][0])

    low = protocol.Sines(levels_n=(0.4,), amplitude_n=0.01)
    lines = all_told(change, base, ROWS, low)
    (line,) = [each for each in lines if each.startswith("loop gain of the re-tuned gains at the sensor's resonance")]
    assert f"at 0.4 N: {gain(base.evolve(change)):.3g} (unchanged {gain(base):.3g})" in line
    assert (gain(base.evolve(change)) > gain(base)) == up
    for pole in (each for each in lines if "moves the pole" in each):
        assert ("less" if up else "more") in pole and ("less" in pole) != ("more" in pole)


def test_a_change_that_the_loop_gain_does_not_feel_tells_nothing_of_it(base):
    assert all_told({"sensor.noise_density_n_rthz": 4.6e-6}, base, ROWS)[1:] == []
    assert not any(line.startswith("loop gain") for line in all_told({"controller.rate_hz": 4e3}, base, ROWS))


HELD = "{:g} ms with half a period of hold, {:g} ms with that of the integral"


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"controller.delay_s": 1e-3}, ["controller.delay_s = 0.001: " + HELD.format(1.1, 1.2)]),
        (
            {"controller.rate_hz": 2e3},
            [
                "controller.delay_s = 0.0002: " + HELD.format(0.45, 0.7),
                "a controller that computes for one period has controller.delay_s = 0.0005 at this rate",
                "at another control rate the same seeds give other strokes, as tremor, drift and roughness are drawn "
                "once a period: spread and error of all controllers change by a few mN by chance",
            ],
        ),
    ],
)
def test_a_changed_delay_or_rate_tells_the_delay_with_hold_and_integral(base, changes, said):
    assert told(changes, base, ROWS) == said
    same = {"controller.delay_s": base.controller.delay_s, "controller.rate_hz": base.controller.rate_hz}
    assert told(same, base, ROWS) == []


def test_forces_that_the_finger_cannot_be_given_are_told_with_both_ends(base):
    (line,) = told({"plate.max_amplitude_um": 0.5}, base, ROWS)
    assert line.startswith("out of this finger's reach at its mean load, whatever the gains: forces below ")
    (line,) = told({}, base, ROWS, protocol.Sines(levels_n=(1.2,), amplitude_n=0.01))
    assert "forces above 0.95 N when it lands (as unchanged), and more where it presses lighter" in line


def test_a_change_that_the_ideal_sensor_takes_away_again_is_named(base):
    changes = {"sensor.resonance_hz": 200.0, "plate.q": 100.0, "controller.delay_s": 9e-4}
    assert told(changes, base, (PRINTED, IDEAL))[3:] == [
        'sensor.resonance_hz and controller.delay_s do not reach "ideal sensor, no delay"'
    ]
    assert told({"controller.delay_s": 9e-4}, base, (PRINTED, IDEAL))[1].startswith("controller.delay_s does not reach")
    assert not any("reach" in line for line in told({"plate.q": 100.0}, base, (PRINTED, IDEAL)))
    assert told({"sensor.q": 5.0}, base, ROWS) == []
    other_kind = {"sensor.kind": "lowpass", "sensor.noise_rms_n": 1e-4}
    assert told(other_kind, base, (PRINTED, IDEAL)) == ['sensor.kind does not reach "ideal sensor, no delay"']


def test_what_the_finger_had_in_place_of_a_change_is_told(base):
    own = base.evolve({"motion.load_n": 0.67})
    assert told({"motion.load_n": 0.8}, own, ROWS) == [
        "this finger's own, which the change replaces: motion.load_n = 0.67 N"
    ]
    assert told({"motion.load_n": 0.8}, own, (*ROWS, "re-tuned here"))[0].endswith(
        "0.67 N (the preset's, for which re-tuned here of the bench unchanged is found: 0.5 N)"
    )


def test_one_sine_that_varies_as_much_as_three_is_not_said_to_vary_less(base):
    wide = protocol.Sines((0.6,), 0.3)
    (line,) = [each for each in told({"setpoint.offset_n": 0.6}, base, ROWS, wide) if "one sine" in each]
    assert "R2 is smaller" not in line
    (line,) = [each for each in told({"setpoint.offset_n": 0.6}, base, ROWS, protocol.Sines((0.6,))) if "sine" in each]
    assert "R2 is smaller, as the set-point varies less" in line


def test_forces_that_come_into_reach_or_stay_out_of_it_are_told_beside_the_bench_unchanged(base):
    low = protocol.Sines(levels_n=(0.5,), amplitude_n=0.1)
    weak = base.evolve({"plate.max_amplitude_um": 1.5})
    (line,) = told({"plate.max_amplitude_um": 3.5}, weak, ROWS, low)
    assert line.startswith("all forces are in this finger's reach at its mean load; unchanged, those below ")
    (line,) = told({"sensor.resonance_hz": 200.0}, weak, ROWS, low)
    assert "at the end of the last stroke, moister than after one (as unchanged), and more" in line
    (line,) = told({"plate.max_amplitude_um": 1.2}, weak, ROWS, low)
    assert "moister than after one (unchanged " in line


@pytest.mark.parametrize("speed", [10.0, 20.0, 30.0, 80.0])
def test_no_stroke_of_a_changed_speed_reaches_the_end_of_its_path(speed):
    """A finger that turned round within a stroke would be scored on what follows the turn."""
    changes = protocol.with_path({"motion.speed_mm_s": speed})
    system = protocol.finger_system(protocol.population()[0]).evolve(changes)
    run = fl.simulate(system, protocol.STROKE_S)
    assert run.scored.values[run.time.values >= protocol.START_S].all()
    if speed <= 20.0:
        assert changes == {"motion.speed_mm_s": speed}


def test_the_bench_of_a_changed_figure_is_run_without_a_question():
    assert [*contact_turns(asked_for({"motion.speed_mm_s": 30.0})), *contact_turns(asked_for({}))] == []
