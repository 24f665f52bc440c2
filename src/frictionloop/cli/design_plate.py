"""``frictionloop design plate``: what an ultrasonic plate does, takes and needs, from its dimensions."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from frictionloop.cli import flags, screen

if TYPE_CHECKING:
    from frictionloop.hardware.plate.answers import PlateAnswers, Wanted
    from frictionloop.hardware.plate.carrier_check import EnvelopeCheck
    from frictionloop.hardware.plate.readings import PlateReading
    from frictionloop.parameters.plate_design import PlateDesign

ARGUMENTS = "[OPTIONS]"
EXAMPLES = """Examples

  frictionloop design plate
  frictionloop design plate --frequency-hz 40000 --bandwidth-hz 150
  frictionloop design plate --geometry.thickness-mm 4
  frictionloop design plate --drive.quality-factor 500 --check-carrier
  frictionloop design plate --readings --json
"""
Plate = Annotated[flags.T, Parameter(group=Group("Plate", sort_key=1))]
Asked = Annotated[flags.T, Parameter(group=Group("Asked", sort_key=2))]

Row = tuple[str, str, str]


def command(
    *,
    overrides: Annotated[Plate[list[str] | None], Parameter(name=flags.DOTTED, metavar="VALUE")] = None,
    frequency_hz: Asked[float | None] = None,
    bandwidth_hz: Asked[float | None] = None,
    check_carrier: Asked[flags.Flag] = False,
    readings: Asked[flags.Flag] = False,
    json: flags.Json = False,
) -> None:
    """Say how a plate vibrates, what drives it, what a finger and the carrier change.

    Parameters
    ----------
    overrides
        Any parameter of the plate by its dotted name, such as --geometry.thickness-mm 4 or
        --drive.quality-factor 150. --json lists the names.
    frequency_hz
        Resonance wanted, in Hz: which mode, which thickness. All else is then of that mode, unless
        --geometry.nodal-lines names another.
    bandwidth_hz
        Envelope bandwidth wanted, in Hz: which Q.
    check_carrier
        Simulate the carrier and say how far the first-order envelope is off.
    readings
        Say which of the paper's numbers go together.
    """
    from frictionloop.hardware.plate.answers import plate_answers, plate_for
    from frictionloop.hardware.plate.readings import plate_readings
    from frictionloop.parameters.plate_design import PlateDesign
    from frictionloop.parameters.unit_sanity import unusual

    given = flags.overrides_of(overrides)
    design = PlateDesign().evolve(given)
    screen.note_findings(unusual(design))
    wanted = plate_for(design, frequency_hz, bandwidth_hz)
    if wanted.nearest is not None and "geometry.nodal_lines" not in given:
        design = design.evolve({"geometry.nodal_lines": wanted.nearest.nodal_lines})
        wanted = plate_for(design, frequency_hz, bandwidth_hz)
    answers = plate_answers(design)
    read = plate_readings(design.glass) if readings else ()
    checks = _checks(design) if check_carrier else []
    if json:
        result: dict[str, Any] = {"design": design.model_dump(), "answers": asdict(answers), "wanted": asdict(wanted)}
        result["readings"] = [asdict(each) | {"agrees": each.agrees} for each in read]
        screen.show_json(result | {"carrier": [asdict(each) for each in checks]})
        return
    parts = [
        _answer_rows(answers, design),
        _wanted_rows(wanted, design, frequency_hz),
        _reading_rows(read),
        _check_rows(checks),
    ]
    shown = [screen.columns(rows) for rows in parts if rows]
    screen.show(*[piece for part in shown for piece in ("", part)][1:])


def _checks(design: PlateDesign) -> list[EnvelopeCheck]:
    from frictionloop.hardware.plate.carrier_check import check_envelope

    with screen.waiting("simulating the carrier"):
        return [check_envelope(design, "sine", False), check_envelope(design)]


def _answer_rows(found: PlateAnswers, design: PlateDesign) -> list[Row]:
    mode, vibration, effort = found.vibration.mode, found.vibration, found.effort
    finger, wired, drive = found.finger, found.electronics, design.drive
    theories = f"thick-plate theory {_khz(vibration.mindlin_hz)}, thin-plate {_khz(vibration.thin_hz)}"
    detuning = f"{wired.ticks} ticks, {wired.detuning_hz:+.1f} Hz off: {wired.detuned_gain:.1%} of the amplitude"
    return [
        ("mode", _khz(mode.frequency_hz), theories),
        ("half wavelength", f"{mode.half_wavelength_mm:.2f} mm", f"{mode.nodal_lines} lines on {mode.side_mm:g} mm"),
        ("resonance", _khz(vibration.resonance_hz), "measured" if drive.resonance_hz else "that of the mode"),
        ("envelope", f"{vibration.bandwidth_hz:.1f} Hz", f"time constant {vibration.time_constant_s * 1e3:.3g} ms"),
        ("glass", f"{effort.plate_mass_kg * 1e3:.0f} g", f"modal mass {effort.modal_mass_kg * 1e3:.0f} g"),
        ("power", f"{effort.power_w:.1f} W", f"at {drive.max_amplitude_um:g} um, no finger"),
        ("force", f"{effort.force_n:.0f} N", f"at resonance; the patches give {effort.force_n_per_v:.2f} N/V"),
        ("voltage", f"{effort.voltage_v:.0f} V", "zero-to-peak, for full amplitude"),
        ("touched", f"{finger.amplitude_on_touch:.0%}", f"of the amplitude is left, Q {finger.quality_on_touch:.0f}"),
        ("ripple", f"{finger.felt_ripple:.0%}", f"of what a stroke feels; the plate itself {finger.plate_ripple:.1%}"),
        ("carrier", _khz(wired.carrier_hz), detuning),
        ("levels", str(wired.levels), f"at most {wired.largest_step_um * 1e3:.1f} nm apart"),
        ("band-pass", f"{wired.filter_delay_s * 1e6:.1f} us", f"of delay; gain {wired.filter_gain:.2f} at the carrier"),
    ]


def _thickness(mm: float) -> str:
    return f"{mm:.3f} mm" if mm >= 0.1 else f"{1e3 * mm:.3g} um"


def _wanted_rows(wanted: Wanted, design: PlateDesign, asked_hz: float | None) -> list[Row]:
    rows: list[Row] = []
    if wanted.nearest is not None and asked_hz:
        off = wanted.nearest.frequency_hz / asked_hz - 1
        missed = f"{100 * abs(off):.2g} % {'above' if off > 0 else 'below'} the {_khz(asked_hz)} asked for"
        lines = f"{wanted.nearest.nodal_lines} lines"
        rows.append(("nearest mode", lines, f"{_khz(wanted.nearest.frequency_hz)} on this plate, {missed}"))
        lines = f"gives {design.geometry.nodal_lines} lines that frequency"
        rows.append(("thickness", _thickness(wanted.thickness_mm), lines))
    if wanted.quality_factor == wanted.quality_factor:
        rows.append(("Q", f"{wanted.quality_factor:.0f}", "gives the bandwidth"))
    return rows


def _reading_rows(readings: tuple[PlateReading, ...]) -> list[Row]:
    return [
        (
            f"along {each.wave_along}",
            f"{each.mode.nodal_lines} lines, {each.mode.thickness_mm:.2f} mm, {_khz(each.mode.frequency_hz)}",
            f"as printed: {', '.join(each.agrees)}",
        )
        for each in readings
    ]


def _check_rows(checks: list[EnvelopeCheck]) -> list[Row]:
    return [
        (
            f"{each.source}{' + band-pass' if each.filtered else ''}",
            f"{each.largest:.2%}",
            f"off the first-order envelope (theory allows {each.allowed:.2%}); {each.undelayed:.2%} without the delay",
        )
        for each in checks
    ]


def _khz(frequency_hz: float) -> str:
    return f"{frequency_hz / 1e3:.2f} kHz"
