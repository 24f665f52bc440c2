"""``frictionloop firmware``: a bench as the parameter table of the microcontroller, and as an image to be flashed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb

Out = Annotated[Path, Parameter(help="Folder for the files; made if it is missing.", group=flags.RESULT)]


@verb("export [FILE] --out FOLDER [OPTIONS]", "--preset bench --out my-table", "my-controller.toml --out my-table")
def export(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    out: Out,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write the parameter table of a system: as words for the device, as numbers with units, and the system itself."""
    file_arguments.check_folder("out", out)
    given = flags.system_given(file, preset, overrides, "bench")
    found = fl.firmware.export(given.system, out)
    shown.show(found.with_findings(given.findings), saved={"table": out})


@verb("build [FILE] --out FOLDER [OPTIONS]", "--preset bench --controller.kind notch_pi --out my-image")
def build(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    board: flags.Run[str] = "teensy41",
    out: Out,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Build the image that runs a system's controller: .elf, .hex (to be flashed), .map; with the table beside it.

    Parameters
    ----------
    board
        teensy41, teensy41-ads8688 (another converter); mps2, mps2-scenario for qemu-system-arm.
    """
    file_arguments.check_folder("out", out)
    given = flags.system_given(file, preset, overrides, "bench")
    with fl.progress.waiting(f"building {board}"):
        found = fl.firmware.build(given.system, out, board, trace=fl.device.instructions)
    shown.show(found.with_findings(given.findings), saved={"image and table": out})


@verb(
    "law [FILE] --out law.c [OPTIONS]",
    "my-controller.toml --out law.c",
    "my-bench.toml --use my_law.py --controller.kind leaky_pi --out law.c",
)
def law(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    out: Annotated[Path, Parameter(help="File of C to write.", group=flags.RESULT)],
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write a system's control law as C99 for a board of your own: gains, inverse, overdrive and a bit test in it."""
    file_arguments.check_output("out", out, (".c",))
    given = flags.system_given(file, preset, overrides, "bench")
    found = fl.firmware.law(given.system, out)
    shown.show(found.with_findings(given.findings), saved={"law": out})
