"""``frictionloop design sensor``: the force sensor, from geometry to noise and from a requirement to a geometry."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Group, Parameter

from frictionloop.cli import checks, flags, screen

if TYPE_CHECKING:
    from frictionloop.hardware.sensor.search import SensorProposal
    from frictionloop.parameters.sensor_design import SensorDesign

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop design sensor
  frictionloop design sensor --electrodes.gap_um 150 --adc.bits 13
  frictionloop design sensor --resonance-hz 145 --range-n 2.5 \
      --noise-rms-n 5e-5 --save-design my-sensor.toml
  frictionloop design sensor my-sensor.toml --spice my-sensor.cir
"""

Design = Annotated[flags.T, Parameter(group=Group("Design", sort_key=1))]
Wanted = Annotated[flags.T, Parameter(group=Group("Requirement: the geometry is searched if any is given", sort_key=2))]
PAPER_NOISE_N = 5e-5
"""Noise that is asked for if a requirement names none (paper, Sec. 3.1)."""


def command(
    file: Annotated[Design[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    overrides: Annotated[Design[list[str] | None], Parameter(name=flags.DOTTED, metavar="VALUE")] = None,
    resonance_hz: Wanted[float | None] = None,
    range_n: Wanted[float | None] = None,
    noise_rms_n: Wanted[float | None] = None,
    noise_density_n_rthz: Wanted[float | None] = None,
    save_design: flags.Result[Path | None] = None,
    spice: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Size the force sensor: springs, electrodes and electronics to resonance, range and noise, or back.

    Parameters
    ----------
    file
        TOML file with what differs from the built-in design.
    overrides
        Any parameter of the design by its dotted name, such as --electrodes.gap_um 150 or --springs.kind
        straight. --save-design lists the names.
    resonance_hz
        First resonance in Hz; that of the design if not given.
    range_n
        Largest force in N; that of the design if not given.
    noise_rms_n
        Noise of the output at rest in N rms; 5e-5 if not given.
    noise_density_n_rthz
        Instead: noise density of the electronics in N/rtHz.
    save_design
        Write the design here (.toml): a start for your own.
    spice
        Write the analog chain here as a netlist for ngspice (.cir).
    """
    checks.check_output("save_design", save_design, checks.SYSTEMS)
    checks.check_new("save_design", save_design)
    checks.check_output("spice", spice, (".cir",))
    wanted = {
        "resonance_hz": resonance_hz,
        "range_n": range_n,
        "noise_rms_n": noise_rms_n,
        "noise_density_n_rthz": noise_density_n_rthz,
    }
    design = _design_from(file, overrides)
    proposal = None
    if any(value is not None for value in wanted.values()):
        proposal = _search(design, wanted)
        design = proposal.design

    from frictionloop.cli import sensor_proposal, sensor_text
    from frictionloop.hardware.sensor.answers import analyse_sensor

    analysis = analyse_sensor(design)
    saved = _save(design, {"design": save_design, "netlist": spice})
    if json:
        screen.show_json(sensor_proposal.as_json(analysis, proposal) | {"saved": saved})
        return
    origin = flags.changed(str(file) if file else "the built-in design", flags.overrides_of(overrides))
    screen.show(
        screen.columns([("design", origin)]),
        *([] if proposal is None else sensor_proposal.proposal_text(proposal)),
        *sensor_text.analysis_text(analysis),
        *screen.saved(saved),
    )


def _design_from(file: Path | None, overrides: list[str] | None) -> SensorDesign:
    from frictionloop.parameters.files import read_design
    from frictionloop.parameters.sensor_design import SensorDesign
    from frictionloop.parameters.unit_sanity import unusual

    base = SensorDesign() if file is None else read_design(file, SensorDesign())
    design = base.evolve(flags.overrides_of(overrides))
    screen.note_findings(unusual(design))
    return design


def _search(design: SensorDesign, wanted: dict[str, float | None]) -> SensorProposal:
    from frictionloop.hardware.sensor.search import propose_sensor
    from frictionloop.hardware.sensor.springs import resonance_hz
    from frictionloop.hardware.sensor.wanted import SensorRequirement

    if wanted["noise_rms_n"] is None and wanted["noise_density_n_rthz"] is None:
        wanted = wanted | {"noise_rms_n": PAPER_NOISE_N}
    given: dict[str, Any] = {"resonance_hz": resonance_hz(design), "range_n": design.load.range_n}
    return propose_sensor(
        SensorRequirement(**given | {name: value for name, value in wanted.items() if value is not None}), design
    )


def _save(design: SensorDesign, paths: dict[str, Path | None]) -> dict[str, Path | None]:
    if (path := paths["design"]) is not None:
        from frictionloop.parameters import write_toml

        write_toml(design, path)
    if (path := paths["netlist"]) is not None:
        from frictionloop.hardware.sensor.netlist import to_spice
        from frictionloop.quantities import replacing

        with replacing(path) as beside:
            beside.write_text(to_spice(design), encoding="utf-8")
    return paths
