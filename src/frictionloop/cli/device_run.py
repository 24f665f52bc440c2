"""``frictionloop device run``: the loop on a device, recorded."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.device import SameAddress

ARGUMENTS = "ADDRESS [FILE] [OPTIONS]"
EXAMPLES = (
    "sim: my-controller.toml --plot forces.svg",
    "serial:///dev/ttyACM0 my-controller.toml --out run.h5",
    "tcp://bench:5555 --setpoint.offset_n 0.5 --open",
)


def command(
    address: SameAddress,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    decimation: flags.Run[flags.Whole] = 1,
    open_loop: Annotated[flags.Run[flags.Flag], Parameter(name="open")] = False,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Load a controller into a device, close the loop, play the set-point and record.

    Of a run of more than ten minutes the last ten are scored and drawn.

    Parameters
    ----------
    file
        System whose controller is loaded first, and whose set-point is played; the preset without it.
    decimation
        Ticks per sample that is recorded.
    open_loop
        Lookup table alone, nothing fed back.
    out
        Save the recording here (HDF5, .h5).
    plot
        Draw the recording here (.svg, .pdf or .png).
    """
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_count("decimation", decimation, 1, 65535)
    given = flags.system_given(file, preset, overrides, "bench")
    doubted = fl.doubts(given.system, ("setpoint",))  # the disturbance is what there is
    with fl.progress.waiting(f"running on {address}"):
        found = fl.device.run(address, given.system, duration_s, decimation=decimation, open_loop=open_loop, out=out)
    if plot is not None:
        fl.plot(found.recording, plot)
    shown.show(found.with_findings([*given.findings, *doubted]), saved={"run": out, "figure": plot})
