"""A recorded friction that leaves the plate, or jumps as sliding friction does not, is asked about."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.analysis.operating_point import misread
from frictionloop.loop.input_findings import of_recorded
from frictionloop.recordings.friction_defects import jumps
from frictionloop.recordings.plausibility import doubts_of

RATE_HZ = 1000.0
TIME_S = np.arange(6000) / RATE_HZ
NOISE_N = 0.002 * np.random.default_rng(0).normal(size=TIME_S.size)
SLIDES_N = 0.6 + 0.05 * np.sin(2 * np.pi * 2 * TIME_S) + NOISE_N


def asked(folder, values, **more):
    np.savetxt(folder / "f.csv", np.c_[TIME_S, values], header="time_s,Ft", comments="", delimiter=",", fmt="%.6f")
    slide = fl.Recording(path=str(folder / "f.csv"), column="Ft", **more)
    system = fl.feasible().evolve({"setpoint": fl.Constant(offset_n=1.0), "disturbance": slide})
    return [each for each in doubts_of(system) if each.code == "FINGER-OFF"], system


@pytest.mark.parametrize("remove_mean", [False, True])
def test_landing_and_lifting_are_asked_about_with_the_part_between(tmp_path, remove_mean):
    slides = np.where((TIME_S >= 0.7) & (TIME_S < 5.4), SLIDES_N, NOISE_N)
    (one,), system = asked(tmp_path, slides, remove_mean=remove_mean)
    assert one.more["times"] == "0 to 0.699 s, 5.4 to 5.999 s"
    assert one.remedy == {"disturbance.start_s": 0.7, "disturbance.stop_s": 5.399}
    assert list(doubts_of(system.evolve(one.remedy))) == []


def test_lifting_in_between_and_times_of_a_part_are_those_of_the_file(tmp_path):
    slides = np.where((TIME_S >= 2.0) & (TIME_S < 2.3), NOISE_N, SLIDES_N)
    (one,), _ = asked(tmp_path, slides, start_s=1.0)
    assert one.more["times"] == "2 to 2.299 s"
    assert one.remedy == {"disturbance.start_s": 2.3, "disturbance.stop_s": 5.999}
    assert one.value == pytest.approx(3.699)


def test_the_part_on_the_plate_leaves_out_landing_and_lifting(tmp_path):
    """Over 0.2 s each the force rises and falls: it passes half of what it has after 0.1 s."""
    ramp = np.clip(np.minimum(TIME_S - 1.0, 4.0 - TIME_S) / 0.2, 0.0, 1.0)
    (one,), _ = asked(tmp_path, ramp * 0.6 + NOISE_N / 10)
    start, stop = one.remedy.values()
    assert (start, stop) == (pytest.approx(1.1, abs=0.005), pytest.approx(3.9, abs=0.005))


def test_an_offset_that_is_the_sensors_counts_where_the_finger_is_off_the_plate(tmp_path):
    slides = np.where((TIME_S >= 0.7) & (TIME_S < 5.4), SLIDES_N, NOISE_N) - 0.3
    assert asked(tmp_path, slides)[0] == []
    (one,), _ = asked(tmp_path, slides, offset_n=0.3)
    assert one.more["times"] == "0 to 0.699 s, 5.4 to 5.999 s"


def test_strokes_both_ways_with_the_finger_lifted_between_are_asked_about_too(tmp_path):
    row = np.arange(TIME_S.size) % 2000
    way = np.select([row < 800, row < 1000, row < 1800], [1.0, 0.0, -1.0], 0.0)
    (one,), _ = asked(tmp_path, way * SLIDES_N + NOISE_N)
    assert one.more["times"] == "0.8 to 0.999 s, 1.8 to 1.999 s, 2.8 to 2.999 s and 3 more"


ABOUT_ZERO = {
    "slow sine": 0.1 * np.sin(2 * np.pi * 0.1 * TIME_S),
    "sine that reaches 0": 0.4 + 0.4 * np.sin(2 * np.pi * TIME_S),
    "noise": np.cumsum(NOISE_N),
    "sliding": SLIDES_N,
    "a turn": np.where(TIME_S < 3.0, 1, np.where(TIME_S < 3.04, 0, -1)) * SLIDES_N,
    "mean removed": SLIDES_N - SLIDES_N.mean(),
}


@pytest.mark.parametrize("name", ABOUT_ZERO)
def test_nothing_is_asked_of_others(tmp_path, name):
    assert asked(tmp_path, ABOUT_ZERO[name])[0] == []


def test_the_mean_is_asked_about_too(tmp_path):
    slides = np.where(TIME_S < 0.7, NOISE_N, SLIDES_N)
    _, system = asked(tmp_path, slides)
    system = system.evolve({"setpoint": fl.Constant(offset_n=0.5)})
    assert [each.code for each in misread(system)] == ["MEAN-DOUBT", "FINGER-OFF"]


def test_a_run_says_it(tmp_path, recwarn):
    _, system = asked(tmp_path, np.where(TIME_S < 0.7, NOISE_N, SLIDES_N))
    with pytest.warns(fl.SignalWarning, match="FINGER-OFF"):
        fl.simulate(system, 0.1)


def slide(seed, seconds=4.0):
    """Return friction that varies: a drift, a tremor and noise."""
    at = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    noise = np.random.default_rng(seed).normal(0.0, 0.005, at.size)
    return 0.5 + 0.02 * np.sin(2 * np.pi * 0.3 * at) + 0.01 * np.sin(2 * np.pi * 9.0 * at) + noise


@pytest.mark.parametrize("seed", range(5))
def test_a_slide_has_none_and_a_landing_is_found_where_it_is(seed):
    force = slide(seed)
    assert jumps(force, RATE_HZ) == []
    landed = np.where(np.arange(force.size) < 1200, 0.1 * force, force)
    ((at, size),) = jumps(landed, RATE_HZ)
    assert abs(at - 1200) <= 3 and size == pytest.approx(0.45, abs=0.05)


def test_landing_and_lifting_are_two_the_larger_first():
    force = slide(0)
    force[:800], force[3000:] = 0.0, 0.2
    (landing, lifting) = jumps(force, RATE_HZ)
    assert landing[0] == pytest.approx(800, abs=3) and lifting[0] == pytest.approx(3000, abs=3)
    assert landing[1] > lifting[1]


def test_what_is_shorter_than_the_means_has_none():
    assert jumps(np.array([0.0, 1.0] * 20), RATE_HZ) == []


@pytest.mark.parametrize("step_n", [0.0, 0.002, 0.01])
def test_a_constant_and_what_a_coarse_converter_reads_have_none(step_n):
    """Its median change is 0: of it every step would be a jump."""
    force = np.full(20_000, 0.3) if step_n == 0.0 else np.round(slide(3, 20.0) / step_n) * step_n
    assert jumps(force, RATE_HZ) == []
    stairs = 0.3 + 0.01 * np.floor(np.arange(20_000) / RATE_HZ)
    assert jumps(stairs, RATE_HZ) == []


def test_a_run_names_the_moment_in_the_file_and_a_cut_without_it_says_nothing(tmp_path):
    force = slide(1)
    force[:1200] = 0.3 + 0.1 * force[:1200]  # at rest with a sensor's offset: not near 0, so nothing asks
    np.savetxt(tmp_path / "slide.csv", force, header="force", comments="")
    read = fl.Recording(path=str(tmp_path / "slide.csv"), column="force", rate_hz=RATE_HZ, remove_mean=True)

    def found(start_s, duration_s):
        system = fl.bench().evolve({"disturbance": read, "disturbance.start_s": start_s})
        return [each for each in of_recorded(system, duration_s) if each.code == "RECORDED-JUMPS"]

    (one,) = found(0.5, 3.0)
    assert one.more["at_s"][0] == pytest.approx(1.2, abs=0.003) and 100.0 < one.value < 200.0
    assert found(0.5, 0.6) == found(1.3, 2.0) == []  # the run ends before it, or begins after
