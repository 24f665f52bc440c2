"""``frictionloop design check``: does the controller that is there hold on this bench, where not, and what would."""

from __future__ import annotations

from pathlib import Path

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.must_hold import MustHoldForPeople

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = (
    "my-controller.toml",
    "my-bench.toml --controller.kp 0.05 --controller.ki 60",
    "my-controller.toml --speeds 20,60 --json",
    "my-controller.toml --fingers 100 --all",
)
AS_USUAL = MustHoldForPeople()


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    must: MustHoldForPeople = AS_USUAL,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> int:
    """Check the controller of a system as it is: where it holds, where it does not and by how much, and what would.

    No other controller is searched for. It is looked at from slip length 0 to its own, at its speed, half and four
    times that, on a dry and a moist finger, with the resonance off.

    Parameters
    ----------
    out
        Write the system with this controller here (.toml), with what was found.
    """
    must.check()
    file_arguments.check_output("out", out, file_arguments.SYSTEMS)
    file_arguments.check_new("out", out)
    given = flags.system_given(file, preset, overrides, "bench")
    requirements, people = must.requirements(file), must.people(given.system, overrides)
    with fl.progress.waiting(f"checking {given.system.controller.kind}"):
        found = fl.design.check(given.system, requirements, people, given=given.stated)
    if out is not None:
        fl.design.write_controller(found, out, given.stated)
    shown.show(found.with_findings(given.findings), saved={"controller": out})
    return 0 if found.holds else screen.DOES_NOT_HOLD
