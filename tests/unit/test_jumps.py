"""A recorded disturbance that jumps as sliding friction does not is found, with the moment in the file."""

from __future__ import annotations

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.loop.signal_findings import of_recorded
from frictionloop.recordings.force_shape import jumps

RATE_HZ = 1000.0


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
