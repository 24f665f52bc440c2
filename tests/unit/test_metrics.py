"""How good a run is: against closed forms, against textbook tools, and the same from traces and from sums."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.signal import lfilter, sosfilt
from scipy.stats import linregress

import frictionloop as fl
from frictionloop.loop.band_residuals import by_band, split_edges
from frictionloop.loop.companion_runs import TURNS
from frictionloop.perception.weighting import weighting_sos

RUN = fl.simulate(fl.paper().evolve({"setpoint.sweep_s": 1.0, "disturbance.frequency_hz": 3.0}), 1.0)


def made(f_r, f_a, saturated=None, d=0.0):
    """Return a Dataset that looks like a run of the paper's system."""
    f_r = np.asarray(f_r, dtype=float)
    rows = {
        "f_r": f_r,
        "f_a": np.broadcast_to(f_a, f_r.shape).astype(float),
        "saturated": np.broadcast_to(False if saturated is None else saturated, f_r.shape),
        "d": np.broadcast_to(d, f_r.shape).astype(float),
    }
    return xr.Dataset({name: ("time", row) for name, row in rows.items()}, attrs=RUN.attrs)


TURN = np.linspace(0, 2 * np.pi, 1001)[:-1]  # one period: means of sin and sin^2 are exactly 0 and 1/2
SINE = 0.5 + 0.2 * np.sin(TURN)


def test_a_perfect_fit():
    run = made(SINE, SINE)
    assert fl.r2_identity(run) == 1.0
    assert fl.rms_error(run) == 0.0
    line = fl.regression(run)
    assert line == pytest.approx((1.0, 1.0, 0.0), abs=1e-13)


def test_an_offset():
    """f_a = f_r + b: R2_identity = 1 - b^2 / (A^2/2), the regression does not see it."""
    run = made(SINE, SINE + 0.1)
    assert fl.r2_identity(run) == pytest.approx(1 - 0.1**2 / (0.2**2 / 2), abs=1e-12)
    assert fl.rms_error(run) == pytest.approx(0.1, rel=1e-12)
    assert fl.regression(run) == pytest.approx((1.0, 1.0, 0.1), abs=1e-12)
    assert fl.r2_regression(run) == fl.regression(run).r2


def test_a_gain():
    """f_a = mean + k (f_r - mean): R2_identity = 1 - (1 - k)^2, slope k."""
    run = made(SINE, 0.5 + 0.3 * (SINE - 0.5))
    assert fl.r2_identity(run) == pytest.approx(1 - 0.7**2, abs=1e-12)
    assert fl.regression(run) == pytest.approx((1.0, 0.3, 0.5 * 0.7), abs=1e-12)


def test_a_phase():
    """A lag of phi: R2_identity = 1 - 2 (1 - cos phi), squared correlation cos^2 phi."""
    run = made(SINE, 0.5 + 0.2 * np.sin(TURN - 0.3))
    assert fl.r2_identity(run) == pytest.approx(1 - 2 * (1 - math.cos(0.3)), abs=1e-12)
    assert fl.r2_regression(run) == pytest.approx(math.cos(0.3) ** 2, abs=1e-12)


def test_no_relation():
    run = made(SINE, 0.5 + 0.2 * np.cos(TURN))
    assert fl.r2_identity(run) == pytest.approx(-1.0, abs=1e-12)
    assert fl.r2_regression(run) == pytest.approx(0.0, abs=1e-12)


def test_the_regression_is_the_textbooks():
    line = fl.regression(RUN)
    textbook = linregress(RUN["f_r"].values, RUN["f_a"].values)
    assert line == pytest.approx((textbook.rvalue**2, textbook.slope, textbook.intercept), rel=1e-10)


def test_output_noise_is_a_standard_deviation():
    assert fl.output_noise(RUN) == pytest.approx(RUN["f_a"].values.std(), rel=1e-12)
    assert fl.output_noise(made(SINE, 0.4)) == pytest.approx(0.0, abs=1e-8)  # root of 0.1^2 rounded


def test_saturation_index_is_a_share():
    saturated = np.arange(1000) % 4 == 0
    assert fl.saturation_index(made(SINE, SINE, saturated)) == 0.25
    assert fl.saturation_index(made(SINE, SINE, saturated), mask=np.arange(1000) < 4) == 0.25
    assert fl.saturation_index(made(SINE, SINE)) == 0.0
    assert fl.saturation_index(RUN) == pytest.approx(RUN["saturated"].values.mean(), rel=1e-15)


def test_the_bound_is_the_set_point_clipped():
    """d = 0: the band is [g(2.5 um), 0.8] N, so a square wave between -1 and 0.5 N keeps an error of 1 + g."""
    floor = 0.8 * math.exp(-0.38 * 6.25)
    square = np.where(np.arange(1000) < 500, -1.0, 0.5)
    shortfall, spread = 500 * (floor + 1.0) ** 2, 1000 * 0.75**2
    assert fl.r2_bound(made(square, square)) == pytest.approx(1 - shortfall / spread, rel=1e-12)
    # With d = 1.2 even 0.5 N is below the band, which begins at g + 1.2.
    both = 500 * (floor + 2.2) ** 2 + 500 * (floor + 0.7) ** 2
    assert fl.r2_bound(made(square, square, d=1.2)) == pytest.approx(1 - both / spread, rel=1e-12)
    assert fl.r2_bound(made(SINE, SINE)) == 1.0


@pytest.mark.parametrize("metric", [fl.r2_identity, fl.r2_regression, fl.r2_bound])
def test_a_constant_set_point_has_no_goodness_of_fit(metric):
    assert math.isnan(metric(made(np.full(100, 0.3), SINE[:100])))


METRICS = [
    fl.r2_identity, fl.r2_regression, fl.rms_error, fl.saturation_index, fl.output_noise, fl.r2_bound,
]  # fmt: skip


@pytest.mark.parametrize("metric", METRICS, ids=lambda metric: metric.__name__)
def test_a_mask_scores_a_part(metric):
    mask = RUN["time"].values >= 0.4
    assert metric(RUN, mask) == pytest.approx(metric(RUN.isel(time=slice(2000, None))), rel=1e-12)
    assert metric(RUN, mask) != metric(RUN)
    assert metric(RUN, np.ones(5000, dtype=bool)) == metric(RUN)
    assert metric(RUN, xr.DataArray(mask, dims="time")) == metric(RUN, mask)


forces = st.lists(st.floats(-2, 2), min_size=3, max_size=30)


@given(st.data(), forces)
def test_the_regression_never_fits_worse_than_the_identity(data, f_r):
    f_a = data.draw(st.lists(st.floats(-2, 2), min_size=len(f_r), max_size=len(f_r)))
    identity, line = fl.r2_identity(made(f_r, f_a)), fl.r2_regression(made(f_r, f_a))
    if not (math.isnan(identity) or math.isnan(line)):
        # 1 - R2 are ratios of sums; where the spread is tiny their rounding is large.
        spread = np.var(f_r) * np.var(f_a) / 16
        assert line >= identity - 1e-13 / max(spread, 1e-13)
        assert line <= 1 + 1e-13 / max(spread, 1e-13)


@settings(max_examples=60)
@given(
    kp=st.floats(0, 100),
    ki=st.floats(0, 1e4),
    offset_n=st.floats(-0.5, 1.5),
    disturbance_n=st.floats(-0.5, 0.5),
    delay_s=st.sampled_from([0.0, 200e-6, 1e-3]),
)
def test_no_controller_beats_the_bound(kp, ki, offset_n, disturbance_n, delay_s):
    system = fl.paper().evolve(
        {
            "setpoint": fl.Sine(offset_n=offset_n, amplitude_n=0.3, frequency_hz=20.0),
            "disturbance": fl.Sine(offset_n=disturbance_n, amplitude_n=0.1, frequency_hz=7.0),
            "controller.kp": kp,
            "controller.ki": ki,
            "controller.delay_s": delay_s,
        }
    )
    run = fl.simulate(system, 0.1)
    assert fl.r2_identity(run) <= fl.r2_bound(run) + 1e-12


def index_of(run, score_from_s):
    """D of the periods from ``score_from_s`` on, the filter having run since t = 0 (faded in by two low-passes)."""
    gain = -math.expm1(-1 / (0.01 * 5000))
    fade = lfilter([gain], [1, gain - 1], lfilter([gain], [1, gain - 1], np.ones(run["time"].size)))
    felt = sosfilt(weighting_sos(5000.0), (run["f_a"] - run["f_r"]).values * fade)
    return float(np.sqrt(np.mean(felt[round(score_from_s * 5000) :] ** 2)))


def mean_step_times(run, score_from_s):
    """Means over the steps whose 90 % was reached in the scored part."""
    steps = fl.step_times(run)
    found = {}
    for name, sign in (("rise", 1), ("fall", -1)):
        f_a, time = run["f_a"].values, run["time"].values
        kept = []
        for step in steps:
            after = (time >= step.start_s - 1e-9) & ((f_a - step.from_n) / (step.to_n - step.from_n) >= 0.9)
            arrived_s = time[after][0]
            if sign * (step.to_n - step.from_n) > 0 and arrived_s >= score_from_s - 1e-9:
                kept.append(step)
        found[f"{name}_63_s"] = np.mean([step.to_63_s for step in kept]) if kept else math.nan
        found[f"{name}_10_90_s"] = np.mean([step.rise_s for step in kept]) if kept else math.nan
    return found


VARIETY = {
    "the paper": {},
    "kp 40": {"controller.kp": 40.0},
    "a level far from the offset": {"setpoint": fl.Steps(times_s=(0.0, 0.3), levels_n=(0.3, 0.7))},
    "noise": {"setpoint": fl.ColouredNoise(offset_n=0.6, rms_n=0.2), "sensor.noise_rms_n": 0.01},
    "constant": {"setpoint": fl.Constant(offset_n=0.3)},
    "steps up and down": {
        "setpoint": fl.Steps(times_s=(0.0, 0.2, 0.4, 0.6, 0.7), levels_n=(0.5, 0.7, 0.55, 0.65, 0.5)),
        "disturbance": fl.Constant(offset_n=0.1),
        "controller.ki": 1000.0,
        "controller.kp": 1.5,
    },
    "steps of one level": {"setpoint": fl.Steps(times_s=(0.0,), levels_n=(0.3,))},
    "unreachable": {"setpoint.offset_n": 5.0},
}


@pytest.mark.parametrize("score_from_s", [0.0, 0.35])
@pytest.mark.parametrize("name", VARIETY)
def test_sums_and_traces_give_the_same_numbers(name, score_from_s):
    system = fl.paper().evolve({"setpoint.sweep_s": 1.0, "disturbance.frequency_hz": 3.0}).evolve(VARIETY[name])
    run = fl.simulate(system, 0.8, seed=5)
    mask = run["time"].values >= score_from_s - 1e-9
    lines = fl.regression(run, mask)
    traces = {metric.__name__: metric(run, mask) for metric in METRICS} | {"slope": lines.slope}
    traces["perceptual_index"] = index_of(run, score_from_s)
    f_r, f_a = run["f_r"].values[mask], run["f_a"].values[mask]
    traces |= {"mean_force": f_a.mean(), "mean_setpoint": f_r.mean(), "setpoint_spread": f_r.std()}
    traces["scored_periods"] = f_r.size
    traces |= {name: fl.metrics(run, mask)[name] for name in ("disturbance_left", *TURNS)}
    if system.setpoint.kind == "steps":
        traces |= mean_step_times(run, score_from_s)
        assert set(traces) == set(fl.METRICS)
    sums = fl.sweep(system, [{}], 0.8, seeds=[5], metrics=list(traces), score_from_s=score_from_s)
    if score_from_s == 0:
        assert traces["perceptual_index"] == pytest.approx(fl.perceptual_index(run), rel=1e-11)
    # N = 4000 sums of squares near 1 N^2, each rounded at the size of the sum: N^2 2^-53 / 2 at worst, sqrt(N) of
    # that usually, over the spread of f_r: 1e-9 leaves both. Standard deviations are roots of such differences.
    # The recursive filter of the index adds its own rounding, 1e-9 of the largest residual over its threshold (1e3).
    absolute = {"output_noise": 1e-7, "setpoint_spread": 1e-7, "perceptual_index": 1e-6}
    for metric, value in traces.items():
        got = float(sums[metric].values.squeeze())
        assert got == pytest.approx(value, rel=1e-9, abs=absolute.get(metric, 1e-9), nan_ok=True), metric
    if "constant" in name or "one level" in name:
        assert math.isnan(traces["r2_identity"])


def test_of_a_small_sine_the_loop_leaves_the_gain_of_its_sensitivity():
    # Closed form: |S| at 3 Hz by the linear analysis, which shares no code with the metric.
    small = fl.Sine(offset_n=0.1, amplitude_n=0.002, frequency_hz=3.0)
    quiet = fl.feasible().evolve({"disturbance": small, "sensor.noise_rms_n": 0})
    system = quiet.evolve({"setpoint": fl.Constant(offset_n=0.5)})
    run = fl.simulate(system, 3.0)
    left = fl.metrics(run, run.time.values >= 1.0)["disturbance_left"]
    swept = fl.sweep(system, {"controller.kp": [10.0]}, 3.0, metrics=["disturbance_left"], score_from_s=1.0)
    assert swept.disturbance_left.item() == left
    sensitivity = fl.linearise(system).frequency_response([3.0])["f_a_from_d"].values.item()
    assert left == pytest.approx(abs(sensitivity), rel=0.03)
    opened = fl.simulate(system.evolve({"controller.kind": "lookup"}), 3.0)
    assert fl.metrics(opened)["disturbance_left"] == pytest.approx(1.0, abs=1e-6)
    assert np.isnan(fl.metrics(run.assign_attrs(source="device"))["disturbance_left"])
    steady = fl.simulate(system.evolve({"disturbance": fl.Constant(offset_n=0.1)}), 0.5)
    assert np.isnan(fl.metrics(steady)["disturbance_left"])


def test_errors_that_are_there_without_the_disturbance_do_not_count_and_ringing_does():
    bench = fl.bench().evolve({"disturbance": fl.Sine(amplitude_n=0.02, frequency_hz=2.0)})
    opened = fl.simulate(bench.evolve({"controller.kind": "lookup"}), 2.0)
    assert fl.rms_error(opened) > 0.04
    assert fl.metrics(opened)["disturbance_left"] == pytest.approx(1.0, abs=0.1)
    assert fl.metrics(fl.simulate(bench, 2.0))["disturbance_left"] > 2.0  # the paper's gains ring on the bench


RATE_HZ = 5000.0
TIME_S = np.arange(15000) / RATE_HZ
LEVEL = {"setpoint": fl.Constant(offset_n=0.5)}


def tones(*tones_hz, size_n=2e-3):
    values_n = size_n * sum((np.sin(2 * np.pi * each * TIME_S) for each in tones_hz), start=0 * TIME_S)
    return fl.Samples(values_n=values_n, rate_hz=RATE_HZ)


def disturbed(*tones_hz, duration_s=1.0, **changes):
    return fl.simulate(fl.feasible().evolve(LEVEL | {"disturbance": tones(*tones_hz)} | changes), duration_s)


@pytest.mark.parametrize("split_hz", [(8, 4), (0,), (-1,), (8, 8), (2500,), (math.nan,)])
def test_frequencies_that_do_not_rise_within_the_loops_are_refused(split_hz):
    with pytest.raises(fl.FrictionloopError, match="split_hz"):
        split_edges(split_hz, RATE_HZ)
    assert split_edges((), RATE_HZ) == []
    assert split_edges((8, 20), RATE_HZ) == [0.0, 8.0, 20.0, math.inf]


def test_the_bands_add_up_to_the_whole():
    run = disturbed(20.0, 1000.0)
    everything = np.ones(run.sizes["time"], bool)
    bands = by_band(run, everything, split_edges((300,), RATE_HZ))
    squares = sum(each.left_n**2 for each in bands) / sum(each.disturbance_n**2 for each in bands)
    assert squares == pytest.approx(fl.metrics(run)["disturbance_left"] ** 2, rel=1e-2)
    assert bands[0].disturbance_left == pytest.approx(bands[0].left_n / bands[0].disturbance_n)
    calm = fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant()}), 1.0)
    assert all(math.isnan(each.disturbance_left) for each in by_band(calm, everything, split_edges((8,), RATE_HZ)))
    assert by_band(calm, ~everything, split_edges((8,), RATE_HZ)) == ()
