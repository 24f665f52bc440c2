"""The exported netlist in ngspice: AC, noise of the linear part, and in time, beside the package's own model."""

from __future__ import annotations

import shutil
import subprocess

import numpy as np
import pytest

from frictionloop.hardware.sensor import front_end, springs
from frictionloop.hardware.sensor.front_end import capacitance_f
from frictionloop.hardware.sensor.netlist import to_spice
from frictionloop.parameters.sensor_design import SensorDesign

pytestmark = pytest.mark.skipif(
    shutil.which("ngspice") is None, reason="ngspice is not installed (apt-get install ngspice)"
)
DESIGNS = {
    "default": {},
    "slow amplifier, small Rf": {"amplifier.gain_bandwidth_mhz": 5.0, "amplifier.feedback_mohm": 0.1},
    "noisy currents, narrow filter": {"amplifier.current_noise_fa_rthz": 500.0, "filters.bandpass_q": 30.0},
    "quiet amplifier, no parasitics": {
        "amplifier.noise_nv_rthz": 0.0,
        "amplifier.current_noise_fa_rthz": 0.0,
        "amplifier.parasitic_pf": 0.0,
    },
}
SWEEP = "lin 41 80k 160k"


@pytest.fixture
def ngspice(tmp_path):
    """Return a function that runs commands on a netlist and gives the vectors that ``wrdata`` wrote."""

    def run(netlist, *commands):
        control = ["set wr_singlescale", "set wr_vecnames", "set numdgt=12", *commands, "quit 0"]
        text = netlist.replace(".end\n", "\n".join([".control", *control, ".endc", ".end\n"]))
        (tmp_path / "deck.cir").write_text(text)
        done = subprocess.run(
            ["ngspice", "-b", "deck.cir"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=100
        )
        assert done.returncode == 0, done.stdout + done.stderr
        assert "error" not in (done.stdout + done.stderr).lower()
        return np.loadtxt(tmp_path / "out.txt", skiprows=1)

    return run


@pytest.mark.parametrize("overrides", DESIGNS.values(), ids=DESIGNS)
@pytest.mark.parametrize("side", ["p", "m"])
def test_ac(ngspice, overrides, side):
    design = SensorDesign().evolve(overrides)
    found = ngspice(to_spice(design), f"ac {SWEEP}", f"wrdata out.txt v({side}_ca) v({side}_bp)")
    frequency = found[:, 0]
    electrode = capacitance_f(design)[side == "m"]
    amplified = -electrode * front_end.charge_amplifier(design, electrode).charge.response(frequency)
    np.testing.assert_allclose(found[:, 1] + 1j * found[:, 2], amplified, rtol=0.01)
    tuned = amplified * front_end.bandpass(design).response(frequency)
    np.testing.assert_allclose(found[:, 3] + 1j * found[:, 4], tuned, rtol=0.01)


def test_ac_of_the_low_pass(ngspice):
    """Its parts alone: driven at the demodulator's node."""
    design = SensorDesign()
    lines = [line for line in to_spice(design).splitlines() if line.startswith(("Rlp_p", "Clp_p", ".options", ".end"))]
    deck = "\n".join(["* low-pass", "Vin p_dem 0 AC 1", *[line for line in lines if line != ".ends"]]) + "\n"
    found = ngspice(deck, "ac dec 10 10 100k", "wrdata out.txt v(p_out)")
    np.testing.assert_allclose(
        found[:, 1] + 1j * found[:, 2], front_end.lowpass(design).response(found[:, 0]), rtol=0.01
    )


@pytest.mark.parametrize("overrides", DESIGNS.values(), ids=DESIGNS)
def test_noise_of_the_linear_part(ngspice, overrides):
    """Density at the demodulator's input, and with it the terms of the budget that arise before it."""
    design = SensorDesign().evolve(overrides)
    found = ngspice(to_spice(design), f"noise v(p_bp) Vexc {SWEEP}", "setplot noise1", "wrdata out.txt onoise_spectrum")
    frequency, amplifier = found[:, 0], design.amplifier
    blocks = front_end.charge_amplifier(design, capacitance_f(design).plus)
    tuned = np.abs(front_end.bandpass(design).response(frequency))
    ohm = amplifier.feedback_mohm * 1e6
    current = np.hypot(front_end.thermal_v_rthz(design, ohm) / ohm, amplifier.current_noise_fa_rthz * 1e-15)
    terms = [
        np.abs(blocks.voltage_noise.response(frequency)) * amplifier.noise_nv_rthz * 1e-9 * tuned,
        np.abs(blocks.current_noise.response(frequency)) * current * tuned,
        front_end.thermal_v_rthz(design, front_end.bandpass_parts(design).resistor_ohm) * tuned,
        np.full_like(frequency, design.filters.buffer_noise_nv_rthz * 1e-9),
    ]
    np.testing.assert_allclose(found[:, 1], np.sqrt(np.sum(np.square(terms), axis=0)), rtol=0.01)


@pytest.mark.parametrize("name", ["default", "slow amplifier, small Rf"])
def test_a_step_of_displacement_in_time(ngspice, name):
    """Both sides at 0.5 um, then at 1 um: the difference settles on the static curve."""
    design = SensorDesign().evolve(DESIGNS[name])
    deck = to_spice(design).replace("Vx x 0 DC 0", "Vx x 0 PULSE(0.5 1 2m 1u 1u 1 2)")
    found = ngspice(deck, "tran 0.1u 5m 0 0.1u", "wrdata out.txt v(diff) v(p_out)")
    time, diff = found[:, 0], found[:, 1]
    stiffness = springs.stiffness(design.springs).x_n_per_m
    for start, displacement in ((1.8e-3, 0.5e-6), (4.8e-3, 1e-6)):
        volts = front_end.amplitudes_v(design, stiffness * displacement)
        window = (time >= start) & (time < start + 24 / 120e3)
        assert np.mean(diff[window]) == pytest.approx(volts.plus - volts.minus, rel=0.01)


def test_a_moving_frame_in_time(ngspice):
    """A displacement of 1 um at 500 Hz: amplitude and phase of the difference beside the baseband model."""
    design = SensorDesign().evolve({"electrodes.imbalance": 0.0})
    deck = to_spice(design).replace("Vx x 0 DC 0", "Vx x 0 SIN(0 1 500)")
    found = ngspice(deck, "tran 0.1u 6m 0 0.1u", "wrdata out.txt v(diff)")
    late = found[:, 0] >= 4e-3
    time = np.arange(4e-3, 6e-3, 0.1e-6)  # one period, after 20 time constants of the low-pass
    diff = np.interp(time, found[late, 0], found[late, 1])
    measured = 2j * np.mean(diff * np.exp(-2j * np.pi * 500 * time))
    volts = sum(front_end.amplitudes_v(design)) * 1e-6 / 100e-6
    expected = volts * front_end.envelope_response(design, np.array(500.0))
    assert abs(measured / expected - 1) < 0.01
