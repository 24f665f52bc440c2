"""A simulated lab's recordings in every file format, identify bench, its parameters, certificate, gains that hold."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
import recorded_files as files
import scipy.io
import simulated_lab
import three_modes

import frictionloop as fl
from frictionloop.cli import main


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        main(["identify", *map(str, words)])
    return left.value.code, *capsys.readouterr()


@pytest.mark.parametrize("form", files.FORMATS)
def test_every_format_gives_the_true_bench(tmp_path, form):
    found = fl.identify.bench(simulated_lab.lab(tmp_path, form))
    # Five intervals of 99.9 %: one in two hundred benches fails.
    assert simulated_lab.outside(found, 0.999) == {}
    assert simulated_lab.near(found, 0.05)
    system = found.system
    assert system.controller.model.resonance_hz == system.sensor.resonance_hz == pytest.approx(173.0, rel=1e-3)
    assert system.sensor.range_n == pytest.approx(2.5, rel=5e-3)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    return simulated_lab.lab(tmp_path_factory.mktemp("lab"), "object.mat", seed=5)


def test_gains_for_the_found_bench_hold_on_the_true_one(lab):
    found = fl.identify.bench(lab)
    tuned = fl.retune(fl.operating_band(found.system))
    sensor = {
        f"sensor.{name}": getattr(simulated_lab.BENCH.sensor, name) for name in ("resonance_hz", "q", "cutoff_hz")
    }
    true = found.system.evolve(sensor).evolve(tuned.overrides)
    worst = max((loop.margins() for loop in fl.operating_band(true)), key=lambda each: each.sensitivity_peak)
    assert worst.stable and worst.sensitivity_peak < 2.1


@pytest.mark.slow
def test_retune_holds_at_every_corner(lab):
    found = fl.identify.bench(lab)
    tuned = fl.retune(found.loops)
    assert len({each.path for each in found.corners}) == 3, "resonance, Q and cutoff of the sensor"
    for corner in found.corners:
        there = found.system.evolve({corner.path: corner.value} | tuned.overrides)
        for loop in fl.operating_band(there, occluded=(0.0, 1.0)):
            assert loop.margins().sensitivity_peak < 1.503


def test_the_file_says_of_each_value_what_it_is(lab, tmp_path):
    found = fl.identify.bench(lab)
    text = fl.identify.to_toml(found)
    (tmp_path / "bench.toml").write_text(text)
    assert fl.read_toml(tmp_path / "bench.toml") == found.system
    values = [
        line for line in text.splitlines() if "=" in line and line[0] not in "#[" and not line.startswith("schema")
    ]
    said = {"measured": 0, "stated": 0, "as sensor.": 0, "chosen": 0, "assumed": 0}
    for line in values:
        if line.startswith("kind"):
            continue
        which = [word for word in said if word in line]
        assert which, line
        said[which[0]] += 1
    assert (
        said["measured"] == 4 and said["as sensor."] == 3
    )  # range_n is named twice: stated over the measured sensitivity
    assert "hits.mat" in next(line for line in values if line.startswith("resonance_hz"))
    assert re.search(r"sha256 [0-9a-f]{64}", text)


@pytest.mark.slow
def test_the_command_and_its_certificate(lab, tmp_path, capsys):
    out, page = tmp_path / "my-bench.toml", tmp_path / "certificate.html"
    code, shown, _ = run(capsys, "bench", lab, "--out", out, "--report", page)
    assert code == 0 and "sensor.resonance_hz" in shown and "design controller" in shown
    html = page.read_text()
    assert html.count("<svg") == 5 and "Still assumed" in html and "plate.q" in html
    assert "http" not in re.sub(r'xmlns[^"]*"[^"]*"|<!DOCTYPE[^>]*>', "", html)  # needs nothing beside it
    for part in fl.identify.bench(lab).parts:
        assert all(each["sha256"] in html for each in part.files)
    code, shown, _ = run(capsys, "bench", lab, "--report", page, "--json")
    told = json.loads(shown)
    assert told["analysed"] == 0, "nothing has changed"
    assert (tmp_path / "certificate-1.html").read_text() == html
    assert told["saved"]["older certificate"].endswith("certificate-1.html")
    hertz = next(each for each in told["measured"] if each["path"] == "sensor.resonance_hz")
    assert hertz["interval_95"][0] < hertz["value"] < hertz["interval_95"][1] and {
        "within",
        "between",
        "method",
    } <= set(hertz)


def test_only_what_changed_is_analysed_again(tmp_path):
    path = simulated_lab.lab(tmp_path, "file.npz")
    first = fl.identify.bench(path)
    kept = json.loads(json.dumps(first.entry_results()))
    again = fl.identify.bench(path, kept)
    assert first.analysed == 3 and again.analysed == 0 and again.system == first.system
    assert again.measured["sensor.q"].interval() == first.measured["sensor.q"].interval()
    simulated_lab.write(
        tmp_path, "quiet.npz", "file.npz", simulated_lab.rigs.floor_rig(simulated_lab.BENCH, 4.0, seed=9), ["f_m"]
    )
    assert fl.identify.bench(path, kept).analysed == 1


def test_three_lines_of_uncertainty():
    from frictionloop.identification import Estimate
    from frictionloop.identification.estimate import measured

    one = measured("a", [Estimate(10.0, 0.3, "N", 8)], [0.4], "how")
    assert one.error == pytest.approx(0.5) and one.between is None
    # Files that differ by more than chance: mean 11, scatter sqrt(2), of which 0.1^2/2 is chance.
    two = measured("a", [Estimate(10.0, 0.1, "N", 8), Estimate(12.0, 0.1, "N", 8)], [0.0, 0.0], "how")
    assert (
        two.value == 11
        and two.between == pytest.approx(np.sqrt(1 - 0.005))
        and two.freedom == pytest.approx(1, abs=0.05)
    )


@pytest.mark.parametrize("how", ["a file per hit", "an array of hits"])
def test_hits_without_a_hammer_channel_at_100_khz(tmp_path, how):
    """Three modes, one hit in each file or line, and weights saved beside an object of MATLAB's."""
    run, rows = three_modes.plate(seed=1, hits=8, noise=5e-3, spread=0.003), 10000
    hits = run.f_m.values.reshape(8, rows)
    if how == "a file per hit":
        for k, hit in enumerate(hits):
            scipy.io.savemat(tmp_path / f"{k}.mat", {"data": hit[:, None], "sr": 1e5})
        files_, column = [f"{k}.mat" for k in range(8)], "data"
    else:
        scipy.io.savemat(tmp_path / "all.mat", {"data": hits.T, "sr": 1e5})
        files_, column = ["all.mat"], "data[:, *]"
    grams = np.array([0.0, 10, 20, 50, 100, 150, 200, 300])
    volts = 0.02 + 0.33 * grams * 9.80665e-3 + 5e-4 * np.random.default_rng(0).normal(size=8)
    files.mat5_with_object(tmp_path / "cal.mat", {"weights": grams, "volts": volts}, 1e5)
    (tmp_path / "lab.toml").write_text(
        f"""
[[recording]]
kind = "weights"
files = ["cal.mat"]
channels.mass = {{ column = "weights", unit = "g" }}
channels.f_m = {{ column = "volts", unit = "V" }}

[[recording]]
kind = "hits"
files = {json.dumps(files_)}
mode = "first"
channels.f_m = {{ column = "{column}", unit = "V" }}
"""
    )
    found = fl.identify.bench(tmp_path / "lab.toml")
    ends = {name: each.interval(0.99) for name, each in found.measured.items()}
    assert ends["sensitivity"].low < 0.33 < ends["sensitivity"].high
    assert ends["sensor.resonance_hz"].low < 1600 < ends["sensor.resonance_hz"].high
    assert found.measured["sensor.q"].value == pytest.approx(40, rel=0.02)
    numbers = found.parts[1].numbers
    assert numbers["hits"] == 8 and len(numbers["modes_q"]) == 3


def test_slides_give_the_friction_of_the_finger(tmp_path):
    flat = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.nominal_n": 0.8}
    stroke = fl.plain_stroke(fl.bench().evolve(flat), 0.0, duration_s=8.0)
    np.savez(tmp_path / "slide.npz", force=stroke.f_a, load=stroke["load"], x=1e3 * stroke.position, fs=5000.0)
    (tmp_path / "lab.toml").write_text(
        """
[[recording]]
kind = "slides"
files = ["slide.npz"]
[recording.channels]
f_m = { column = "force" }
load = { column = "load" }
position = { column = "x", scale = 1e-3, gives = "m" }
"""
    )
    found = fl.identify.bench(tmp_path / "lab.toml")
    assert found.system.friction.nominal_n == found.system.controller.model.nominal_n == pytest.approx(0.8, rel=0.05)
    ends = found.measured["friction.nominal_n"].interval(0.99)
    assert ends.low < 0.8 < ends.high and found.resonance_error is None


OF_ONE_ENTRY = ("did you mean hammer", "units of 'mass'")
"""What is refused of one entry: the results of the others are kept."""


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("hits.mat", "hitz.mat"), "hits = 'hitz.mat': must be a file beside it"),
        (('"hammer", unit', '"hamer", unit'), "did you mean hammer"),
        (('kind = "hits"', 'kind = "hit"'), "'hits'"),
        (('"sensor.moving_mass_kg"', '"sensor.moving_mas_kg"'), "moving_mass_kg"),
        (('column = "mass", unit = "kg"', 'column = "mass", unit = "V"'), "units of 'mass'"),
    ],
)
def test_what_a_project_refuses_is_one_line(lab, tmp_path, capsys, change, says):
    text = lab.read_text()
    assert change[0] in text
    for each in lab.parent.glob("*.mat"):
        (tmp_path / each.name).write_bytes(each.read_bytes())
    (tmp_path / "lab.toml").write_text(text.replace(*change))
    code, shown, said = run(capsys, "bench", tmp_path / "lab.toml")
    assert code == 2 and not shown and says in said and said.count("\n") == 1
    kept = list(tmp_path.glob("*.results.json"))
    assert bool(kept) == ("results kept" in said) == (says in OF_ONE_ENTRY)


def test_a_refused_entry_can_be_left_out(lab, tmp_path, capsys):
    for each in lab.parent.glob("*.mat"):
        (tmp_path / each.name).write_bytes(each.read_bytes())
    (tmp_path / "lab.toml").write_text(lab.read_text().replace('"hammer", unit', '"hamer", unit'))
    code, _, said = run(capsys, "bench", tmp_path / "lab.toml")
    assert code == 2 and "hits.mat" in said and "results kept: weights, quiet" in said
    words = ("bench", tmp_path / "lab.toml", "--without-refused", "--out", tmp_path / "b.toml", "--json")
    code, shown, _ = run(capsys, *words)
    told = json.loads(shown)
    assert code == 0 and [each["kind"] for each in told["refused"]] == ["hits"]
    assert told["analysed"] == 0 and "did you mean hammer" in told["refused"][0]["said"]
    assert told["range_db"] > 0 and told["findings"][0]["code"] == "LEFT-OUT"
    assert fl.read_toml(tmp_path / "b.toml").sensor.resonance_hz == fl.bench().sensor.resonance_hz


def test_masses_of_files_and_of_lines(tmp_path):
    """A recording for each weight: its mass is in the project, or in an array beside the lines."""
    grams, draw = np.array([0.0, 20, 50, 100, 200]), np.random.default_rng(4)
    volts = 0.1 + 2.0 * grams * 9.80665e-3 + 1e-3 * draw.normal(size=(400, 5))
    scipy.io.savemat(tmp_path / "all.mat", {"grams": grams, "volts": volts, "sr": 1e3})
    mass = 'channels.mass = { column = "grams", unit = "g" }'
    for k, line in enumerate(volts.T):
        np.savetxt(tmp_path / f"{k}.csv", line, header="V")
    listed = json.dumps([f"{k}.csv" for k in range(5)])
    for named, said, column in (
        ('["all.mat"]', mass, '"volts[:, *]"'),
        ('["all.mat"]', "masses_g = [0, 20, 50, 100, 200]", '"volts[:, *]"'),
        (listed, "masses_g = [0, 20, 50, 100, 200]", "0"),
    ):
        (tmp_path / "lab.toml").write_text(
            f'[[recording]]\nkind = "weights"\nfiles = {named}\n{said}\n'
            f'channels.f_m = {{ column = {column}, unit = "V" }}\n'
        )
        slope = fl.identify.bench(tmp_path / "lab.toml").measured["sensitivity"]
        assert slope.value == pytest.approx(2.0, rel=1e-3) and "5 weights" in slope.how
    (tmp_path / "lab.toml").write_text((tmp_path / "lab.toml").read_text().replace("[0, 20,", "[20,"))
    with pytest.raises(fl.FrictionloopError, match="masses = 4: must be 5"):
        fl.identify.bench(tmp_path / "lab.toml")


def test_channels_of_a_file(lab, tmp_path, capsys):
    code, shown, _ = run(capsys, "channels", lab.parent / "hits.mat", "--save-map", tmp_path / "map.toml")
    assert code == 0 and "hammer" in shown and "MATLAB object" in shown and "5000 Hz ('fs')" in shown
    assert set(fl.identify.read_map(tmp_path / "map.toml").channels) == {"channel_0", "channel_1"}
    code, shown, _ = run(capsys, "channels", lab.parent / "hits.mat", "--json")
    assert json.loads(shown)["rate_hz"] == 5000.0


def coverage(tmp_path, benches, first_seed):
    """Return how often intervals of 90 % hold the truth, and the median half width as a share of it."""
    inside, width = dict.fromkeys(simulated_lab.truth(), 0), {name: [] for name in simulated_lab.truth()}
    for k in range(benches):
        folder = tmp_path / str(k)
        folder.mkdir()
        found = fl.identify.bench(simulated_lab.lab(folder, "file.npz", seed=first_seed + 10 * k))
        for each in folder.iterdir():
            each.unlink()
        missed = simulated_lab.outside(found, 0.9)
        for name, true in simulated_lab.truth().items():
            ends = found.measured[name].interval(0.9)
            inside[name] += name not in missed
            width[name].append((ends.high - ends.low) / 2 / true)
    return inside, {name: float(np.median(widths)) for name, widths in width.items()}


WIDEST = {
    "sensitivity": 1e-3, "sensor.resonance_hz": 2e-4, "sensor.q": 0.01, "sensor.cutoff_hz": 0.04,
    "sensor.noise_density_n_rthz": 0.04,
}  # fmt: skip
"""Median half width of the intervals of 90 %, as a share of the value, that may not be exceeded."""


@pytest.mark.slow
def test_coverage_of_the_intervals(tmp_path):
    """Intervals of 90 % on twelve simulated benches hold the truth in nine or more, and are not wide."""
    inside, half = coverage(tmp_path, 12, 1000)
    assert all(count >= 9 for count in inside.values()), inside
    assert {name: each for name, each in half.items() if each > WIDEST[name]} == {}


@pytest.mark.soak
@pytest.mark.timeout(3600)
def test_coverage_on_200_benches(tmp_path):
    """The same on 200 benches, with seeds on which nothing was chosen.

    184 to 200 of 200 were held; the median half widths were 0.03 % of the sensitivity, 0.006 % of the resonance, 0.3 %
    of Q, 2 % of the cutoff and of the density. Where the method's line is most of the interval, it holds more than
    95 %.
    """
    inside, half = coverage(tmp_path, 200, 7_000_000)
    assert all(count >= 170 for count in inside.values()), inside
    assert {name: each for name, each in half.items() if each > WIDEST[name]} == {}


@pytest.mark.parametrize(
    ("kind", "channels", "rows", "says"),
    [
        ("hits", 'f_m = { column = "f", unit = "N" }', lambda draw: [draw.normal(size=9000)], "hits of 'f_m' = 0"),
        (
            "quiet",
            'f_m = { column = "f", unit = "N" }',
            lambda draw: [np.clip(2 * np.sin(np.arange(9000) / 99), -1, 1)],
            "clipped",
        ),
        (
            "plate",
            'vibration = { column = "f", unit = "um" }',
            lambda draw: [np.sin(2 * np.pi * 200 * np.arange(9000) / 1e3)],
            "jumps of the vibration = 0",
        ),
    ],
)
def test_a_refusal_before_any_fit_draws_the_channels(tmp_path, capsys, kind, channels, rows, says):
    columns = rows(np.random.default_rng(0))
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([np.arange(9000) / 1e3, *columns]),
        header="time_s,f",
        delimiter=",",
        comments="",
    )
    (tmp_path / "lab.toml").write_text(f'[[recording]]\nkind = "{kind}"\nfiles = ["a.csv"]\nchannels.{channels}\n')
    code, _, said = run(capsys, "bench", tmp_path / "lab.toml")
    picture = tmp_path / "lab.refused.png"
    assert code == 2 and says in said and str(picture) in said and said.count("\n") == 1
    assert picture.stat().st_size > 5000
