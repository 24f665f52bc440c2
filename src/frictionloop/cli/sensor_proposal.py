"""A search for a force sensor in words, and everything that is known of one as plain values for JSON."""

from __future__ import annotations

from typing import Any

from frictionloop.cli import screen
from frictionloop.cli.sensor_text import Row
from frictionloop.hardware.sensor.answers import SensorAnalysis, analyse_sensor
from frictionloop.hardware.sensor.search import Option, SensorProposal
from frictionloop.hardware.sensor.wanted import LARGEST_GAP_UM


def proposal_text(proposal: SensorProposal) -> list[Any]:
    """Return what was wanted, and the geometries that give it with other electrodes."""
    wanted = proposal.requirement
    noise = (
        f"{wanted.noise_rms_n:g} N rms"
        if wanted.noise_rms_n is not None
        else f"{wanted.noise_density_n_rthz:g} N/rtHz of the electronics"
    )
    rows: list[Row] = [("area", "gap", "gap/travel", "excitation", "largest noise under load")]
    rows += [_option_row(option, option.design is proposal.design) for option in proposal.options]
    reached = (
        f"Even the widest gap tried, {LARGEST_GAP_UM:g} um, is quieter than asked."
        if proposal.gap_is_largest
        else "The gap is the widest that meets the noise; the budget leaves no reserve."
    )
    return [
        screen.columns([("wanted", f"{wanted.resonance_hz:.4g} Hz, {wanted.range_n:g} N, {noise}")]),
        "",
        screen.table(rows),
        "* proposed",
        "",
        screen.columns(
            [
                ("trade-off", reached),
                (
                    "",
                    "A narrower gap is quieter, but harder to make and less straight. The electronics' noise in "
                    "newtons grows with the square of the resonance.",
                ),
            ]
        ),
    ]


def _option_row(option: Option, chosen: bool) -> Row:
    area = f"{option.area_mm2:g} mm2"
    if option.design is None:
        return (area, "none", "", "", "no gap is quiet enough")
    found = analyse_sensor(option.design)
    largest = found.at_range.dominant
    mark = " *" if chosen else ""
    return (
        area,
        f"{option.design.electrodes.gap_um:.4g} um",
        f"{option.design.electrodes.gap_um / found.travel_um:.3g}",
        f"{option.design.excitation.amplitude_v:.3g} V",
        f"{largest.name}, {largest.rms_n:.1e} N{mark}",
    )


def as_json(found: SensorAnalysis, proposal: SensorProposal | None) -> dict[str, Any]:
    """Return everything as plain values, forces in N, densities in N/rtHz; null what a sensor that clips has not."""
    result: dict[str, Any] = {
        "design": found.design.model_dump(),
        "stiffness": found.stiffness._asdict(),
        "capacitance_f": found.capacitance_f._asdict(),
        "clips": found.clips,
        "sensor": found.suspended,
        "not_in_sensor": None if found.omitted is None else found.omitted._asdict(),
        "block_error": None if found.clips else found.block_error._asdict(),
        "dynamic_range_db": found.dynamic_range_db,
    }
    names = (
        "resonance_hz travel_um stress_mpa amplitude_v peak_v clips_from_n nonlinearity side_density_pm_rthz delay_s"
    )
    result |= {name: getattr(found, name) for name in names.split()}
    result |= {"nonlinearity": None} if found.clips else {}
    for name, budget in (("noise_at_rest", found.at_rest), ("noise_at_range", found.at_range)):
        result[name] = {
            "force_n": budget.force_n,
            "rms_n": budget.rms_n,
            "white_density_n_rthz": budget.white_density_n_rthz,
            "dominant": budget.dominant.name,
            "terms": [term._asdict() for term in budget.terms],
        }
    if proposal is not None:
        result["wanted"] = vars(proposal.requirement)
        result["options"] = [
            {"area_mm2": option.area_mm2}
            | (
                {"gap_um": option.design.electrodes.gap_um, "amplitude_v": option.design.excitation.amplitude_v}
                if option.design
                else {"gap_um": None, "amplitude_v": None}
            )
            for option in proposal.options
        ]
    return result
