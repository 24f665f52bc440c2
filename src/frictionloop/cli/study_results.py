"""``frictionloop experiment simulate`` and ``report``: what a study, or sessions, found."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.experiment import Bench, ProtocolName, bench_of

if TYPE_CHECKING:
    from frictionloop.experiments import Study

SIMULATE_EXAMPLES = (
    "jnd-friction-staircase --participants 24 --out study.html",
    "my-study.toml --participants 8 --folder data",
)
REPORT_EXAMPLES = ("data --out study.html",)


def simulate(
    protocol: ProtocolName,
    /,
    *,
    participants: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    folder: flags.Result[Path | None] = None,
    out: flags.Result[Path | None] = None,
    figure: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Run a whole study with simulated participants, and say what it found.

    Parameters
    ----------
    participants
        How many take part.
    seed
        Seed of the participants.
    folder
        Keep a session's folder for each participant here, without traces.
    out
        Write the page of the study here (.html), with its tables beside it.
    figure
        Write the figure of what was found of each participant here (.svg, .pdf, .png).
    """
    _check_results(out, figure)
    file_arguments.check_count("participants", participants, 1, 10_000)
    file_arguments.check_count("seed", seed, 0)
    given, plan = bench_of(bench), fl.experiments.read_protocol(protocol)
    found = fl.experiments.simulate(plan, given.system, participants, seed, path=folder)
    _show(found.with_findings(given.findings), out, figure, shown)


def report(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    /,
    *,
    out: flags.Result[Path | None] = None,
    figure: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Fit what sessions of one protocol have found, and write it as one page.

    Parameters
    ----------
    out
        Write the page here (.html), with its tables beside it.
    figure
        Write the figure of what was found of each participant here (.svg, .pdf, .png).
    """
    _check_results(out, figure)
    _show(fl.experiments.report(folder), out, figure, shown)


def _check_results(out: Path | None, figure: Path | None) -> None:
    """Refuse results that could not be written or drawn, before anything starts."""
    file_arguments.check_output("out", out, (".html",))
    file_arguments.check_output("figure", figure, file_arguments.FIGURES)
    file_arguments.check_drawing()


def _show(found: Study, out: Path | None, figure: Path | None, shown: screen.Shown) -> None:
    if out is not None:
        fl.experiments.write_page(found, out)
    if figure is not None:
        fl.plot(found, figure)
    shown.show(found, saved={"study": out, "figure": figure})
