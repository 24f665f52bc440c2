"""Slides of a finger: found in a long record, with friction, load exponent and spectrum of known ones."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr

import frictionloop as fl
from frictionloop.identification import friction

RATE = 2000.0


def coloured(draw, size, power):
    """Noise whose power falls as f^power, by its Fourier transform; unit variance."""
    hertz = np.fft.rfftfreq(size, 1 / RATE)
    hertz[0] = hertz[1]
    noise = np.fft.irfft(np.fft.rfft(draw.normal(size=size)) * hertz ** (power / 2), size)
    return noise / noise.std()


def strokes(seed=0, mu=0.6, exponent=0.8, power=-1.4, drift=0.05, sign=1.0, share=0.03):
    """One second without contact, six strokes there and back under rising loads, and one more second."""
    draw = np.random.default_rng(seed)
    size = int(12 * RATE)
    time = np.arange(size) / RATE
    touching = (time > 2) & (time < 10)
    speed = np.where(touching, 0.04 * np.sign(np.sin(2 * np.pi * (time - 2) / 2.6667)), 0.0)
    load = np.where(touching, 0.3 + 0.06 * (time - 2) + 0.02 * np.sin(2 * np.pi * 0.9 * time), 0.0)
    level = mu * 0.5 * (np.maximum(load, 1e-9) / 0.5) ** exponent * (1 + share * coloured(draw, size, power))
    zero = drift * time / 12
    force = sign * np.where(touching, level * np.sign(speed), 0.0) + zero + 1e-4 * draw.normal(size=size)
    return xr.Dataset(
        {
            "f_m": ("time", force, {"units": "N"}),
            "load": ("time", load + 0.1 + 1e-3 * draw.normal(size=size), {"units": "N"}),
            "position": ("time", np.cumsum(speed) / RATE, {"units": "m"}),
        },
        {"time": ("time", time, {"units": "s"})},
    )


def test_slides_are_found_with_their_friction():
    found = friction(strokes(share=0.01))
    assert len(found.slides) == 6
    assert [np.sign(slide.speed_m_s) for slide in found.slides] == [1, -1] * 3
    for slide in found.slides:
        assert abs(slide.speed_m_s) == pytest.approx(0.04, rel=0.02)
        assert slide.friction_n == pytest.approx(0.3 * (slide.load_n / 0.5) ** 0.8, rel=0.03)
    assert found.exponent.value == pytest.approx(0.8, abs=0.1)
    assert found.level_n(0.5) == pytest.approx(0.3, rel=0.02)


def test_the_sign_of_the_sensor_does_not_matter():
    one, other = friction(strokes(drift=0.0)), friction(strokes(drift=0.0, sign=-1.0))
    assert other.mu.value == pytest.approx(one.mu.value, rel=1e-3)


@pytest.mark.parametrize("power", [-0.5, -1.0, -1.5, -2.0])
def test_two_estimators_of_the_spectrum(power):
    found = friction(strokes(seed=3, power=power, share=0.1)).slides
    assert np.mean([slide.slope_whittle for slide in found]) == pytest.approx(power, abs=0.15)
    assert np.mean([slide.slope_welch for slide in found]) == pytest.approx(power, abs=0.3)


def test_electroadhesion_is_refused_by_name():
    run = strokes()
    rising = np.abs(run.f_m.values)
    with pytest.raises(fl.FrictionloopError, match="electroadhesion"):
        friction(run.assign(amplitude=("time", rising, {"units": "V"})))
    friction(run.assign(amplitude=("time", rising.max() - rising, {"units": "um"})))


def test_a_record_without_a_slide_is_refused():
    run = strokes()
    still = run.assign(position=("time", 0 * run.position.values, {"units": "m"}))
    with pytest.raises(fl.FrictionloopError, match="no slide"):
        friction(still)
    with pytest.raises(fl.FrictionloopError, match="no column 'load'"):
        friction(run.drop_vars("load"))


def test_a_simulated_bench():
    """The finger of the bench slides on a plate that is still: friction over load is that of its law."""
    flat = {"friction.roughness_rms": 0.0, "friction.occlusion_ratio": 1.0, "friction.load_exponent": 1.0}
    run = fl.plain_stroke(fl.bench().evolve(flat), 0.0, duration_s=6.0)
    # What the finger feels, without the sensor in between.
    found = friction(run[["position", "load"]].assign(f_m=run.f_a))
    assert len(found.slides) >= 2 and "never lifts" in " ".join(found.told)
    assert found.mu.value == pytest.approx(0.95 / 0.5, rel=0.02)
    assert found.level_n(0.5) == pytest.approx(0.95, rel=0.05)
    assert all(abs(slide.speed_m_s) == pytest.approx(0.02, rel=0.1) for slide in found.slides)
