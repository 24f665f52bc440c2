"""Figures of runs and sweeps: which panels there are, what they hold, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.parameters.presets import STILL

KPS, KIS = np.geomspace(1.0, 30.0, 6), np.linspace(0.0, 20.0, 4)


def swept(points, **more):
    return fl.sweep(fl.feasible(), points, 0.1, seeds=3, metrics=["rms_error", "saturation_index"], **more)


def test_a_sweep_over_one_parameter_is_a_curve_per_metric():
    result = swept({"controller.kp": KPS})
    error, clamped = fl.plot(result).axes
    (line,) = error.lines
    np.testing.assert_allclose(line.get_xdata(), KPS)
    np.testing.assert_allclose(line.get_ydata(), 1e3 * result.rms_error.mean("seed"))
    assert (error.get_xscale(), error.get_ylabel()) == ("log", "rms_error (mN)")
    assert (error.get_xlabel(), clamped.get_ylabel()) == ("controller.kp (N/N)", "saturation_index")


def test_a_sweep_over_two_is_a_map_per_metric():
    result = swept({"controller.kp": KPS, "controller.ki": KIS})[["rms_error"]]
    panel, _bar = fl.plot(result).axes
    drawn = panel.collections[0].get_array().reshape(KIS.size, KPS.size)
    np.testing.assert_allclose(drawn, 1e3 * result.rms_error.mean("seed").values.T)


def test_a_sweep_over_three_is_a_map_for_each_value_of_the_third():
    points = {"controller.kp": KPS, "controller.ki": KIS, "controller.delay_s": [0.0, 2e-4]}
    figure = fl.plot(swept(points)[["rms_error"]])
    maps = [axes for axes in figure.axes if axes.get_title(loc="left")]
    assert [axes.get_title(loc="left") for axes in maps] == ["controller.delay_s = 0", "controller.delay_s = 0.0002"]
    limits = {axes.collections[0].get_clim() for axes in maps}
    assert len(limits) == 1  # one colour is one value in both


def test_fingers_are_points_sorted_by_the_metric_and_open_where_they_cannot():
    people = fl.fingers(7, 1)
    result = fl.sweep(fl.bench().evolve(fl.RETUNED), people, 0.5, 2, ["rms_error"])
    able = fl.capable(people, 0.5, 0.7).capable
    assert 0 < int(able.sum()) < 7
    figure = fl.plot(result.assign_coords(capable=able))
    (panel,) = figure.axes
    mean = 1e3 * result.rms_error.mean("seed").values
    filled, opened = panel.lines[:2]
    np.testing.assert_allclose(filled.get_ydata(), np.sort(mean[able.values]))
    np.testing.assert_allclose(opened.get_ydata(), np.sort(mean[~able.values]))
    assert sorted([*filled.get_xdata(), *opened.get_xdata()]) == [1, 2, 3, 4, 5, 6, 7]
    assert f"{7 - int(able.sum())} of 7 fingers, which cannot be given the set-point." in figure.get_supxlabel()
    served = result.assign_coords(capable=able, served=("finger", np.arange(7) > 4))
    assert "Hollow: 5 of 7 fingers, which cannot be given the set-point in ordinary use." in (
        fl.plot(served).get_supxlabel()
    )


def test_listed_points_are_a_distribution():
    result = fl.sweep(fl.bench().evolve(fl.RETUNED), list(fl.fingers(7, 1)), 0.5, 1, ["rms_error"])
    (panel,) = fl.plot(result).axes
    values = panel.lines[0].get_xdata()
    np.testing.assert_allclose(values, 1e3 * np.sort(result.rms_error.values.ravel()))
    assert panel.lines[0].get_ydata()[-1] == 1.0


@pytest.mark.parametrize("ending", [".svg", ".pdf", ".png"])
def test_it_is_written_too(tmp_path, ending):
    path = tmp_path / f"run{ending}"
    fl.plot(fl.simulate(fl.feasible(), 0.1), path)
    start = {".svg": b"<?xml", ".pdf": b"%PDF", ".png": b"\x89PNG"}[ending]
    assert path.read_bytes().startswith(start)


def test_refusals():
    with pytest.raises(fl.FrictionloopError, match="result = "):
        fl.plot(3.0)
    with pytest.raises(fl.FrictionloopError, match="must end in "):
        fl.plot(fl.simulate(fl.feasible(), 0.1), "run.bmp")
    four = {"controller.kp": [1.0], "controller.ki": [1.0], "plate.cutoff_hz": [90.0], "controller.delay_s": [0.0]}
    with pytest.raises(fl.FrictionloopError, match="result has 4 parameters"):
        fl.plot(swept(four))


def test_all_metrics_of_a_run_are_those_by_name():
    run = fl.simulate(fl.bench().evolve(fl.RETUNED), 3.0)
    found = fl.metrics(run)
    assert found["rms_error"] == fl.rms_error(run)
    assert found["perceptual_index"] == fl.perceptual_index(run)
    assert (found["r2_regression"], found["slope"], found["intercept"]) == tuple(fl.regression(run))
    still = fl.metrics(fl.simulate(fl.feasible().evolve(setpoint=fl.Constant(offset_n=0.5)), 0.1))
    assert np.isnan(still["r2_identity"])
    assert np.isnan(still["perceptual_index"])


def test_a_run_is_drawn_with_its_disturbance_and_in_open_loop():
    run = fl.simulate(fl.feasible(), 0.5)
    force, disturbance, _amplitude = fl.plot(run).axes
    opened, closed, wanted = force.lines
    assert opened.get_label().startswith("the same in open loop: error ")
    np.testing.assert_array_equal(closed.get_ydata(), run.f_a)
    np.testing.assert_array_equal(wanted.get_ydata(), run.f_r)  # drawn last, above the force
    np.testing.assert_array_equal(disturbance.lines[0].get_ydata(), run.d)


def test_a_measured_set_point_is_drawn_below_the_force_that_varies_as_it_does():
    wanted_n = 0.5 + 0.02 * np.random.default_rng(0).normal(size=2501)
    system = fl.feasible().evolve({"setpoint": fl.Samples(values_n=wanted_n, rate_hz=5000)})
    lines = {line.get_label()[:9]: line for line in fl.plot(fl.simulate(system, 0.5)).axes[0].lines}
    assert lines["set-point"].get_zorder() < lines["force on "].get_zorder()
    assert lines["set-point"].get_linewidth() > lines["force on "].get_linewidth()


def test_a_figure_says_what_its_axes_cut_off():
    run = fl.simulate(fl.bench(), 0.5)
    force = fl.plot(run).axes[0]
    assert not any("not scored: " in said for said in force.get_legend_handles_labels()[1])
    spiked = run.f_a.values.copy()
    spiked[~run.scored.values] = 9.0
    labels = fl.plot(run.assign(f_a=("time", spiked))).axes[0].get_legend_handles_labels()[1]
    (said,) = [label for label in labels if "not scored: " in label]
    assert said.endswith("to 9 N")


def test_a_figure_says_what_is_left_as_the_metrics_do():
    run = fl.simulate(fl.feasible().evolve({"disturbance": fl.Sine(amplitude_n=0.1)}), 0.5)
    opened, closed, _ = fl.plot(run).axes[0].lines
    left = fl.metrics(run)["disturbance_left"]
    assert f"\n{100 * left:.0f} % of $d$" in closed.get_label()
    assert "own drift" not in opened.get_label()
    calm = fl.plot(fl.simulate(fl.feasible().evolve({"disturbance": fl.Constant()}), 0.1)).axes[0].lines
    assert "of $d$" not in calm[1].get_label()
    bench = fl.plot(fl.simulate(fl.bench().evolve(fl.RETUNED), 0.5)).axes[0].lines
    assert bench[0].get_label().endswith("the finger's own drift included")
    still = fl.simulate(fl.bench().evolve({**fl.RETUNED, **STILL}), 0.5)
    assert "own drift" not in fl.plot(still).axes[0].lines[0].get_label()
