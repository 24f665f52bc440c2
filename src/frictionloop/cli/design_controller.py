"""``frictionloop design controller``: from a bench to a controller that holds on it, and what is left to gain."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.must_hold import ASKED, MustHoldForPeople

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = (
    "",
    "my-bench.toml --out my-controller.toml",
    "my-bench.toml --speeds 20,60 --loads 0.4,1.2",
    "my-bench.toml --corners certificate.html",
    "my-bench.toml --law hinf --sensitivity-peak 1.5 --resonance-error 0.1 --plots figures",
)
AS_USUAL = MustHoldForPeople()


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    law: Annotated[str | None, Parameter(group=ASKED)] = None,
    must: MustHoldForPeople = AS_USUAL,
    out: flags.Result[Path | None] = None,
    plots: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> int:
    """Find a controller for a bench: gains, margins on every finger and resonance, and what is left to gain.

    Parameters
    ----------
    law
        Control law: notch_pi, pi, limit_observer or hinf; notch_pi if not given, pi for
        a force sensor without a resonance.
    out
        Write the system with its new controller here (.toml).
    plots
        Folder for figures, sensitivity and step, each as .svg and .png.
    """
    must.check()
    file_arguments.check_output("out", out, file_arguments.SYSTEMS)
    file_arguments.check_new("out", out)
    file_arguments.check_folder("plots", plots)
    given = flags.system_given(file, preset, overrides, "bench", designed=law or "notch_pi")
    requirements, people = must.requirements(file), must.people(given.system, overrides)
    with fl.progress.waiting("designing" + f" {law}" * bool(law)):
        found = fl.design.controller(given.system, law, requirements, people, given=given.stated)
    if out is not None:
        fl.design.write_controller(found, out, given.stated)
    if plots is not None:
        file_arguments.write_figures("plots", plots, {name: found.plot(name) for name in ("sensitivity", "step")})
    shown.show(found.with_findings(given.findings), saved={"controller": out, "figures": plots})
    return 0 if found.holds else screen.DOES_NOT_HOLD
