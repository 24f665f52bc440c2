"""The plate at carrier level: against SciPy, and against the first-order envelope within what theory allows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, freqs_zpk, lsim, step, zpk2ss

import frictionloop as fl
from frictionloop.hardware.plate.carrier_simulation import (
    _filter_spread_s,
    actual_carrier_hz,
    allowed_error,
    amplitude_step,
    band_pass,
    check_envelope,
    duty_for,
    first_order_um,
    period_ticks,
    plate_resonator,
    pulse_ticks,
    pulses,
    share_of,
    simulate_carrier,
)
from frictionloop.hardware.plate.drive_requirements import detuned_gain, envelope, envelope_pole, time_constant_s
from frictionloop.parameters.plate_design import Carrier, PlateDesign
from frictionloop.physics.plate import pulse_step

TIMER_HZ = 36e6
TUNED_HZ = TIMER_HZ / 783


def design(**changes):
    tree = {"drive.resonance_hz": TUNED_HZ} | {name.replace("__", "."): value for name, value in changes.items()}
    return PlateDesign().evolve(tree)


@pytest.mark.parametrize("order", [1, 2, 3])
def test_band_pass_against_scipy(order):
    carrier = Carrier(filter_order=order)
    band, f = band_pass(carrier), np.geomspace(1e3, 1e6, 50)
    expected = freqs_zpk(*butter(order, [2 * np.pi * 10e3, 2 * np.pi * 50e3], "bandpass", True, "zpk"), 2 * np.pi * f)[
        1
    ]
    np.testing.assert_allclose(band.response(f), expected, rtol=1e-12)
    s = 2j * np.pi * f[:, None]
    np.testing.assert_allclose(np.sum(band.residues() / (s - band.poles), axis=1), expected, rtol=1e-9)
    # Central difference of the phase: third derivative times (2 pi 1 Hz)^2/6, and rounding 1e-16/(4 pi) per Hz.
    phase = np.angle(band.response(f + 1) / band.response(f - 1))
    np.testing.assert_allclose(band.group_delay_s(f), -phase / (4 * np.pi), rtol=1e-6, atol=1e-13)
    edges = np.abs(band.response(np.array([10e3, 50e3])))
    np.testing.assert_allclose(edges, math.sqrt(0.5), rtol=1e-12)  # Butterworth: half the power at its edges


@pytest.mark.parametrize("alignment", ["centre", "edge"])
@pytest.mark.parametrize("filtered", [False, True])
def test_displacement_against_scipy(filtered, alignment):
    """The same pulses through SciPy's lsim, which holds its input over a step too, in state space."""
    plate = design(carrier__alignment=alignment, carrier__control_hz=2 * TUNED_HZ / 9, drive__quality_factor=40.0)
    run = simulate_carrier(plate, np.array([2.5, 0.6]), filtered=filtered)
    assert run.envelope_um.size == 9
    held = np.where(np.arange(9) < 4.5, 2.5, 0.6)
    np.testing.assert_array_equal(run.command_um, held)
    drive = np.pi / 2 * pulses(pulse_ticks(held / 2.5, 783), 783, alignment).ravel()
    whole, scale = plate_resonator(TUNED_HZ, 40.0), 2.5
    if filtered:
        band = band_pass(plate.carrier)
        whole, scale = band.then(whole), 2.5 / abs(band.response(TUNED_HZ))
    unit = 2 * np.pi * TUNED_HZ  # of time, so that the numbers of the state space are near 1
    degree = len(whole.poles) - len(whole.zeros)
    system = zpk2ss(whole.zeros / unit, whole.poles / unit, scale * whole.gain / unit**degree)
    x = lsim(system, drive, np.arange(drive.size) / TIMER_HZ * unit, interp=False)[1].reshape(9, 783)
    np.testing.assert_allclose(run.waveform_um, x[-1], rtol=0, atol=1e-9)
    ticks = np.arange(783)
    found = 2 * np.mean(x * np.exp(-2j * np.pi * ticks / 783), axis=1)
    np.testing.assert_allclose(run.envelope_um, found, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.time_s, (np.arange(9) + ticks.mean() / 783) / TUNED_HZ, rtol=1e-12)


@pytest.mark.parametrize("quality", [30.0, 230.0, 500.0])
@pytest.mark.parametrize("source, filtered", [("sine", False), ("sine", True), ("pwm", False), ("pwm", True)])
def test_the_first_order_envelope_is_as_good_as_theory_says(source, filtered, quality):
    """1/Q, pulses (pi/4 + 3/4)/Q + pi/(2C), spread of the band-pass over T: see carrier_check."""
    plate = design(drive__quality_factor=quality)
    found = check_envelope(plate, source, filtered)
    constant = time_constant_s(TUNED_HZ, quality)
    assert found.allowed == allowed_error(plate, source, filtered)
    allowed = 1 / quality
    allowed += ((math.pi + 3) / 4 / quality + math.pi / (2 * 783)) * (source == "pwm")
    allowed += _filter_spread_s(plate, TUNED_HZ) / constant * filtered
    assert found.allowed == pytest.approx(allowed, rel=1e-12)
    assert found.rms <= found.largest <= found.allowed
    # A model without the delay is late by no more than that: the envelope moves by at most dt/T.
    assert found.undelayed <= found.allowed + found.delay_s / constant
    assert (found.delay_s > 0) == filtered


def test_the_error_falls_as_one_over_q():
    """Without pulses everything that is left goes as 1/Q, but for a few times 1/Q of itself."""
    low, high = (check_envelope(design(drive__quality_factor=q), "sine", True).largest for q in (50.0, 500.0))
    assert low / high == pytest.approx(10.0, rel=5 / 50.0)


def test_spread_of_the_band_pass_against_scipy():
    """The envelope of the filter's answer to a step of the carrier, here from SciPy's step of the shifted filter."""
    plate, band = design(), band_pass(Carrier())
    time = np.linspace(0.0, 4e-4, 20001)
    shift = 2j * np.pi * TUNED_HZ
    # Real system for Re: step response of sum c/(s - (p - j w)) needs complex numbers, which lsim does not take.
    weights = band.residues() / band.response(TUNED_HZ)
    complex_step = sum(w * _first_order_step(p - shift, time) for w, p in zip(weights, band.poles, strict=True))
    delay = float(band.group_delay_s(TUNED_HZ))
    spread = np.trapezoid(np.abs(complex_step - (time >= delay)), time)
    assert _filter_spread_s(plate, TUNED_HZ) == pytest.approx(spread, rel=1e-3)
    # Its mean delay is the group delay: the integral of 1 - Re s is -Re d ln H/ds.
    assert np.trapezoid(1 - complex_step.real, time) == pytest.approx(delay, rel=1e-4)


def _first_order_step(pole, time):
    """Step response of 1/(s - pole), by a real two-state system for the complex pole."""
    a = np.array([[pole.real, -pole.imag], [pole.imag, pole.real]])
    b = np.array([[1.0], [0.0]])
    parts = [step((a, b, np.array([row]), np.zeros((1, 1))), T=time)[1] for row in ([1.0, 0.0], [0.0, 1.0])]
    return parts[0] + 1j * parts[1]


def test_what_quantisation_leaves_in_the_end():
    """Settled, the amplitude is that of the pulses' whole width, to e^-14."""
    plate = design(drive__quality_factor=100.0)
    share, settle_s = 0.3, 14 * time_constant_s(TUNED_HZ, 100.0)
    run = simulate_carrier(plate, np.full(math.ceil(settle_s * 5000), share * 2.5), filtered=False)
    level = float(share_of(pulse_ticks(share, 783), 783))
    # Correlating the 783 ticks of a held drive: sinc(1/783) = 1 - 2.7e-6, and the resonance's pole is off by 1/(8 Q^2).
    assert abs(run.envelope_um[-1]) / 2.5 == pytest.approx(level, abs=1e-5)
    assert abs(level - share) <= math.pi / (2 * 783)


def test_settled_ripple_on_the_waveform_is_that_of_the_harmonics():
    """A harmonic n of the drive moves the plate by 1/(Q sqrt((n^2 - 1)^2 + (n/Q)^2)); a constant by 1/Q."""
    quality, share = 100.0, 0.5
    plate = design(drive__quality_factor=quality)
    run = simulate_carrier(plate, np.full(80, share * 2.5), filtered=False)
    spectrum = 2 * np.abs(np.fft.fft(run.waveform_um / 2.5)) / 783
    duty = int(pulse_ticks(share, 783)) / 783
    for n in range(2, 6):
        drive = abs(math.sin(n * math.pi * duty)) / n
        exact = drive * abs(plate_resonator(TUNED_HZ, quality).response(n * TUNED_HZ))
        # Sampling the pulses by ticks folds harmonics 783 - n and beyond: below n/783^2 of the fundamental's.
        assert spectrum[n] == pytest.approx(exact, abs=2e-5)
        assert exact <= drive / (quality * (n * n - 1))
    assert spectrum[0] / 2 == pytest.approx(math.pi / 2 * duty / quality, rel=1e-4)


@pytest.mark.parametrize("offset_hz", [-150.0, 60.0])
def test_a_detuned_drive_beats_as_the_second_order_envelope_says(offset_hz):
    plate = PlateDesign().evolve({"drive.resonance_hz": TUNED_HZ + offset_hz, "drive.detuning_hz": -offset_hz})
    assert actual_carrier_hz(plate) == pytest.approx(TUNED_HZ, rel=1e-12)
    run = simulate_carrier(plate, np.full(60, 2.0), "sine", filtered=False)
    pole = envelope_pole(TUNED_HZ + offset_hz, 230.0, -offset_hz)
    fine = envelope(np.full(2 * run.time_s.size, 2.0), 0.5 / TUNED_HZ, pole)[1::2]  # at the middle of each period
    # 1/Q as for the tuned plate, and the drive's resonance is off by df/f0 in size; half a tick of time is 1e-5.
    np.testing.assert_allclose(np.abs(run.envelope_um), np.abs(fine), rtol=0, atol=2.0 * (1 / 230 + 150 / 46e3))
    assert np.abs(run.envelope_um[-1]) == pytest.approx(2.0 * detuned_gain(TUNED_HZ, 230.0, offset_hz), rel=0.01)
    assert np.abs(run.envelope_um).max() > np.abs(run.envelope_um[-1]) * (1.05 if abs(offset_hz) > 100 else 1.0)


def test_pulses_that_grow_from_one_edge_dip_when_they_change():
    """Their phase moves with the duty, so the envelope takes the chord; the complex model says how deep."""
    quality = 230.0
    command = np.repeat([2.5, 1.0], 80)
    runs = {a: simulate_carrier(design(carrier__alignment=a), command, filtered=False) for a in ("centre", "edge")}
    held = runs["edge"].command_um
    duty = duty_for(held / 2.5)
    turned = held * np.exp(-1j * np.pi * duty)
    model = envelope(np.repeat(turned, 2), 0.5 / TUNED_HZ, envelope_pole(TUNED_HZ, quality))[1::2]
    bound = 2.5 * allowed_error(design(), "pwm", False)
    np.testing.assert_allclose(np.abs(runs["edge"].envelope_um), np.abs(model), rtol=0, atol=bound)
    straight = first_order_um(runs["edge"], design())
    assert np.max(np.abs(np.abs(runs["centre"].envelope_um) - straight)) <= bound
    assert np.max(np.abs(np.abs(runs["edge"].envelope_um) - straight)) > 5 * bound


def test_commands_are_limited_and_wait_for_the_next_period():
    run = simulate_carrier(design(), np.array([-1.0, 9.0, 0.5]), "sine")
    period = 1 / run.carrier_hz
    starts = np.arange(run.command_um.size) * period
    np.testing.assert_array_equal(run.command_um, np.array([0.0, 2.5, 0.5])[np.floor(starts * 5000).astype(int)])
    assert np.all(run.envelope_um[starts < 2e-4] == 0)


def test_a_long_run_is_the_same_in_pieces():
    """More carrier periods than are computed at once: a shorter run is the start of a longer one."""
    command = 2.5 * np.abs(np.sin(np.arange(120)))
    long, short = simulate_carrier(design(), command), simulate_carrier(design(), command[:20])
    np.testing.assert_array_equal(long.envelope_um[: short.envelope_um.size], short.envelope_um)


# Pulses of whole ticks: their spectrum, how fine they are, how they are placed.


def test_391_levels_at_46_khz_from_36_mhz():
    ticks = period_ticks(36e6, 46e3)
    assert ticks == 783
    levels = share_of(np.arange(392), ticks)
    assert np.all(np.diff(levels) > 0)
    # An odd number of ticks misses half duty by half a tick: 1 - cos(pi/1566) = 2e-6.
    assert levels[-1] == pytest.approx(math.cos(math.pi / 1566), rel=1e-14)


def harmonic(order, duty):
    """The n-th harmonic of pulses over the fundamental at half duty."""
    return abs(math.sin(order * math.pi * duty)) / order


@given(st.integers(4, 2000), st.floats(0, 1), st.sampled_from(["centre", "edge"]))
def test_the_fundamental_and_harmonics_of_a_period(ticks, share, alignment):
    """A Fourier transform of the ticks against the series of a rectangular pulse."""
    width = int(pulse_ticks(share, ticks))
    level = pulses(np.array([width]), ticks, alignment)[0]
    assert level.sum() == width
    spectrum = np.fft.fft(level) / ticks
    for n in range(1, min(6, ticks // 2)):
        # Ticks are boxes: the series is the transform times sinc(n/ticks), half a tick late.
        series = 2 * abs(spectrum[n]) * np.sinc(n / ticks) * math.pi / 2
        assert series == pytest.approx(harmonic(n, width / ticks), abs=1e-12)
    assert harmonic(1, width / ticks) == pytest.approx(share_of(width, ticks), abs=1e-12)
    if width:
        box = np.exp(-1j * np.pi / ticks)  # from the start of a tick to its middle
        middle = -1.0 if alignment == "centre" else 1.0
        turn = -math.pi * width / ticks if alignment == "edge" else 0.0
        turned = np.angle(spectrum[1] * box * middle * np.exp(-1j * turn))
        assert abs(turned) <= math.pi / ticks + 1e-9  # a pulse is centred to half a tick


@given(st.floats(0, 1), st.integers(4, 5000))
def test_amplitude_through_the_arcsine(share, ticks):
    duty = float(duty_for(share))
    assert 0 <= duty <= 0.5
    assert math.sin(math.pi * duty) == pytest.approx(share, abs=1e-15)
    width = int(pulse_ticks(share, ticks))
    assert width <= ticks // 2
    # Half a tick of the width, or the half tick by which an odd period misses half duty.
    assert abs(float(share_of(width, ticks)) - share) <= math.pi / (2 * ticks) + 1e-15


@given(st.floats(0, 1), st.integers(8, 5000))
def test_steps_are_finest_near_full_amplitude(share, ticks):
    step = amplitude_step(share, ticks)
    width = min(int(duty_for(share) * ticks), ticks // 2 - 1)
    assert step == pytest.approx(float(share_of(width + 1, ticks) - share_of(width, ticks)), rel=1e-14)
    assert 0 < step <= math.pi / ticks
    assert step <= amplitude_step(0.0, ticks)


def test_shares_outside_are_cut():
    np.testing.assert_array_equal(pulse_ticks(np.array([-0.5, 0.0, 1.0, 2.0]), 100), [0, 0, 50, 50])


# Amplitudes that pulses of whole clock ticks can give, alone and in the loop.


@given(st.floats(-1.0, 5.0), st.floats(0.1, 5.0), st.integers(4, 2000))
def test_it_is_the_carrier_with_the_nearest_pulse(command, largest, ticks):
    """The carrier's own formulas, which the plate's spectra are made with, say the same."""
    got = pulse_step(command, largest, float(ticks))
    width = round(float(np.arcsin(min(got / largest, 1.0))) / np.pi * ticks)
    assert got == pytest.approx(largest * float(share_of(width, ticks)), abs=1e-12 * largest)
    wanted = float(duty_for(command / largest)) * ticks
    assert abs(wanted - width) <= 0.5 + 1e-6 or width == ticks // 2
    assert width in (int(pulse_ticks(command / largest, ticks)), round(wanted - 1e-9), round(wanted + 1e-9))


@given(st.integers(0, 391))
def test_what_pulses_can_give_stays(width):
    a = 2.5 * np.sin(np.pi * width / 783)
    assert pulse_step(a, 2.5, 783.0) == pytest.approx(a, abs=1e-12)


def test_a_run_has_only_the_amplitudes_of_its_pulses():
    """A plate that is quick beside the period is at its command: of 8 ticks, at one of 5 amplitudes."""
    quick = fl.paper().evolve({"plate.cutoff_hz": 2e4, "plate.pulse_ticks": 8})
    run = fl.simulate(quick, duration_s=0.5)
    levels = 2.5 * np.sin(np.pi * np.arange(5) / 8)
    off = np.min(np.abs(run.a.to_numpy()[:, None] - levels), axis=1)
    assert np.median(off) < 1e-6 and len(np.unique(np.round(run.a.to_numpy(), 5))) < 60


def test_more_ticks_than_the_loop_can_tell_change_nothing():
    system = fl.feasible()
    fine = fl.simulate(system.evolve({"plate.pulse_ticks": 65536}), duration_s=1.0)
    whole = fl.simulate(system, duration_s=1.0)
    assert float(np.abs(fine.f_a - whole.f_a).max()) < 1e-3
