"""``frictionloop identify bench``: the recordings of a project file to the file of the bench and its certificate."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen

ARGUMENTS = "FILE [OPTIONS]"
EXAMPLES = (
    "lab.toml",
    "lab.toml --out my-bench.toml --report certificate.html",
)
ProjectFile = Annotated[Path, Parameter(name="FILE", help="Recordings, and what each is (.toml).", group=flags.SYSTEM)]
REPORTS = (".html",)


def command(
    file: ProjectFile,
    /,
    *,
    out: flags.Result[Path | None] = None,
    report: flags.Result[Path | None] = None,
    population: flags.Result[Path | None] = None,
    again: flags.Flag = False,
    without_refused: flags.Flag = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Turn a lab's recordings into the file of its bench: measured values, and "assumed" for the rest.

    Results are kept beside the project file: a recording that has not changed is not analysed twice.

    Parameters
    ----------
    out
        Write the system here (.toml), with a comment for each value.
    report
        Write the certificate here (.html); an older one is kept under a number.
    population
        Write the population of fingers here (.toml), for ``fl.fingers``.
    again
        Analyse everything anew.
    without_refused
        Go on without entries that are refused, and say which. Otherwise no bench is written, and the results of the
        others are kept.
    """
    file_arguments.check_output("out", out, file_arguments.SYSTEMS)
    file_arguments.check_output("report", report, REPORTS)
    file_arguments.check_output("population", population, file_arguments.SYSTEMS)
    if report is not None:
        file_arguments.check_drawing()
    kept, older = file.with_suffix(".results.json"), None
    with fl.progress.waiting("analysing the recordings"):
        try:
            found = fl.identify.bench(file, kept, again=again, without_refused=without_refused)
        except fl.identify.Refused as refused:
            raise fl.draw_refused(refused, file.with_suffix(".refused.png")) from None
    if population is not None:
        found.write_population(population)
    if out is not None:
        found.write(out)
    if report is not None:
        with fl.progress.waiting("drawing the certificate"):
            older = fl.write_certificate(found, report)
    saved = {"bench": out, "certificate": report, "older certificate": older, "population": population}
    shown.show(found, saved=saved)
