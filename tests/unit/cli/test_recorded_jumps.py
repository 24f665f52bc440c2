"""A recorded disturbance that jumps as sliding friction does not is told, with the moment in the file."""

from __future__ import annotations

import numpy as np
import pytest

from frictionloop.cli.recorded_jumps import jumps

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


@pytest.mark.slow
def test_a_run_names_the_moment_in_the_file_and_a_cut_without_it_says_nothing(frictionloop):
    force = slide(1)
    force[:1200] = 0.3 + 0.1 * force[:1200]  # at rest with a sensor's offset: not near 0, so nothing asks
    np.savetxt("slide.csv", force, header="force", comments="")
    given = ("simulate", "--preset", "bench", "--disturbance.kind", "recording", "--disturbance.path", "slide.csv")
    given += ("--disturbance.rate_hz", "1000", "--disturbance.column", "force", "--disturbance.remove_mean", "true")
    said = " ".join(frictionloop(*given, "--disturbance.start_s", "0.5", "--duration-s", "3").out.split())
    assert "The recorded disturbance jumps by 1" in said and "at 1.2 s of the file: where that is a finger" in said
    early = frictionloop(*given, "--disturbance.start_s", "0.5", "--duration-s", "0.6").out
    assert "jumps by" not in early  # the run ends before it
    after = frictionloop(*given, "--disturbance.start_s", "1.3", "--duration-s", "2").out
    assert "jumps by" not in after
