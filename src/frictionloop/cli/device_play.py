"""``frictionloop device play``: an effect on a device, recorded; and the tables that it is given."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.device import SameAddress
from frictionloop.cli.effect import LAW, Name

ARGUMENTS = "ADDRESS EFFECT [FILE] [OPTIONS]"
EXAMPLES = (
    "sim: bump --plot forces.svg",
    "serial:///dev/ttyACM0 my-effect.toml my-bench.toml --out run.h5",
    "sim: button --duration-s 2 --tables button.json",
)


def command(
    address: SameAddress,
    effect: Name,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    open_loop: Annotated[flags.Run[flags.Flag], Parameter(name="open")] = False,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    tables: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Load a controller and an effect into a device, close the loop and record what it measures.

    Parameters
    ----------
    file
        System whose controller is loaded first; the bench with a notch PI without it.
    open_loop
        Lookup table alone, nothing fed back.
    out
        Save the recording here (HDF5, .h5).
    plot
        Draw the recording here (.svg, .pdf or .png).
    tables
        Write what the device is given of the effect here (.json): steps, values, and the words themselves.
    """
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_output("tables", tables, (".json",))
    wanted = flags.overrides_of(overrides)
    own = file is None and preset in (None, "bench") and not any(name.startswith("controller.") for name in wanted)
    named = ["setpoint.kind=effect", f"setpoint.effect={effect}"]
    given = flags.system_given(file, preset, [*(overrides or []), *named], "bench")
    system = given.system.evolve(LAW) if own else given.system
    with fl.progress.waiting(f"playing {effect} on {address}"):
        found = fl.device.play(address, system, duration_s, open_loop=open_loop, out=out)
    if tables is not None:
        found.write_tables(tables)
    if plot is not None:
        fl.plot(found.recording, plot)
    shown.show(found.with_findings(given.findings), saved={"run": out, "figure": plot, "tables": tables})
