"""Simulated rigs with one defect at a time: it is named, or the interval still holds the truth."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from finger_strokes import strokes

import frictionloop as fl
from frictionloop.identification import rigs
from frictionloop.identification.project_entry_result import Sensor
from frictionloop.identification.project_file import Take
from frictionloop.identification.quiet import quiet_entry
from frictionloop.identification.sensor_resonance import hits_entry
from frictionloop.identification.slides import slides_entry
from frictionloop.identification.weights_straightness import weights_entry
from frictionloop.parameters.calibration_bench import CalibrationBench

RATE = 5000.0
CLEAN = CalibrationBench().evolve({"errors.gain_error": 0.0, "errors.nonlinearity": 0.0, "hammer.gain_error": 0.0})
SENSOR = CLEAN.sensor


def told_or_right(analysis, kind, run, truth, words, **more):
    """Return whether the defect is named by a code, or all values are within their interval of 99.9 %."""
    take = Take(kind=kind, files=("a.h5",), **more)
    try:
        told = analysis(take, [run], Sensor())
    except fl.FrictionloopError as refused:
        assert "\n" not in str(refused)
        return words is not None and words in str(refused)
    said = " ".join(f"{each.code} {each}" for each in told.findings) + " ".join(map(str, [*told.rows, told.numbers]))
    ends = {value.path: value.interval(0.999) for value in told.measured}
    right = all(ends[name].low < true < ends[name].high for name, true in truth.items() if name in ends)
    # A defect that has a name is named even where it does no harm.
    return words in said if words is not None else right


@pytest.fixture(scope="module")
def hit():
    return rigs.hammer_rig(CLEAN, hits=6, peak_n=0.3, interval_s=1.0, seed=4)


def changed(run, **columns):
    return run.assign({name: ("time", values, run[name].attrs) for name, values in columns.items()})


def clip(values, share):
    top = share * np.abs(values).max()
    return np.clip(values, -top, top)


def second_hit(run):
    later = 100
    return changed(run, **{name: run[name].values + np.roll(run[name].values, later) for name in ("hammer", "f_m")})


HIT_DEFECTS = {
    "none": (lambda run: run, None),
    "reading inverted": (lambda run: changed(run, f_m=-run.f_m.values), None),
    "hammer inverted": (lambda run: changed(run, hammer=-run.hammer.values), None),
    "both inverted": (lambda run: changed(run, f_m=-run.f_m.values, hammer=-run.hammer.values), None),
    "offset": (lambda run: changed(run, f_m=run.f_m.values + 0.2), None),
    "drift": (lambda run: changed(run, f_m=run.f_m.values + 0.02 * run.time.values), None),
    "reading clipped": (lambda run: changed(run, f_m=clip(run.f_m.values, 0.5)), "clipped"),
    "hammer clipped": (lambda run: changed(run, hammer=clip(run.hammer.values, 0.6)), "clipped"),
    "double hits": (second_hit, "double"),
    "cut off": (lambda run: run.isel(time=slice(None, int(5.3 * RATE))), "cut off"),
    "reading dead": (lambda run: changed(run, f_m=0 * run.f_m.values), ""),
}


@pytest.mark.slow
@pytest.mark.parametrize("defect", HIT_DEFECTS)
def test_hits(hit, defect):
    change, words = HIT_DEFECTS[defect]
    truth = {"sensor.resonance_hz": SENSOR.resonance_hz, "sensor.q": SENSOR.q, "sensor.cutoff_hz": SENSOR.cutoff_hz}
    assert told_or_right(hits_entry, "hits", change(hit), truth, words)


MASSES = np.array([0.0, 0.05, 0.1, 0.15, 0.2, 0.15, 0.1, 0.05, 0.0])


def table(masses=MASSES, slope=3.0, **more):
    draw = np.random.default_rng(8)
    reading = 0.1 + slope * 9.80665 * masses + 1e-3 * draw.normal(size=masses.size)
    reading = reading + sum(np.asarray(each) for each in more.values())
    data = {"mass": ("row", masses, {"units": "kg"}), "f_m": ("row", reading, {"units": "V"})}
    return xr.Dataset(data)


def in_newtons(run, factor):
    return run.assign(f_m=("row", factor * run.f_m.values, {"units": "N"}))


def beside(run, share):
    return run.assign(load=("row", share * run.mass.values, {"units": "N"}))


SPAN = 3.0 * 9.80665 * MASSES
WEIGHT_DEFECTS = {
    "none": (table(), None),
    "shuffled": (table(MASSES[[3, 0, 4, 8, 1, 6, 2, 7, 5]]), None),
    "reading inverted": (table(slope=-3.0), None),
    "bent": (table(bend=0.03 * SPAN.max() * (SPAN / SPAN.max()) ** 2), "LINE-OFF f_m: bend"),
    "drifting": (table(drift=np.linspace(0, 0.3, MASSES.size)), "LINE-OFF f_m: drift"),
    "pulley": (
        table(drag=-0.03 * SPAN * np.sign(np.diff(MASSES, prepend=0.0))), "LINE-OFF f_m: friction of the pulley"
    ),
    "up only": (table(MASSES[:5]), "NOT-TOLD friction of the pulley"),
    "kilograms as newtons": (in_newtons(table(slope=1.0), 1 / 9.80665), "unit = kg"),
    "millinewtons as newtons": (in_newtons(table(slope=1.0), 1000.0), "unit = mN"),
    "clipped": (table().map(lambda x: x.clip(max=4.5) if x.attrs["units"] == "V" else x), "g = 4.5 V: must be within"),
    "grams as kilograms": (table(1000 * MASSES, slope=3e-3), "unit = g"),
    "crosstalk": (beside(table(), 0.4), "LINE-OFF load: crosstalk"),
    "dead reading": (table(slope=0.0, away=-np.linspace(0, 0, MASSES.size)).map(lambda x: x), ""),
}  # fmt: skip


@pytest.mark.parametrize("defect", WEIGHT_DEFECTS)
def test_weights(defect):
    run, words = WEIGHT_DEFECTS[defect]
    slope = -3.0 if defect == "reading inverted" else 3.0
    truth = {"sensitivity": slope, "offset": 0.1}
    assert told_or_right(weights_entry, "weights", run, truth, words, gravity_m_s2=9.80665)


def white(seconds=6.0, density=1e-5):
    draw = np.random.default_rng(9)
    return density * np.sqrt(RATE / 2) * draw.normal(size=int(seconds * RATE))


def quiet_run(values):
    time = ("time", np.arange(values.size) / RATE, {"units": "s"})
    return xr.Dataset({"f_m": ("time", values, {"units": "N"})}, {"time": time})


def low_passed(values):
    from scipy.signal import butter, sosfiltfilt

    return sosfiltfilt(butter(8, 500, fs=RATE, output="sos"), values)


def knocked(values):
    values = values.copy()
    values[1000:1200] += 0.5
    return values


SECONDS = np.arange(int(6 * RATE)) / RATE
QUIET_DEFECTS = {
    "none": (white(), None),
    "mains": (white() + 1e-3 * np.sin(2 * np.pi * 50 * SECONDS), "lines_hz"),
    "low-passed": (low_passed(white()), "NOISE-DOUBT"),
    "a knock": (knocked(white()), None),
    "drift": (white() + 1e-3 * SECONDS, None),
    "coarse converter": (np.round(white() / 3e-3) * 3e-3, "converter steps"),
    "too short": (white(0.5), "duration = 0.5 s"),
}


@pytest.mark.parametrize("defect", QUIET_DEFECTS)
def test_quiet(defect):
    values, words = QUIET_DEFECTS[defect]
    assert told_or_right(quiet_entry, "quiet", quiet_run(values), {"sensor.noise_density_n_rthz": 1e-5}, words)


def test_clipped_steps_over_time():
    # Above 4.5 V the converter stands at its end; below, its steps of 2 mV are as wide as the noise.
    draw = np.random.default_rng(3)
    mass = np.repeat(MASSES, 400)
    reading = np.round((0.1 + 3.0 * 9.80665 * mass + 1e-3 * draw.normal(size=mass.size)) / 2e-3) * 2e-3
    time = ("time", np.arange(mass.size) / 100.0, {"units": "s"})
    for top, words in ((9.0, None), (5.98, "f_m clipped under")):
        data = {"mass": ("time", mass, {"units": "kg"}), "f_m": ("time", np.minimum(reading, top), {"units": "V"})}
        assert told_or_right(weights_entry, "weights", xr.Dataset(data, {"time": time}), {}, words)


def wrapped(run):
    way = 0.02
    return changed(run, position=np.mod(run.position.values + 0.003, way))


def late(run, name, rows):
    return changed(run, **{name: np.roll(run[name].values, rows)})


STROKES = strokes(share=0.01)
SLIDE_DEFECTS = {
    "none": (STROKES, None),
    "sensor inverted": (strokes(share=0.01, sign=-1.0), None),
    "zero drifts": (strokes(share=0.01, drift=0.5), None),
    "load behind by 20 ms": (late(STROKES, "load", 40), None),
    "position behind by 20 ms": (late(STROKES, "position", 40), None),
    "position wraps": (wrapped(STROKES), "COUNTER-WRAPS"),
    "never lifts": (STROKES.isel(time=slice(4400, 19600)), "NOT-TOLD zeros"),
    "no slide": (changed(STROKES, position=0 * STROKES.position.values), "slides = 0"),
    "mu falls": (
        changed(STROKES, f_m=STROKES.f_m.values * np.linspace(2, 0.5, STROKES.sizes["time"])),
        "LINE-OFF f_m: mu",
    ),
}


@pytest.mark.parametrize("defect", SLIDE_DEFECTS)
def test_slides(defect):
    run, words = SLIDE_DEFECTS[defect]
    assert told_or_right(slides_entry, "slides", run, {"friction.nominal_n": 0.3}, words)


def test_a_wrap_and_a_delay_are_taken_off_by_the_map(tmp_path, hit):
    """The slides of a counter that starts again, and the pole of a hammer that is recorded later than the reading."""
    run = wrapped(STROKES)
    np.savez(tmp_path / "a.npz", **{name: run[name].values for name in run.data_vars}, fs=2000.0)
    channels = {name: {"column": name, "unit": unit} for name, unit in (("f_m", "N"), ("load", "N"))}
    channels["position"] = {"column": "position", "unit": "m", "wrap": 0.02}
    found = fl.identify.load(tmp_path / "a.npz", channels)
    assert told_or_right(slides_entry, "slides", found, {"friction.nominal_n": 0.3}, None)
    assert len(fl.identify.friction(found).slides) == 6
    behind = late(hit, "hammer", 5)
    np.savez(tmp_path / "b.npz", **{name: behind[name].values for name in ("hammer", "f_m")}, fs=RATE)
    channels = {"f_m": {"column": "f_m", "unit": "N"}, "hammer": {"column": "hammer", "unit": "N", "delay_s": 5 / RATE}}
    moved = fl.identify.load(tmp_path / "b.npz", channels)
    assert told_or_right(hits_entry, "hits", moved, {"sensor.cutoff_hz": SENSOR.cutoff_hz}, None)
    values = hits_entry(Take(kind="hits", files=("b",)), [moved], Sensor()).measured
    assert "sensor.cutoff_hz" in {each.path for each in values}


def test_crosstalk_is_taken_off_by_the_map(tmp_path):
    draw = np.random.default_rng(2)
    load, force = draw.normal(size=3000), draw.normal(size=3000)
    np.savez(tmp_path / "a.npz", load=load, f=force + 0.05 * load, fs=1000.0)
    channels = {"load": {"column": "load"}, "f_m": {"column": "f", "crosstalk": {"load": 0.05}}}
    np.testing.assert_allclose(fl.identify.load(tmp_path / "a.npz", channels).f_m, force, atol=1e-12)
    channels["f_m"]["crosstalk"] = {"lod": 0.05}
    with pytest.raises(fl.FrictionloopError, match="'lod' is unknown; did you mean load"):
        fl.identify.load(tmp_path / "a.npz", channels)
