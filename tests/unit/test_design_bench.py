"""The bench's operating point, its elements, its noise and its re-tuned gains, in closed form and by brute force."""

from __future__ import annotations

import math
import re
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from frictionloop.analysis import elements, kp_limit, linearise, lumped_gain, operating_band, output_noise_rms_n
from frictionloop.analysis.operating_point import force_band, law_at
from frictionloop.design import retune
from frictionloop.design.pi_synthesis import forbidden, open_stretches
from frictionloop.design.plant_set import Plants
from frictionloop.parameters import RETUNED, ColouredNoise, LogSweep, Recording, Sine, Steps, System, bench, paper
from frictionloop.physics.friction import amplitude_for, friction_force

BENCH = bench()


@settings(max_examples=40, deadline=None)
@given(
    load=st.floats(0.1, 2.0), speed=st.floats(5.0, 200.0), w=st.floats(0, 1), n=st.floats(0, 1), p=st.floats(-0.2, 0.2)
)
def test_law_at_an_operating_point(load: float, speed: float, w: float, n: float, p: float) -> None:
    changes = {
        "motion.load_n": load,
        "motion.speed_mm_s": speed,
        "friction.load_exponent": n,
        "friction.speed_slope": p,
    }
    law = law_at(BENCH.evolve(changes), w)
    speeds = ((speed**2 + 1) / (20.0**2 + 1)) ** (p / 2)
    assert law.nominal_n == pytest.approx(0.95 * (load / 0.5) ** n * speeds * (1 + w), rel=1e-12)
    assert law.susceptibility_per_um2 == pytest.approx(0.38 * (1 - 0.3 * w), rel=1e-12)


@pytest.mark.parametrize("w", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("force_n", [0.5, 0.8])
def test_gain_is_the_slope_of_force_over_command(w: float, force_n: float) -> None:
    model, point = BENCH.controller.model, elements(BENCH, force_n=force_n, occluded=w)

    def force(u: float) -> float:
        a = math.sqrt(math.log(model.nominal_n / u) / model.susceptibility_per_um2)
        return float(friction_force(a, law_at(BENCH, w)))

    u = model.nominal_n * math.exp(-model.susceptibility_per_um2 * point.amplitude_um**2)
    h = 1e-6 * u
    slope = (force(u + h) - force(u - h)) / (2 * h)
    # A central difference errs by h^2 in the slope and by rounding / h: 1e-8 covers both.
    assert lumped_gain(BENCH, point.amplitude_um, w) == pytest.approx(slope, rel=1e-8)
    assert point.force_n == pytest.approx(force_n, rel=1e-12)


def test_a_right_model_of_a_finger_that_just_landed_gives_the_unit_gain() -> None:
    assert lumped_gain(BENCH, 1.0) == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("length_um", [11.5, 30.0, 0.0])
def test_elements_are_those_of_the_rooms_below(length_um: float) -> None:
    """At 20 mm/s the contact has a pole at v/z, the plate one at f/(2 Q), the sensor three."""
    system = BENCH.evolve({"finger.slip_length_um": length_um, "plate.q": 300.0})
    point, f = elements(system), np.geomspace(0.1, 2500, 50)
    s = 2j * np.pi * f
    expected = 1 / (1 + 1j * f / (46e3 / 600))
    if length_um:
        expected /= 1 + s * 1e-6 * length_um / 0.02
    np.testing.assert_allclose(point.plate.response(f), expected, rtol=1e-12)
    springs = 1 / (1 - (f / 145) ** 2 + 1j * f / 145 / 20)
    np.testing.assert_allclose(point.stages[0].response(f), springs, rtol=1e-12)
    np.testing.assert_allclose(point.sensor.response(f), springs / (1 + 1j * f / 1000), rtol=1e-12)
    assert len(point.stages) == 2


def test_the_operating_point_is_the_mean_of_the_signals() -> None:
    system = BENCH.evolve({"setpoint": Sine(offset_n=0.7, amplitude_n=0.2), "disturbance.offset_n": 0.15})
    assert linearise(system).elements.force_n == pytest.approx(0.55, rel=1e-12)
    assert force_band(system) == pytest.approx((0.35, 0.55, 0.75))
    steps = Steps(times_s=(0.0, 1.0, 2.0), levels_n=(0.4, 0.9, 0.5))
    assert force_band(BENCH.evolve({"setpoint": steps})) == pytest.approx((0.4, 0.6, 0.9))
    noise = ColouredNoise(offset_n=0.5, rms_n=0.05)
    assert force_band(BENCH.evolve({"setpoint": noise})) == pytest.approx((0.4, 0.5, 0.6))
    sweep = LogSweep(offset_n=0.5, amplitude_n=-0.2)
    assert force_band(BENCH.evolve({"setpoint": sweep})) == pytest.approx((0.3, 0.5, 0.7))
    recording = Recording(path="x.csv", rate_hz=1e3, offset_n=0.6, remove_mean=True)
    assert force_band(BENCH.evolve({"setpoint": recording})).mean_n == 0.6


def test_printed_gains_ring_and_the_retuned_ones_hold() -> None:
    assert not linearise(BENCH).is_stable()
    assert linearise(BENCH).margins().gain_margin < 0.05
    margins = linearise(BENCH.evolve(RETUNED)).margins()
    assert margins.stable
    assert margins.gain_margin > 3
    assert margins.sensitivity_peak < 1.5


@pytest.mark.parametrize(("q", "limit"), [(5.0, 0.37), (10.0, 0.18)])
def test_largest_kp_without_bristles_is_that_of_the_study(q: float, limit: float) -> None:
    """Worked out apart, two digits: 300 us of delay with half the hold, and a force at its limit at once."""
    assert kp_limit(BENCH.evolve({"sensor.q": q, "finger.slip_length_um": 0.0})) == pytest.approx(limit, abs=0.005)


def test_noise_of_the_open_loop() -> None:
    """Behind one pole a density D leaves D sqrt(pi fc/2); the converter adds step/sqrt(12)."""
    system = BENCH.evolve({"controller.kp": 0.0, "controller.ki": 0.0})
    variance = linearise(system).state_space().variance("n")["f_m"]
    decay = math.exp(-2 * math.pi * 1000 / 5000)
    drawn = 2.3e-6**2 * math.pi / 2 * 1000 * (1 + decay) / (1 - decay)
    assert drawn * variance == pytest.approx(2.3e-6**2 * math.pi / 2 * 1000, rel=1e-12)
    assert output_noise_rms_n(system) == 0.0


def test_rounding_alone_acts_like_a_noisy_setpoint() -> None:
    system = BENCH.evolve(RETUNED | {"sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 12})
    variance = linearise(system).state_space().variance("f_r")["f_a"]
    assert output_noise_rms_n(system) == pytest.approx(5 / 2**12 / math.sqrt(12) * math.sqrt(variance), rel=1e-12)


@settings(max_examples=40, deadline=None)
@given(kp=st.floats(0, 0.3), ki=st.floats(0.1, 1500), peak=st.floats(1.1, 3.0))
def test_open_stretches_are_where_no_frequency_forbids(kp: float, ki: float, peak: float) -> None:
    plants = Plants.of([linearise(BENCH)])
    largest = np.max(1 / np.abs(1 + (kp + ki * plants.integral) * plants.responses))
    inside = any(low <= ki <= high for low, high in open_stretches(plants, [peak], kp))
    beyond = ki > np.max(forbidden(plants, [peak], kp), initial=0.0)
    assert (largest <= peak * (1 + 1e-9)) == (inside or beyond)


CASES: dict[str, System] = {
    "bench": BENCH,
    "slider": BENCH.evolve({"finger.slip_length_um": 0.0}),
    "late": BENCH.evolve({"controller.delay_s": 7.3e-4}),
    "damped springs": BENCH.evolve({"sensor.q": 2.0}),
    "Section 2": paper(),
}


@pytest.mark.parametrize("name", CASES)
def test_no_gains_of_a_grid_are_better(name: str) -> None:
    """Brute force: every pair of gains with a larger ki is unstable or has a larger Ms, at some operating point."""
    found = retune(CASES[name])
    assert all(m.stable and m.sensitivity_peak <= 1.5 * 1.001 for m in found.margins)
    assert found.worst[1].sensitivity_peak == pytest.approx(1.5, rel=1e-3)
    frequency = np.union1d(np.geomspace(1, 2499, 300), np.linspace(100, 200, 200))
    for kp in np.linspace(0, max(3 * found.kp, 0.1), 6):
        for ki in found.ki * np.array([1.02, 1.5]):
            loops = [loop.with_gains(kp, ki) for loop in found.loops]
            peaks = [np.max(np.abs(loop.responses(frequency)["S"])) for loop in loops]
            assert max(peaks) > 1.5 or not all(loop.is_stable() for loop in loops)


def test_a_wider_band_leaves_less() -> None:
    narrow, wide = retune(BENCH), retune(operating_band(BENCH, (0.3, 0.6, 0.9), occluded=(0.0, 1.0)))
    assert wide.ki < narrow.ki
    assert len(wide.loops) == 6
    low = float(friction_force(2.5, law_at(BENCH, 1.0)))
    assert min(loop.elements.force_n for loop in wide.loops if loop.elements.occluded == 1) == pytest.approx(low)
    assert linearise(BENCH.evolve(narrow.overrides)).margins().sensitivity_peak <= 1.5 * 1.001
    assert retune(BENCH, sensitivity_peak=1.2).ki < narrow.ki < retune(BENCH, sensitivity_peak=2.0).ki


def test_other_gains_are_those_of_another_system() -> None:
    point, f = linearise(BENCH, force_n=0.5, occluded=0.3), np.array([3.0, 150.0])
    other = linearise(BENCH.evolve(RETUNED), force_n=0.5, occluded=0.3)
    moved = point.with_gains(*RETUNED.values())
    assert moved.system == other.system
    for reading in ("sampled", "held"):
        np.testing.assert_allclose(moved.responses(f, reading)["T"], other.responses(f, reading)["T"], rtol=1e-12)
    np.testing.assert_allclose(np.sort_complex(moved.poles()), np.sort_complex(other.poles()), rtol=1e-10)


def test_a_loop_in_place_of_a_system() -> None:
    loop = linearise(BENCH, force_n=0.5)
    assert retune([loop]).loops[0].elements.force_n == pytest.approx(0.5)
    assert float(amplitude_for(0.5, law_at(BENCH))) == pytest.approx(loop.elements.amplitude_um)


DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "will-it-ring.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


@pytest.fixture
def page(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(DOCS / "_tools"))
    mpl.use("Agg")
    from page import Page

    yield Page(tmp_path)
    for name in [name for name, module in sys.modules.items() if str(DOCS) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]


@pytest.mark.slow
def test_the_page_prints_what_its_text_says(page) -> None:
    shown = [page.run(language, text) for language, text in BLOCKS]
    text = "".join(printed for printed, _ in shown)
    limits = {int(q): float(kp) for q, kp in re.findall(r"Q (\d+): from kp (\S+) on", text)}
    assert [round(limits[q], 2) for q in (5, 10)] == [0.40, 0.20]
    assert "unstable: these gains ring" in text
    share, rings_kp = (
        float(re.search(said, text)[1]) for said in (r"stable with (\S+) of its gain", r"200 us: .* from kp (\S+) on")
    )
    assert 1 / share == pytest.approx(100, rel=0.1)  # "about a hundred times less"
    assert 10 * share == pytest.approx(rings_kp, rel=0.05)
    assert re.search(r"RETUNED +0.0000 +111.0 +stable", text)
    assert re.search(r"RETUNED .* 1.50 ", text)
    high, low = (re.findall(rf"^{law} .*um(.*)$", text, re.M) for law in ("limit_observer", "notch_pi"))
    assert [row.split()[2] for row in high] == ["rings"] * 2  # believed too high
    assert all(float(row.split()[1]) < 3 for row in low)


def test_the_code_of_the_page_fits() -> None:
    assert [line for _, text in BLOCKS for line in text.splitlines() if len(line) > 88] == []
