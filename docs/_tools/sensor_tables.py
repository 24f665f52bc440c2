"""Tables and numbers of the force sensor's page, computed from the built-in design when the pages are built."""

from __future__ import annotations

import math

from tables import table

from frictionloop.hardware.sensor.front_end import electrostatic_n_per_m
from frictionloop.hardware.sensor.noise_budget import noise_budget
from frictionloop.hardware.sensor.sensor_answers import SensorAnswers, sensor
from frictionloop.hardware.sensor.sensor_search import SensorRequirement, propose_sensor
from frictionloop.parameters.sensor_design import SensorDesign


def texts() -> dict[str, str]:
    """Return what the page inserts, by name."""
    return {"budget": budget(), "stiffnesses": stiffnesses(), "gaps": gaps(), "bits": bits()} | numbers()


def budget() -> str:
    """Return the noise of the built-in design at rest and at full load, and of the ratio form at full load."""
    design = SensorDesign()
    rest, loaded = noise_budget(design), noise_budget(design, design.load.range_n)
    ratio = noise_budget(design.evolve({"readout.form": "ratio"}), design.load.range_n)
    rows = []
    for one, two, three in zip(rest.terms, loaded.terms, ratio.terms, strict=True):
        density = "slow" if math.isnan(one.density_n_rthz) else f"{one.density_n_rthz * 1e6:.2g}"
        rows.append((one.name, density, *(_micro(t.rms_n) for t in (one, two, three)), f"`{one.parameter}`"))
    rows.append(("**all**", "", *(f"**{b.rms_n * 1e6:.1f}**" for b in (rest, loaded, ratio)), ""))
    header = "Source", "density (µN/√Hz)", "rms at rest (µN)", "at 2.5 N, subtraction", "at 2.5 N, ratio", "Set by"
    return table(header, rows)


def _micro(newtons: float) -> str:
    micro = newtons * 1e6
    return f"{micro:.0f}" if micro >= 100 else f"{micro:.2g}" if micro >= 0.001 else "0"


def stiffnesses() -> str:
    """Return stiffness and travel over the resonance."""
    rows = []
    for hertz in (100.0, 145.0, 200.0, 250.0):
        found = sensor(propose_sensor(SensorRequirement(hertz, 2.5, noise_rms_n=1.0)).design)
        k, thickness = found.stiffness.x_n_per_m * 1e-6, found.design.springs.thickness_mm
        rows.append((f"{hertz:g}", f"{k:.3f}", f"{thickness:.2f}", f"{found.travel_um:.1f}", f"{50 / k:.0f}"))
    return table(("Resonance (Hz)", "k (N/µm)", "leaf (mm)", "travel at 2.5 N (µm)", "5e-5 N is (pm)"), rows)


def gaps() -> str:
    """Return electronics' noise and straightness over the gap."""
    rows = []
    for gap in (50.0, 100.0, 200.0, 300.0):
        found = sensor(SensorDesign().evolve({"electrodes.gap_um": gap, "excitation.amplitude_v": 5.0}))
        density, rms = found.at_rest.white_density_n_rthz * 1e6, found.at_rest.rms_n * 1e6
        rows.append((f"{gap:g}", f"{density:.2f}", f"{rms:.0f}", f"{100 * found.nonlinearity:.2f} %"))
    return table(("Gap (µm)", "electronics (µN/√Hz)", "all noise (µN rms)", "subtraction off by"), rows)


def bits() -> str:
    """Return the noise over the converter's bits."""
    rows = []
    for count in (12, 13, 16, 18):
        found = noise_budget(SensorDesign().evolve({"adc.bits": count}))
        quantised = next(t.rms_n for t in found.terms if t.parameter == "adc.bits")
        rows.append((str(count), _micro(quantised), f"{found.rms_n * 1e6:.0f}"))
    return table(("Effective bits", "converter (µN rms)", "all noise (µN rms)"), rows)


def numbers() -> dict[str, str]:
    """Return the single numbers that the page quotes."""
    found = sensor(SensorDesign())
    return {
        "side_pm": f"{found.side_density_pm_rthz:.2f}",
        "pull_n_per_m": f"{electrostatic_n_per_m(SensorDesign()):.2f}",
        "offset_n": f"{_offset_n(found):.2f}",
        "delay_us": f"{found.delay_s * 1e6:.1f}",
        "off_gain": f"{100 * found.block_error.gain:.2f}",
        "rms_un": f"{found.at_rest.rms_n * 1e6:.0f}",
        "largest": found.at_rest.dominant.name,
    }


def _offset_n(found: SensorAnswers) -> float:
    electrodes = found.design.electrodes
    return electrodes.imbalance * found.stiffness.x_n_per_m * electrodes.gap_um * 1e-6
