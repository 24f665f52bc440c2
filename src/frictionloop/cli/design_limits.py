"""``frictionloop design limits``: which part of a bench limits its controller."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.must_hold import ASKED, MustHold

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = (
    "my-bench.toml",
    "my-bench.toml --law limit_observer --plot limits.svg",
)
AS_USUAL = MustHold()


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    law: Annotated[str | None, Parameter(group=ASKED)] = None,
    must: MustHold = AS_USUAL,
    plot: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Find a controller for a bench with one part changed at a time: what each would leave.

    Parameters
    ----------
    law
        Control law, as of design controller.
    plot
        Write bars of what is left here (.svg, .pdf or .png).
    """
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    given = flags.system_given(file, preset, overrides, "bench", designed=law or "notch_pi")
    with fl.progress.waiting("designing benches with one part changed"):
        found = fl.design.limits(given.system, law, must.requirements(file))
    if plot is not None:
        file_arguments.write_figure(plot, found.plot())
    shown.show(found.with_findings(given.findings), saved={"figure": plot})
