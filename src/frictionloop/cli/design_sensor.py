"""``frictionloop design sensor``: the force sensor, from geometry to noise and from a requirement to a geometry."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Group, Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = (
    "",
    "--electrodes.gap_um 150 --adc.bits 13",
    "--resonance-hz 145 --range-n 2.5 --noise-rms-n 5e-5 --save-design my-sensor.toml",
    "my-sensor.toml --spice my-sensor.cir",
)

Design = Annotated[flags.T, Parameter(group=Group("Design", sort_key=1))]
Wanted = Annotated[flags.T, Parameter(group=Group("Requirement, for which a geometry is searched", sort_key=2))]


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
    shown: screen.Shown = screen.BRIEFLY,
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
    file_arguments.check_output("save_design", save_design, file_arguments.SYSTEMS)
    file_arguments.check_new("save_design", save_design)
    file_arguments.check_output("spice", spice, (".cir",))
    wanted = {"resonance_hz": resonance_hz, "range_n": range_n}
    wanted |= {"noise_rms_n": noise_rms_n, "noise_density_n_rthz": noise_density_n_rthz}
    found = fl.design.sensor(file, flags.overrides_of(overrides), **wanted)
    if save_design is not None:
        fl.write_toml(found.design, save_design)
    if spice is not None:
        fl.design.write_spice(found.design, spice)
    shown.show(found, saved={"design": save_design, "netlist": spice})
