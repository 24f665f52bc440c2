"""A force sensor in words: what it does, where its noise comes from, and what was traded for what."""

from __future__ import annotations

import math
from typing import Any

from frictionloop.cli import screen
from frictionloop.hardware.sensor.answers import BLOCK_TO_HZ, SensorAnalysis, omitted, suspended_values
from frictionloop.hardware.sensor.noise_budget import PAPER_FLOOR_N, Budget

Row = tuple[str, ...]
SHOWN = 0.01
"""What load adds is said if it is more than this share of all noise at rest."""
WITHHELD = "no range, no verdict and no [sensor] block: an amplifier clips within the range (signal, above)"


def analysis_text(found: SensorAnalysis) -> list[Any]:
    """Return everything about one design, part by part."""
    return [
        "",
        screen.columns([("mechanics", ""), *_mechanics(found)]),
        "",
        screen.columns([("electronics", ""), *_electronics(found)]),
        "",
        screen.table(_budget_rows(found)),
        "* largest at rest" + (", all as if nothing clipped" if found.clips else ""),
        *([] if found.clips else _advice(found.at_rest, found.at_range)),
        "",
        *([WITHHELD] if found.clips else [screen.columns(_comparison(found)), "", *_block_text(found)]),
    ]


def _mechanics(found: SensorAnalysis) -> list[Row]:
    design, (x, y) = found.design, found.stiffness
    leaves = design.springs
    shape = f"arc of {leaves.angle_deg:g} deg" if leaves.kind == "arc" else "straight"
    size = f"radius {leaves.radius_mm:.4g} mm" if leaves.kind == "arc" else f"length {leaves.length_mm:.4g} mm"
    return [
        ("  springs", f"{leaves.count} x {shape}, {size}, {leaves.width_mm:.4g} mm x {leaves.thickness_mm:.4g} mm"),
        ("  stiffness", f"{x * 1e-6:.4g} N/um along x, {y * 1e-6:.4g} N/um along y"),
        ("  resonance", f"{found.resonance_hz:.4g} Hz with {design.moving.mass_kg:g} kg, Q {design.moving.q:g}"),
        ("  travel", f"{found.travel_um:.4g} um at {design.load.range_n:g} N"),
        ("  stress", f"{found.stress_mpa:.3g} MPa there; the springs yield at {design.springs.yield_mpa:g} MPa"),
    ]


def _electronics(found: SensorAnalysis) -> list[Row]:
    design = found.design
    delay_us = found.delay_s * 1e6
    form, range_n, missed = design.readout.form, design.load.range_n, found.block_error
    electrodes = design.electrodes
    if found.clips_from_n is None:
        peak = f"at most {found.peak_v:.3g} V of {design.amplifier.swing_v:g} V within the range"
    elif found.clips_from_n == 0:
        peak = f"CLIPS at rest: {found.peak_v:.3g} V of {design.amplifier.swing_v:g} V; lower excitation.amplitude_v"
    else:
        peak = f"CLIPS from {found.clips_from_n:.3g} N, {found.peak_v:.3g} V of {design.amplifier.swing_v:g} V at "
        peak += f"{range_n:g} N; lower excitation.amplitude_v"
    straight = (
        f"reads {100 * found.nonlinearity:.2g} % high at {range_n:g} N" if found.nonlinearity > 1e-6 else "straight"
    )
    delay = f"{delay_us:.1f} us of the band-pass"
    if found.clips:
        straight = "falls behind the force where an amplifier clips"
    else:
        delay += (
            f": add it to controller.delay_s, and the block below is within {100 * missed.gain:.1g} % and "
            f"{missed.phase_deg:.1g} deg to {BLOCK_TO_HZ:g} Hz"
        )
    return [
        ("  electrodes", f"{electrodes.area_mm2:.4g} mm2, gap {electrodes.gap_um:.4g} um"),
        ("  capacitance", f"{sum(found.capacitance_f) / 2 * 1e12:.3g} pF per side"),
        ("  excitation", f"{design.excitation.amplitude_v:.3g} V at {design.excitation.frequency_hz * 1e-3:g} kHz"),
        ("  signal", f"{found.amplitude_v:.3g} V per side at rest, {peak}"),
        ("  readout", f"{form}: {straight}"),
        ("  delay", delay),
    ]


def _budget_rows(found: SensorAnalysis) -> list[Row]:
    rest, loaded = found.at_rest, found.at_range
    rows: list[Row] = [("noise", "N/rtHz", "N rms", f"at {loaded.force_n:g} N", "set by")]
    for term, there in zip(rest.terms, loaded.terms, strict=True):
        density = "slow" if math.isnan(term.density_n_rthz) else f"{term.density_n_rthz:.1e}"
        marks = " *" if term is rest.dominant else ""
        rows.append((term.name, density, f"{term.rms_n:.1e}", f"{there.rms_n:.1e}", term.parameter + marks))
    rows.append(("all", "", f"{rest.rms_n:.1e}", f"{loaded.rms_n:.1e}", ""))
    return rows


def _advice(rest: Budget, loaded: Budget) -> list[str]:
    if loaded.rms_n > 1.5 * rest.rms_n and loaded.dominant.name.startswith("excitation"):
        return [f'at {loaded.force_n:g} N the excitation\'s noise is largest; readout.form = "ratio" removes it']
    return []


def _comparison(found: SensorAnalysis) -> list[Row]:
    rms_n, stiffness = found.at_rest.rms_n, found.stiffness.x_n_per_m
    side = found.side_density_pm_rthz
    own_n = math.hypot(*(t.rms_n for t in found.at_rest.terms if t.white and not t.name.startswith("excitation")))
    floor_pm = PAPER_FLOOR_N / stiffness * 1e12
    met = rms_n <= PAPER_FLOOR_N * (1 + 1e-6)  # a search ends on the requirement itself
    return [
        ("range", f"{found.dynamic_range_db:.1f} dB from {rms_n:.2g} N to {found.design.load.range_n:g} N"),
        (
            "paper's 5e-5 N",
            f"{'met' if met else 'not met'}: all noise at rest is {rms_n:.2g} N rms",
        ),
        (
            "paper's 0.5 pm",
            f"right only as a density: amplifier and filters have {side:.2g} pm/rtHz per side, both sides together "
            f"{own_n / stiffness * 1e12:.3g} pm rms; 5e-5 N are {floor_pm:.3g} pm on these springs",
        ),
    ]


def _block_text(found: SensorAnalysis) -> list[Any]:
    """Return the block below the line that says what is not in it."""
    return [
        screen.columns([("not in the block", _left_out(found))]),
        "",
        "the sensor in the loop, as a block of a system's TOML file:",
        _block_toml(found),
    ]


def _block_toml(found: SensorAnalysis) -> str:
    """Return the loop's ``sensor`` block as TOML."""
    import tomlkit

    values = suspended_values(found.design).items()
    short = {name: float(f"{value:.6g}") if isinstance(value, float) else value for name, value in values}
    return tomlkit.dumps({"sensor": short}).rstrip()


def _left_out(found: SensorAnalysis) -> str:
    missing, rest, loaded = omitted(found.at_rest, found.at_range), found.at_rest, found.at_range
    terms = sorted(missing.at_rest_n.items(), key=lambda item: -item[1])
    forces = ", ".join(f"{name}{'*' if name == rest.dominant.name else ''} {rms_n:.1e}" for name, rms_n in terms)
    said = f"{forces}: together {missing.rest_rms_n:.1e} of all {rest.rms_n:.1e} N rms at rest"
    if missing.under_load_n > SHOWN * rest.rms_n:
        name = max((term for term in loaded.terms if term.white), key=lambda term: term.rms_n).name
        largest = ", the largest there" if name == loaded.dominant.name else ""
        said += f"; under {missing.force_n:g} N also {name} {missing.under_load_n:.1e} N rms{largest}"
    return f"{said}. The block has the electronics' noise at rest, and through adc_bits the converter's."
