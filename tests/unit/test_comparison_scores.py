"""The scores of a comparison against traces of single runs, closed forms and NumPy."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.design import comparison as rooms
from frictionloop.design.comparison import law_margins, trial_protocol
from frictionloop.design.comparison.comparison_run import plain_strokes
from frictionloop.design.comparison.comparison_scores import (
    answering,
    dead_times_s,
    pooled,
    pooled_rms,
    spread,
)
from frictionloop.loop.companion_runs import plain_stroke
from frictionloop.physics.fingers import Fingers

DURATION_S, START_S, SEED = 2.0, 0.5, 9


@pytest.fixture(scope="module")
def ran():
    times = {"duration_s": DURATION_S, "start_s": START_S, "progress": False}
    return rooms.run_laws(fl.bench(), ["retuned_pi"], 3, SEED, [80.0], **times)


@pytest.fixture(scope="module")
def scored(ran):
    return rooms.scores(ran).sel(law="retuned_pi", speed_mm_s=80.0, slip_length_um=11.5)


def traces(ran, task, finger):
    at = trial_protocol.Condition(80.0, 11.5, task)
    system = fl.bench().evolve(
        {**trial_protocol.overrides_of(at, DURATION_S), **ran.laws["retuned_pi"], **ran.people[finger]}
    )
    whole = fl.simulate(system, DURATION_S, trial_protocol.noise_seed(SEED, task))
    keep = whole["scored"].values & (whole["time"].values > START_S - 1e-9)
    return whole, keep


def together(ran, tasks, finger, name):
    return np.concatenate([whole[name].values[keep] for whole, keep in (traces(ran, task, finger) for task in tasks)])


@pytest.mark.slow
@pytest.mark.parametrize("finger", range(3))
def test_fits_are_those_of_the_traces_put_together(ran, scored, finger):
    r, f = (together(ran, trial_protocol.SINES, finger, name) for name in ("f_r", "f_a"))
    got = scored.isel(finger=finger)
    assert float(got.r2_identity) == pytest.approx(1 - np.sum((f - r) ** 2) / np.sum((r - r.mean()) ** 2), rel=1e-9)
    assert float(got.r2_regression) == pytest.approx(np.corrcoef(r, f)[0, 1] ** 2, rel=1e-9)
    assert float(got.residual_rms_n) == pytest.approx(np.sqrt(np.mean((f - r) ** 2)), rel=1e-9)
    clamped = together(ran, trial_protocol.SINES, finger, "saturated")
    assert float(got.saturation_index) == pytest.approx(clamped.mean(), abs=1e-12)
    r, f = (together(ran, trial_protocol.HOLDS, finger, name) for name in ("f_r", "f_a"))
    assert float(got.hold_rms_n) == pytest.approx(np.sqrt(np.mean((f - r) ** 2)), rel=1e-9)
    levels = [fl.r2_identity(*traces(ran, task, finger)) for task in trial_protocol.SINES]
    assert float(got.worst_level_r2_identity) == pytest.approx(min(levels), rel=1e-9)
    each = [float(got[f"r2_identity_{level:g}_n"]) for level in trial_protocol.LEVELS_N]
    assert each == pytest.approx(levels, rel=1e-9)
    whole, keep = traces(ran, "landings", finger)
    assert float(got.landing_rms_n) == pytest.approx(fl.rms_error(whole, keep), rel=1e-9)
    assert 0 < keep.sum() < 1.0 * (DURATION_S - START_S) * 5000  # in the air nothing counts


@pytest.mark.slow
@pytest.mark.parametrize("finger", range(3))
def test_step_times_are_means_of_the_steps(ran, scored, finger):
    whole, _ = traces(ran, "steps", finger)
    found = [each for each in fl.step_times(whole) if each.start_s > START_S - 1e-9]
    for name, rises, field in (
        ("rise_63_s", True, "to_63_s"),
        ("rise_10_90_s", True, "rise_s"),
        ("fall_63_s", False, "to_63_s"),
        ("fall_10_90_s", False, "rise_s"),
    ):
        times = [getattr(each, field) for each in found if (each.to_n > each.from_n) == rises]
        wanted = np.mean(times) if times else math.nan
        assert float(scored[name].isel(finger=finger)) == pytest.approx(wanted, rel=1e-9, nan_ok=True)


def test_times_within_the_delay_of_the_loop_are_none():
    """Two laws, of 200 and 0 us; fingers that answer in time, at once, as the delay ends, and never."""
    early = np.array([[3e-4, 1e-4, 2e-4, np.nan], [3e-4, 1e-4, 2e-4, np.nan]])
    late, span = np.full((2, 4), 5e-3), np.full((2, 4), 1e-4)
    times = {"rise_63_s": late, "rise_10_90_s": span, "fall_63_s": early, "fall_10_90_s": span}
    found = answering(times, np.array([2e-4, 0.0]))
    np.testing.assert_array_equal(found["fall_63_s"], [[3e-4, np.nan, np.nan, np.nan], early[1]])
    np.testing.assert_array_equal(found["fall_10_90_s"], [[1e-4, np.nan, np.nan, 1e-4], span[1]])
    np.testing.assert_array_equal(found["rise_63_s"], late)
    np.testing.assert_array_equal(found["rise_10_90_s"], span)  # short, but it begins at 10 %, not at the step


def test_every_law_waits_for_its_delay(ran):
    laws = {"printed_pi": rooms.ENTRANTS["printed_pi"](fl.bench()), "slow": {"controller.delay_s": 5e-4}}
    assert dead_times_s(replace(ran, laws=laws)).tolist() == [2e-4, 5e-4]


def test_a_force_that_rings_across_has_no_time_in_the_scores(ran):
    """The same cells, once as they are and once with a finger that falls by 63 % in 0.14 ms."""
    at = {"law": "retuned_pi", "slip_length_um": 11.5, "task": trial_protocol.STEPPED, "finger": 1}
    cells = ran.cells.copy(deep=True)
    for name in ("fall_63_s", "rise_63_s"):
        cells[name].loc[at] = 1.4e-4 if name.startswith("fall") else 1.5e-2
    own = {name: value for name, value in at.items() if name != "task"}
    found = rooms.scores(replace(ran, cells=cells)).sel(own)
    for name in ("fall_63_s", "fall_10_90_s"):
        assert np.isnan(found[name]).all()
    assert float(found["rise_63_s"].item()) == 1.5e-2


@pytest.mark.parametrize("level_n", [0.4, 0.6])
def test_plain_strokes_have_the_level_and_the_index_of_a_constant_amplitude(level_n):
    able = trial_protocol.able(fl.bench(), fl.fingers(30, 4), 20.0)
    people = Fingers(each for each, is_able in zip(fl.fingers(30, 4), able, strict=True) if is_able)
    people = Fingers(people[:3])
    at, calls = trial_protocol.Condition(20.0, 11.5, "sine 0.6"), []
    system = fl.bench().evolve(trial_protocol.overrides_of(at))

    def swept(bench, some, metrics):
        calls.append(some)
        return fl.sweep(bench, some, 1.0, [7], metrics, progress=False).isel(seed=0, drop=True)

    found = plain_strokes(system, people, level_n, 0.0, swept)
    assert len(calls) == 3
    np.testing.assert_allclose(found["mean_force"], level_n, atol=1e-3)
    for i, each in enumerate(calls[-1]):
        amplitude_um = math.sqrt(math.log(0.95 / each["setpoint.offset_n"]) / 0.38)
        stroke = plain_stroke(system.evolve(people[i]), amplitude_um, 1.0, 7)
        force = stroke["f_a"].values
        mean = float(force[stroke["scored"].values].mean())
        index = fl.perceptual_index(stroke.assign(f_r=("time", np.full(force.size, mean))))
        assert float(found["mean_force"][i]) == pytest.approx(mean, abs=1e-4)  # the loop takes 200 us to begin
        assert float(found["perceptual_index"][i]) == pytest.approx(index, rel=0.01)


@given(
    st.lists(
        st.lists(st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 2.0)), min_size=2, max_size=8), min_size=1, max_size=4
    )
)
def test_pooling_moments_is_pooling_samples(runs):
    parts = [np.array(each).T + np.array([[i], [0.1 * i]]) for i, each in enumerate(runs)]
    parts = [part + np.linspace(0.0, 0.5, part.shape[1]) for part in parts]
    if any(np.var(part[0]) < 1e-6 or np.var(part[1]) < 1e-6 for part in parts):
        return
    r, f = np.concatenate(parts, axis=1)
    columns = [
        (x.size, np.sqrt(np.mean((y - x) ** 2)), x.mean(), y.mean(), x.std(), y.std(), np.polyfit(x, y, 1)[0])
        for x, y in parts
    ]
    found = pooled(*np.array(columns).T)
    assert found.rms_error == pytest.approx(np.sqrt(np.mean((f - r) ** 2)), rel=1e-9)
    assert found.r2_identity == pytest.approx(
        1 - np.sum((f - r) ** 2) / np.sum((r - r.mean()) ** 2), rel=1e-6, abs=1e-9
    )
    assert found.r2_regression == pytest.approx(np.corrcoef(r, f)[0, 1] ** 2, rel=1e-6, abs=1e-9)
    assert pooled_rms(np.array([1.0, 3.0]), np.array([2.0, 0.0])) == pytest.approx(1.0)


def test_median_and_worst_decile():
    values = np.arange(20.0)
    assert spread(values, False) == (9.5, 17.0)  # 18 of 20 are at most 17
    assert spread(values, True) == (9.5, 2.0)  # 18 of 20 are at least 2
    values[:3] = np.nan  # a step that was never followed is the worst there is
    assert spread(values, False) == (12.5, math.inf)
    assert spread(np.array([1.0, np.nan, np.nan]), False) == (math.inf, math.inf)
    assert all(map(math.isnan, spread(np.full(4, np.nan), False)))


@pytest.mark.slow
def test_margins_are_those_of_linearise_on_the_median_finger():
    times = {"duration_s": 0.6, "start_s": 0.1, "progress": False}
    ran = rooms.run_laws(fl.bench(), ["retuned_pi"], 8, 0, [20.0], **times)
    some = trial_protocol.able(fl.bench(), ran.people, 20.0, 0.6)
    finger = trial_protocol.median_finger(ran.people, some)
    assert finger is not None
    own = {path: value for path, value in finger.items() if path != "sensor.resonance_hz"}
    occluded = -math.expm1(-0.35 / finger["friction.occlusion_s"])

    def peak(factor, level):
        system = fl.bench().evolve({**own, **fl.RETUNED, "sensor.resonance_hz": 145.0 * factor})
        return fl.linearise(system, force_n=level, occluded=occluded).margins().sensitivity_peak

    found = law_margins.robustness(ran, "retuned_pi", 20.0, 11.5)
    assert found.sensitivity_peak == pytest.approx(max(peak(1.0, level) for level in (0.4, 0.6, 0.8)))
    wider = max(peak(factor, level) for factor in (0.95, 1.0, 1.05) for level in (0.4, 0.6, 0.8))
    assert found.sensitivity_peak_5 == pytest.approx(wider)
    assert found.sensitivity_peak <= found.sensitivity_peak_5 <= found.sensitivity_peak_10
    row = next(row for row in rooms.margin_rows(ran) if row["slip_length_um"] == 11.5)
    assert (row["law"], row["speed_mm_s"], row["stable"]) == ("retuned_pi", 20.0, found.stable)
