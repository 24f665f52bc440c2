"""The preview of an effect: what arrives, what limits it, for one finger and for several; and the commands."""

from __future__ import annotations

import json

import numpy as np
import pytest
from designed_notch import DESIGNED_NOTCH

import frictionloop as fl
from frictionloop.cli import main
from frictionloop.perception.detection_thresholds import force_threshold_n
from frictionloop.preview.pattern_measures import delivered
from frictionloop.preview.prepared_stroke import duration_s, prepared

R = fl.rendering
BENCH = fl.bench().evolve(DESIGNED_NOTCH)
NAMES = ("f_r_intended", "f_a")
IDEAL = {
    "motion.tremor_um": 0.0, "motion.tremor_n": 0.0, "motion.load_drift": 0.0, "touch.position.noise_um": 0.0,
    "touch.load.noise_n": 0.0, "controller.kind": "limit_observer", "finger.kind": "rigid", "friction.kind": "gaussian",
    "disturbance.offset_n": 0.0, "controller.delay_s": 0.0,
}  # fmt: skip


def test_a_device_without_limits_delivers_all_of_a_slow_pattern_at_its_place():
    shown = R.preview(R.Grating(spacing_mm=10.0), fl.bench().evolve(IDEAL), 20.0)
    for ways in (shown.open_loop, shown.closed_loop):
        assert ways.contrast == pytest.approx(1.0, abs=0.02)
        assert ways.moved_mm < 0.1
    known = np.isfinite(shown.closed_loop.forth_n)
    assert np.abs(shown.closed_loop.forth_n - shown.asked_forth_n)[known].max() < 0.01
    assert shown.share_in_reach == 1.0
    assert np.isinf(shown.skin_n_mm)


@pytest.mark.parametrize("speed", [20.0, 120.0])
def test_a_pattern_stays_at_its_place_forth_and_back_within_the_lag_of_the_loop(speed):
    """What lags by d is felt d ahead on the way forth and d behind on the way back: slope times 2 d apart at most."""
    shown = R.preview(R.Grating(spacing_mm=10.0), fl.bench().evolve(IDEAL), speed)
    ways = shown.closed_loop
    apart = np.abs(ways.forth_n - ways.back_n)[40:-40]
    tick_mm = speed / shown.system.controller.rate_hz
    assert np.nanmax(apart) <= shown.steepest_n_mm * 2.0 * (ways.moved_mm + 2.0 * tick_mm) + 2e-3
    both = 0.5 * (ways.forth_n + ways.back_n)[40:-40]
    assert np.nanmax(np.abs(both - shown.asked_forth_n[40:-40])) < 5e-3


def test_the_plate_takes_contrast_open_loop_as_its_low_pass_does():
    speed, spacing = 150.0, 1.5  # 100 Hz, the plate's cutoff
    system = fl.bench().evolve(IDEAL | {"plate.kind": "lowpass", "plate.cutoff_hz": 100.0})
    shown = R.preview(R.Grating(spacing_mm=spacing, amplitude_n=0.02), system, speed)
    assert shown.open_loop.contrast == pytest.approx(np.sqrt(0.5), rel=0.05)
    late_s = shown.open_loop.moved_mm / speed
    assert late_s == pytest.approx(np.pi / 4 / (2 * np.pi * 100.0), abs=4e-4)


@pytest.mark.parametrize("speed", [40.0, 80.0])
def test_what_arrives_of_a_grating_is_its_share_at_its_own_period_not_its_noise(speed):
    ready = prepared(R.Grating(spacing_mm=2.0), BENCH.evolve({"friction.roughness_rms": 0.3}), speed)
    run = fl.simulate(ready, duration_s(ready), 0)
    cross, power = 0.0, 0.0
    for way in (1.0, -1.0):
        keep = run["scored"].values & (run["speed"].values * way > 0.0)
        wave = np.exp(1j * np.pi * 1e3 * run["position"].values[keep])
        wanted, force = (np.mean((run[name].values[keep] - run[name].values[keep].mean()) * wave) for name in NAMES)
        cross += force * np.conj(wanted) if way > 0.0 else np.conj(force) * wanted  # what is late is behind, both ways
        power += abs(wanted) ** 2
    found = delivered(run, "notch_pi")
    assert found.contrast == pytest.approx(abs(cross) / power, rel=0.03)
    wanted, force = (run[name].values[run["scored"].values] for name in NAMES)
    assert force.std() / wanted.std() > 1.1 * found.contrast


def test_the_open_loop_has_a_table_of_its_own_where_a_law_is_told_other_beliefs():
    """A model with twice the friction would vibrate far too much open loop."""
    tuned = BENCH.evolve({"controller.model.nominal_n": 2.2})
    shown = R.preview("grating", tuned, 80.0, table=BENCH.controller.model)
    plain = R.preview("grating", BENCH, 80.0)
    assert shown.table_model == BENCH.controller.model == plain.table_model
    np.testing.assert_array_equal(shown.open_loop.forth_n, plain.open_loop.forth_n)
    assert shown.closed_loop.rms_error_n != plain.closed_loop.rms_error_n
    wrong = R.preview("grating", tuned, 80.0)
    assert wrong.table_model.nominal_n == 2.2
    assert wrong.open_loop.mean_error_n < shown.open_loop.mean_error_n - 0.1


def test_closed_loop_brings_more_of_a_grating_and_less_of_an_error():
    shown = R.preview("grating", BENCH, 80.0)
    assert abs(1.0 - shown.closed_loop.contrast) < abs(1.0 - shown.open_loop.contrast)
    assert shown.closed_loop.rms_error_n < 0.5 * shown.open_loop.rms_error_n
    assert shown.steepest_n_mm == pytest.approx(0.15 * 2 * np.pi / 2.0, rel=1e-3)
    assert shown.skin_n_mm == 1.0
    assert shown.closed_loop.pattern_felt > 1.0


def test_which_parts_are_felt_is_told_over_place_by_how_much():
    """A sine of f_n = v/L is felt by its rms over the threshold at f_n; a plain surface around it is not felt."""
    speed, spacing, amplitude = 80.0, 2.0, 0.05
    patch = R.Grating(spacing_mm=spacing, amplitude_n=amplitude).mask(R.Edge(from_n=0.0, to_n=1.0, width_mm=0.1), 0.45)
    shown = R.preview(patch, fl.bench().evolve(IDEAL), speed)
    over, place = shown.open_loop.pattern_over / shown.open_loop.contrast, shown.place_mm
    threshold_n = float(force_threshold_n(speed / spacing))
    inside = over[(place > 8.0) & (place < 20.0)]
    # The filter stands within 0.44 dB of the table.
    assert np.median(inside) == pytest.approx(amplitude / np.sqrt(2) / threshold_n, rel=0.07)
    assert np.nanmax(over[place < -8.0]) < 1.0
    assert shown.open_loop.share_felt == pytest.approx(0.5, abs=0.1)


def test_what_the_skin_carries_of_a_period_is_told():
    assert R.preview("grating", BENCH, 80.0).skin_amplitude_n == pytest.approx(1.0 * 2.0 / (2 * np.pi))
    assert np.isnan(R.preview("edge", BENCH, 80.0).skin_amplitude_n)


def test_what_is_clamped_is_told():
    shown = R.preview(R.Grating(offset_n=0.7, amplitude_n=0.3, spacing_mm=10.0), BENCH)
    assert shown.share_clamped == pytest.approx(
        np.mean(0.7 + 0.3 * np.sin(np.linspace(0, 2 * np.pi, 10001)) > 0.95), abs=0.01
    )
    assert shown.clamped_n == pytest.approx(0.05, abs=1e-3)


def test_a_level_has_no_contrast():
    shown = R.preview("constant", BENCH)
    assert np.isnan(shown.closed_loop.contrast)


def test_fingers_are_given_more_alike_closed_loop():
    crowd = R.people("bump", BENCH, fl.fingers(4, seed=2))
    open_n, closed_n = crowd.spread_n
    assert closed_n < 0.5 * open_n
    assert len(crowd.contrasts[0]) == 4


@pytest.mark.slow
def test_a_table_has_what_single_previews_have():
    fingers = fl.fingers(4, seed=2)
    table = R.arrivals(["bump", "grating"], BENCH, fingers, speeds_mm_s=(40.0, 80.0))
    assert dict(table.sizes) == {"effect": 2, "speed_mm_s": 2, "law": 2, "finger": 4}
    shown = R.preview("grating", BENCH.evolve(fingers[2]), 80.0)
    cell = table.sel(effect="grating", speed_mm_s=80.0).isel(finger=2)
    assert float(cell.contrast.sel(law="open")) == pytest.approx(shown.open_loop.contrast, rel=1e-9)
    assert float(cell.contrast.sel(law="closed")) == pytest.approx(shown.closed_loop.contrast, rel=1e-9)
    assert float(cell.rms_error.sel(law="closed")) == pytest.approx(shown.closed_loop.rms_error_n, rel=1e-9)
    crowd = R.people("bump", BENCH, fingers, 40.0)
    assert np.allclose(table.spread.sel(effect="bump", speed_mm_s=40.0), crowd.spread_n)


def test_a_preview_is_drawn(tmp_path):
    fl.plot(R.preview("braille", BENCH), tmp_path / "braille.svg")
    assert (tmp_path / "braille.svg").read_text().startswith("<?xml")


def run(capsys, *tokens):
    with pytest.raises(SystemExit) as left:
        main(["effect", *tokens])
    told = capsys.readouterr()
    return left.value.code or 0, told.out, told.err


def test_the_commands_list_show_check_play_and_import(capsys, tmp_path):
    code, out, _ = run(capsys, "list", "--json")
    assert code == 0
    assert [each["name"] for each in json.loads(out)["effects"]] == list(R.LIBRARY)
    code, out, _ = run(capsys, "show", "grating", "--speed-mm-s", "80", "--save", str(tmp_path / "g.toml"), "--json")
    shown = json.loads(out)
    assert shown["open_loop"]["contrast"] < shown["closed_loop"]["contrast"] < 1.0
    assert R.read_effect(tmp_path / "g.toml") == R.LIBRARY["grating"]
    code, out, _ = run(capsys, "check", "button", "--json")
    assert json.loads(out)["triggers"] == 1
    code, out, _ = run(capsys, "check", "wall")
    assert "32768 values" in out
    code, out, _ = run(capsys, "play", "bump", "--duration-s", "1", "--out", str(tmp_path / "run.h5"), "--json")
    assert code == 0
    assert "f_r_intended" in fl.load(tmp_path / "run.h5")
    R.write_image(R.rasterise(R.LIBRARY["braille"], 12.0, 8.0), tmp_path / "b.png")
    code, out, _ = run(capsys, "import", str(tmp_path / "b.png"), "--out", str(tmp_path / "b.toml"))
    assert code == 0
    assert R.read_effect(tmp_path / "b.toml").kind == "map"


@pytest.mark.parametrize(
    ("tokens", "line"),
    [
        (("show", "gratin"), "error: effect: 'gratin' is unknown"),
        (("show", "no.toml"), "error: no.toml: cannot be read"),
        (("check", "constant", "--controller.model.nominal_n", "0.2"), "error: effect = 0.45 to 0.45 N: must have"),
        (("play", "grating", "--preset", "paper"), 'motion.kind: must be "strokes"'),
        (("play", "grating", "--setpoint.kind", "sine"), "error: setpoint.kind: is set by EFFECT"),
        (("import", "x.gif", "--out", "x.toml"), "error: x.gif: format '.gif' is unknown"),
        (("import", "x.ahap", "--out", "x.toml"), "error: x.ahap: full_n is missing"),
    ],
)
def test_the_commands_refuse_in_one_line(capsys, tokens, line):
    code, out, told = run(capsys, *tokens)
    assert (code, out) == (2, "")
    assert line in told
    assert told.count("\n") == 1
