"""The operating point and the gain that lookup table and friction law have together."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.analysis import elements, linearise, lumped_gain
from frictionloop.control.lookup import lookup_table
from frictionloop.parameters import System, paper
from frictionloop.physics.friction import amplitude_for, friction_force
from frictionloop.physics.reach import reachable
from frictionloop.quantities import FrictionloopError


def wrong_model(**more: float) -> System:
    wrong = {"controller.model.nominal_n": 1.1, "controller.model.susceptibility_per_um2": 0.3}
    return paper().evolve(wrong | {f"controller.model.{name}": value for name, value in more.items()})


def test_a_right_model_gives_the_unit_gain_everywhere() -> None:
    for amplitude_um in np.linspace(0.0, 2.5, 11):
        assert lumped_gain(paper(), amplitude_um) == pytest.approx(1.0, rel=1e-14)


@pytest.mark.parametrize("amplitude_um", [0.3, 1.0, 2.4])
def test_gain_is_the_slope_of_force_over_command(amplitude_um: float) -> None:
    system = wrong_model()
    believed = system.controller.model

    def force(u: float) -> float:
        a = np.sqrt(np.log(believed.nominal_n / u) / believed.susceptibility_per_um2)
        return float(friction_force(a, system.friction))

    u = believed.nominal_n * np.exp(-believed.susceptibility_per_um2 * amplitude_um**2)
    h = 1e-6 * u
    # A central difference errs by h^2 in the slope and by rounding / h: 1e-8 covers both.
    assert lumped_gain(system, amplitude_um) == pytest.approx((force(u + h) - force(u - h)) / (2 * h), rel=1e-8)


def test_gain_at_rest_is_the_limit_of_the_ratio_of_slopes() -> None:
    system = wrong_model()
    ratio = (0.8 * 0.38) / (1.1 * 0.3)
    assert lumped_gain(system, 0.0) == pytest.approx(ratio, rel=1e-14)


@pytest.mark.parametrize("amplitude_um", [0.0, 0.2, 1.3, 2.5])
def test_gain_of_a_table_is_the_slope_of_its_cell(amplitude_um: float) -> None:
    system = wrong_model(table_size=16)
    squares = lookup_table(system.controller.model)
    u = np.linspace(system.controller.model.floor_n, system.controller.model.nominal_n, 16)
    here = np.interp(amplitude_um**2, squares[::-1], u[::-1])
    inward = 1e-6 if amplitude_um > 0 else -1e-6
    steps = here + np.array([0.0, inward])
    forces = friction_force(np.sqrt(np.maximum(np.interp(steps, u, squares), 0)), system.friction)
    # A forward difference of 1e-6 N errs by half its width times the curvature, below 1e-5 of the slope here.
    assert lumped_gain(system, amplitude_um) == pytest.approx(np.diff(forces)[0] / inward, rel=1e-5)


def test_the_default_point_is_the_middle_of_the_reachable_forces() -> None:
    low_n, high_n = reachable(paper())
    point = elements(paper())
    assert point.force_n == pytest.approx((low_n + high_n) / 2, rel=1e-14)
    assert point.amplitude_um == pytest.approx(float(amplitude_for(point.force_n, paper().friction)), rel=1e-14)
    assert elements(paper(), force_n=0.3).force_n == pytest.approx(0.3, rel=1e-14)
    assert elements(paper(), amplitude_um=2.5).amplitude_um == 2.5


@pytest.mark.parametrize(
    ("point", "says"),
    [
        ({"amplitude_um": 2.6}, "amplitude_um = 2.6 um: must be between 0 and 2.5"),
        ({"amplitude_um": float("nan")}, "amplitude_um = nan"),
        ({"force_n": 0.9}, "force_n = 0.9 N: must be between 0.074"),
        ({"amplitude_um": 1.0, "force_n": 0.5}, "amplitude_um, force_n: give one"),
    ],
)
def test_an_impossible_point_is_one_line(point: dict[str, float], says: str) -> None:
    with pytest.raises(FrictionloopError, match=says):
        linearise(paper(), **point)


def test_a_frequency_or_reading_out_of_range_is_one_line() -> None:
    loop = linearise(paper())
    with pytest.raises(FrictionloopError, match=r"frequency_hz = 2501 Hz: .*2500"):
        loop.frequency_response([1.0, 2501.0])
    with pytest.raises(FrictionloopError, match="'sampled'"):
        loop.frequency_response([1.0], reading="exact")  # type: ignore[arg-type]
    with pytest.raises(FrictionloopError, match=r"controller.delay_s = 0.5 s: .*at most 1000"):
        linearise(paper().evolve({"controller.delay_s": 0.5})).state_space()
