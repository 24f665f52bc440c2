"""``frictionloop experiment``: a protocol, what it will do, how many participants it takes, sessions as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb

if TYPE_CHECKING:
    from frictionloop.experiments import Study

ProtocolName = Annotated[str, Parameter(name="PROTOCOL", help="TOML file, or name of a protocol.", group=flags.SYSTEM)]
SAID = "Write the figure of what was found of each participant here (.svg, .pdf, .png)."
Figure = Annotated[Path | None, Parameter(help=SAID, group=flags.RESULT)]
Bench = Annotated[Path | None, Parameter(help="Bench (.toml); else bench() with notch_pi.", group=flags.SYSTEM)]


@verb("new FILE [OPTIONS]", "my-study.toml", "my-study.toml --from grating-spacing")
def new(
    file: Annotated[Path, Parameter(name="FILE", help="File to write (.toml).", group=flags.RESULT)],
    /,
    *,
    start: Annotated[flags.Run[str], Parameter(name="from")] = "jnd-friction-staircase",
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write a protocol to begin with, each key with its unit, meaning and what it accepts.

    Parameters
    ----------
    start
        The protocol to copy: a file, or a name of one that comes with the package.
    """
    file_arguments.check_output("file", file, file_arguments.SYSTEMS, new=True)
    shown.show(fl.experiments.new(file, start), saved={"protocol": file})


@verb("check PROTOCOL [OPTIONS]", "my-study.toml")
def check(protocol: ProtocolName, /, *, bench: Bench = None, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Run every branch of a protocol dry: trials, duration, forces, and the share of fingers that can be given them."""
    given = flags.bench_of(bench)
    found = fl.experiments.check(fl.experiments.read_protocol(protocol), given.system)
    shown.show(found.with_findings(given.findings))


@verb("export FOLDER OUT [OPTIONS]", "data bids-data", "data/P01 P01.csv --as csv")
def export(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    out: Annotated[Path, Parameter(name="OUT", help="New folder, or file, to write.", group=flags.RESULT)],
    /,
    *,
    form: Annotated[flags.Run[Literal["bids", "csv", "hdf5"]], Parameter(name="as")] = "bids",
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write sessions for other programs.

    Parameters
    ----------
    form
        bids: a folder in the shape of BIDS; csv: one table, as PsychoPy writes; hdf5: one file with all traces.
    """
    if form != "bids":
        file_arguments.check_output("out", out, {"csv": file_arguments.TABLES, "hdf5": file_arguments.RUN_FILES}[form])
    shown.show(fl.experiments.export(folder, out, form))


@verb(
    "power PROTOCOL [OPTIONS]",
    "study-friction --effect 0.2 --participants 6:40",
    "my-study.toml --participants 12:24:12 --trials 20:60:20",
)
def power(
    protocol: ProtocolName,
    /,
    *,
    effect: flags.Run[float] = 0.2,
    participants: flags.Run[str] = "6:24",
    trials: flags.Run[str | None] = None,
    studies: flags.Run[flags.Whole] = 400,
    pool: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Tell by simulation how many participants and trials a study needs to find a difference, condition by condition.

    Participants are simulated with and without the effect; studies are drawn from them, a paired test in each. The
    interval beside each share is over other participants that might have been simulated.

    Parameters
    ----------
    effect
        Relative change of what is found between two states of the participants, such as 0.2 for a fifth.
    participants
        Numbers of participants, from:to or from:to:step; without a step some nine of them.
    trials
        Numbers of trials of a condition that count, likewise; all of the protocol if not given.
    studies
        Studies that are drawn for each number.
    pool
        Participants that are simulated, from whom studies are drawn.
    seed
        Seed of everything.
    """
    file_arguments.check_count("pool", pool, 2, 10_000)
    file_arguments.check_count("studies", studies, 1, 1_000_000)
    numbers = _range("participants", participants, 2)
    lengths = None if trials is None else _range("trials", trials, 5)
    given, plan = flags.bench_of(bench), fl.experiments.read_protocol(protocol)
    found = fl.experiments.power(
        plan, effect, numbers, given.system, trials=lengths, pool=pool, studies=studies, seed=seed
    )
    shown.show(found.with_findings(given.findings))


def _range(name: str, text: str, least: int) -> list[int]:
    try:
        first, last, *step = (int(each) for each in text.split(":"))
    except ValueError:
        first, last, step = 0, 0, []
    if not least <= first <= last <= 1000 or len(step) > 1 or (step and step[0] < 1):
        raise fl.FrictionloopError(f"{name} = {text!r}: must be from:to, each from {least} to 1000")
    return list(range(first, last + 1, step[0] if step else max((last - first) // 8, 1)))


@verb(
    "simulate PROTOCOL [OPTIONS]",
    "jnd-friction-staircase --participants 24 --out study.html",
    "my-study.toml --participants 8 --folder data",
)
def simulate(
    protocol: ProtocolName,
    /,
    *,
    participants: flags.Run[flags.Whole] = 24,
    seed: flags.Run[flags.Whole] = 0,
    bench: Bench = None,
    folder: flags.Result[Path | None] = None,
    out: flags.Result[Path | None] = None,
    figure: Figure = None,
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
    """
    _check_results(out, figure)
    file_arguments.check_count("participants", participants, 1, 10_000)
    file_arguments.check_count("seed", seed, 0)
    given, plan = flags.bench_of(bench), fl.experiments.read_protocol(protocol)
    found = fl.experiments.simulate(plan, given.system, participants, seed, path=folder)
    _show(found.with_findings(given.findings), out, figure, shown)


@verb("report FOLDER [OPTIONS]", "data --out study.html")
def report(
    folder: Annotated[Path, Parameter(name="FOLDER", help="A session, or a folder of sessions.", group=flags.SYSTEM)],
    /,
    *,
    out: flags.Result[Path | None] = None,
    figure: Figure = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Fit what sessions of one protocol have found, and write it as one page.

    Parameters
    ----------
    out
        Write the page here (.html), with its tables beside it.
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
