"""f0, tau, the law and the table of a finger from recordings with amplitude commands."""

from __future__ import annotations

import numpy as np
import pytest
import vibrated_finger as known
from finger_strokes import strokes

import frictionloop as fl
from frictionloop.identification import amplitude_protocol, friction, monotone_table, susceptibility, susceptibility_fit
from frictionloop.identification.susceptibility_fit import PRIORS


def inside(estimate, truth, method=0.0):
    """Tell whether a value is in its interval of 99.9 %, so that one in eighty sets of a dozen fails."""
    low, high = estimate._replace(standard_error=np.hypot(estimate.standard_error, method)).interval(0.999)
    return low < truth < high


@pytest.fixture(scope="module")
def one():
    return susceptibility(known.finger())


def test_a_finger_known_by_its_equation(one):
    assert inside(one.nominal, 1.1, one.method_n) and one.nominal.standard_error < 0.05
    assert inside(one.susceptibility, 0.45, one.method_per_um2) and one.susceptibility.standard_error < 0.02
    assert inside(one.load_exponent, 0.9) and inside(one.occlusion_ratio, 1.8) and inside(one.moist_loss, 0.0)


def test_linear_regression_agrees_where_moisture_is_known(one):
    """Another implementation: log f over 1, log N, log of the known moisture and a^2, by numpy alone."""
    from frictionloop.identification.susceptibility_fit import sliding_pieces

    pieces = sliding_pieces(known.finger(), 0.1)
    wet = np.log1p(0.8 * -np.expm1(-pieces.contact_s / 20))
    square = np.mean(pieces.amplitude_um**2, axis=1)
    columns = np.stack([np.ones_like(wet), pieces.log_load - np.log(0.5), -square], axis=1)
    f0, _, tau = np.linalg.lstsq(columns, pieces.log_friction - wet, rcond=None)[0]
    assert np.exp(f0) == pytest.approx(one.nominal.value, rel=0.05)
    assert tau == pytest.approx(one.susceptibility.value, rel=0.05)


@pytest.mark.parametrize("name", ["gaussian", "exponential", "threshold"])
def test_the_data_say_which_law(name):
    found = susceptibility(known.finger(getattr(known, f"share_{name}"), seed=3))
    assert found.law == found.laws[0].name == name
    if name == "exponential":
        assert inside(found.susceptibility, 0.8**2, found.method_per_um2) and inside(found.nominal, 1.1, found.method_n)


def test_a_small_amplitude_does_not_tell_the_law():
    found = susceptibility(known.finger(largest=0.45, duration_s=30.0, scatter=0.05))
    assert found.law == "cannot be told"
    assert [each.code for each in found.findings] == ["NOT-TOLD"]


def test_the_table_is_the_law_that_made_the_data():
    found = susceptibility(known.finger(known.share_threshold, seed=3))
    table = monotone_table(found)
    assert np.all(np.diff(table.square_um2) < 0) and table.square_um2[-1] == 0
    amplitude = np.sqrt(table.square_um2)
    share = table.force_n / table.force_n[-1]
    np.testing.assert_allclose(share, known.share_threshold(amplitude), rtol=0.06)
    assert table.gaussian_n > 0.05
    true = monotone_table(susceptibility(known.finger()))
    assert true.gaussian_n < 0.05


@pytest.mark.parametrize("form", ["steps", "sweep", "noise"])
def test_the_simulated_bench(form):
    system = fl.bench().evolve({"controller.kind": "lookup", "setpoint": amplitude_protocol(fl.bench(), form, 30.0)})
    found = susceptibility(fl.simulate(system, 30.0, seed=1))
    assert found.law == "gaussian"
    assert inside(found.susceptibility, 0.38, found.method_per_um2)
    assert inside(found.nominal, 0.95, found.method_n)
    assert inside(found.load_exponent, 0.9) and inside(found.moist_loss, 0.3)


@pytest.mark.slow
def test_a_device_that_plays_the_sweep():
    system = fl.bench().evolve({"friction.nominal_n": 0.8, "friction.susceptibility_per_um2": 0.5})
    with fl.connect("sim:", system) as device:
        device.upload(fl.bench())  # which believes 0.95 N and 0.38
        run = device.run(amplitude_protocol(fl.bench(), "sweep"), 20.0, state="open")
    found = susceptibility(run, plate_hz=100.0)
    assert found.law == "gaussian"
    assert inside(found.susceptibility, 0.5, found.method_per_um2) and inside(found.nominal, 0.8, found.method_n)


@pytest.mark.slow
def test_a_controller_with_the_table_of_another_law():
    """On a rough contact the measured table commands the force that is asked for, and the Gaussian's does not."""
    rough = {"friction.kind": "rough_contact", "friction.occlusion_ratio": 1.0, "friction.moist_loss": 0.0}
    even = {"friction.roughness_rms": 0.01, "motion.load_drift": 0.0, "motion.tremor_n": 0.0}
    bench = fl.bench().evolve(rough | even)
    played = bench.evolve({"controller.kind": "lookup", "setpoint": amplitude_protocol(bench, "sweep", 30.0)})
    table = monotone_table(susceptibility(fl.simulate(played, 30.0)))
    asked = bench.evolve({"controller.kind": "lookup", "setpoint.offset_n": 0.5, "setpoint.amplitude_n": 0.3})
    plain = {"controller.model.nominal_n": float(table.force_n[-1])}
    errors = [fl.rms_error(fl.simulate(asked.evolve(each), 10.0)) for each in (plain, table.overrides())]
    assert errors[1] < 0.5 * errors[0]


@pytest.mark.slow
def test_coverage_of_the_intervals():
    """Intervals of 90 % hold the truth for 54 of 60 fingers; fewer than 46 come by chance once in a thousand."""
    hits = np.zeros(3)
    for seed in range(60):
        found = susceptibility(known.finger(duration_s=40.0, seed=seed))
        for k, (estimate, truth, method) in enumerate(
            (
                (found.nominal, 1.1, found.method_n),
                (found.susceptibility, 0.45, found.method_per_um2),
                (found.load_exponent, 0.9, 0.0),
            )
        ):
            error = np.hypot(estimate.standard_error, method)
            low, high = estimate._replace(standard_error=error).interval(0.9)
            hits[k] += low < truth < high
        assert found.law == "gaussian"
    assert np.all(hits >= 46), hits


@pytest.mark.slow
def test_what_the_assumed_numbers_change(monkeypatch):
    """Priors twice as wide, and twice as much left out after turns and jumps, move values less than their errors."""
    run = known.finger(seed=1, duration_s=30.0)
    plain = susceptibility(run)

    def moved():
        found = susceptibility(run)
        pairs = [(getattr(found, name), getattr(plain, name)) for name in ("nominal", "susceptibility")]
        return max(abs(new.value - old.value) / old.standard_error for new, old in pairs)

    for name, (middle, width) in PRIORS.items():
        monkeypatch.setitem(PRIORS, name, (middle, 2 * width))
        assert moved() < 0.2, name
        monkeypatch.setitem(PRIORS, name, (middle, width))
    for name in ("TURN_S", "SETTLE_S"):
        with monkeypatch.context() as patch:
            patch.setattr(susceptibility_fit, name, 2 * getattr(susceptibility_fit, name))
            assert moved() < 1.0, name


def test_slides_are_found_with_their_friction():
    found = friction(strokes(share=0.01))
    assert len(found.slides) == 6
    assert [np.sign(slide.speed_m_s) for slide in found.slides] == [1, -1] * 3
    for slide in found.slides:
        assert abs(slide.speed_m_s) == pytest.approx(0.04, rel=0.02)
        assert slide.friction_n == pytest.approx(0.3 * (slide.load_n / 0.5) ** 0.8, rel=0.03)
    assert found.exponent.value == pytest.approx(0.8, abs=0.1)
    assert found.level_n(0.5) == pytest.approx(0.3, rel=0.02)


def test_the_sign_of_the_sensor_does_not_matter():
    one, other = friction(strokes(drift=0.0)), friction(strokes(drift=0.0, sign=-1.0))
    assert other.mu.value == pytest.approx(one.mu.value, rel=1e-3)


def test_a_simulated_bench():
    """The finger of the bench slides on a plate that is still: friction over load is that of its law."""
    flat = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.load_exponent": 1.0}
    run = fl.plain_stroke(fl.bench().evolve(flat), 0.0, duration_s=6.0)
    # What the finger feels, without the sensor in between.
    found = friction(run[["position", "load"]].assign(f_m=run.f_a))
    assert len(found.slides) >= 2 and [each.code for each in found.findings if each.code == "NOT-TOLD"]
    assert found.mu.value == pytest.approx(0.95 / 0.5, rel=0.02)
    assert found.level_n(0.5) == pytest.approx(0.95, rel=0.05)
    assert all(abs(slide.speed_m_s) == pytest.approx(0.02, rel=0.1) for slide in found.slides)
