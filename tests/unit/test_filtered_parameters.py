"""Filtered and notch PI as parameters: TOML, evolve, sweeps, and what is refused in one line."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.filtered_pi import sections_of

BENCH = fl.bench()
NOTCH = BENCH.evolve({"controller.kind": "notch_pi", "controller.kp": 0.06, "controller.ki": 130.0})
SECTIONS = ((0.9, -1.6, 0.8, -1.6, 0.7), (0.5, 0.5, 0.0, 0.0, 0.0))


def test_out_and_in_again(tmp_path):
    for system in (
        NOTCH.evolve({"controller.notch_hz": 131.5, "controller.feedforward": True}),
        BENCH.evolve({"controller.kind": "filtered_pi", "controller.sections": SECTIONS, "controller.overdrive": True}),
    ):
        path = tmp_path / "mine.toml"
        fl.write_toml(system, path)
        assert fl.read_toml(path) == system
    text = path.read_text()
    assert "sections = [[0.9, -1.6, 0.8, -1.6, 0.7], [0.5, 0.5, 0.0, 0.0, 0.0]]" in text
    assert "notch_hz = 131.5  # Hz" in fl.to_toml(NOTCH.evolve({"controller.notch_hz": 131.5}))


def test_a_change_of_kind_keeps_the_gains_and_the_timing():
    assert (NOTCH.controller.kp, NOTCH.controller.ki) == (0.06, 130.0)
    assert NOTCH.controller.delay_s == BENCH.controller.delay_s
    assert NOTCH.controller.model == BENCH.controller.model
    assert NOTCH.evolve({"controller.kind": "filtered_pi"}).controller.sections == ()


REFUSED = {
    "seven sections": ({"sections": ((1.0, 0, 0, 0, 0),) * 7}, "controller.sections", "at most 6 sections, not 7"),
    "an unstable pair": ({"sections": ((1.0, 0, 0, -1.9, 0.8),)}, "controller.sections.0", "(-1.9, 0.8): must be"),
    "a pole on the circle": ({"sections": ((1.0, 0, 0, 0, 1.0),)}, "controller.sections.0", "must be stable: |a2| < 1"),
    "beyond Q31": ({"sections": ((1.0, 0, 0, 0, 0), (2.5, 0, 0, 0, 0))}, "controller.sections.1", "= 2.5: must be"),
    "four numbers": ({"sections": ((1.0, 0, 0, 0),)}, "controller.sections.0.4", "missing"),
    "too late": ({"feedforward": True, "delay_s": 610e-6}, "controller", "at most 3, 0.0006 s"),
    "Nyquist": ({"kind": "notch_pi", "notch_hz": 2500.0}, "controller", "notch_hz = 2500 Hz: "),
    "a peak": ({"kind": "notch_pi", "notch_depth": 9.6}, "controller", "must be at most notch_width, 9.5"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case):
    changes, path, told = REFUSED[case]
    with pytest.raises(fl.FrictionloopError) as failure:
        BENCH.evolve({"controller.kind": "filtered_pi"} | {f"controller.{name}": v for name, v in changes.items()})
    line = str(failure.value)
    assert line.startswith(path)
    assert told in line
    assert "\n" not in line


def test_a_delay_of_three_periods_is_followed():
    assert NOTCH.evolve({"controller.feedforward": True, "controller.delay_s": 3 / 5000.0}).controller.feedforward
    assert NOTCH.evolve({"controller.delay_s": 0.1}).controller.delay_s == 0.1  # without it any delay will do


def test_a_sweep_over_the_notch_is_its_runs_one_by_one():
    grid = fl.sweep(
        NOTCH, {"controller.notch_hz": [60.0, 120.0, 138.0, 150.0], "controller.notch_width": [0.2, 0.8]}, 0.2,
        metrics=["rms_error"],
    ).rms_error  # fmt: skip
    assert np.unique(grid.values).size == 8
    for hz, width in ((60.0, 0.8), (150.0, 0.2)):
        system = NOTCH.evolve({"controller.notch_hz": hz, "controller.notch_width": width})
        alone = fl.sweep(system, [{}], 0.2, metrics=["rms_error"]).rms_error.item()
        got = grid.sel({"controller.notch_hz": hz, "controller.notch_width": width}).item()
        assert got == alone
    with pytest.raises(fl.FrictionloopError, match=r"notch_depth = 0\.3: .*notch_width, 0\.2"):
        fl.sweep(NOTCH, {"controller.notch_width": [0.8, 0.2], "controller.notch_depth": [0.1, 0.3]}, 0.2)


def test_both_kinds_run_alike_in_one_tile_and_alone():
    """Filters, delays and feed-forward of their own in each lane; a notch is its one section."""
    sections = sections_of(NOTCH.controller)
    assert len(sections) == 1
    base = NOTCH.evolve(
        {"controller.kind": "filtered_pi", "controller.kp": NOTCH.controller.kp, "controller.ki": NOTCH.controller.ki}
    )
    points = [
        {"controller.sections": sections},
        {"controller.sections": sections * 3},
        {"controller.sections": SECTIONS, "controller.delay_s": 590e-6, "controller.feedforward": True},
        {"controller.sections": (), "controller.overdrive": True, "controller.feedforward": True},
    ]
    got = fl.sweep(base, points, 0.2, metrics=["rms_error"]).rms_error.values.ravel()
    alone = [fl.sweep(base.evolve(p), [{}], 0.2, metrics=["rms_error"]).rms_error.item() for p in points]
    assert got.tolist() == alone
    assert alone[0] == fl.sweep(NOTCH, [{}], 0.2, metrics=["rms_error"]).rms_error.item()
    plain = fl.simulate(BENCH.evolve(fl.RETUNED), 0.2)
    unfiltered = fl.simulate(BENCH.evolve({"controller.kind": "filtered_pi", **fl.RETUNED}), 0.2)
    for name in ("u", "f_a", "saturated"):
        np.testing.assert_array_equal(plain[name], unfiltered[name])
