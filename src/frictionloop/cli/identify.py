"""``frictionloop identify``: from recordings of a lab to its bench."""

from __future__ import annotations

import sys
from contextlib import ExitStack
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.device import ADDRESS
from frictionloop.cli.verb import verb

RecordingFile = Annotated[Path, Parameter(name="FILE", help="A recording.", group=flags.SYSTEM)]


@verb("channels FILE [OPTIONS]", "hits.mat", "hits.mat --plot hits.png", "hits.mat --save-map hits-map.toml")
def channels(
    file: RecordingFile,
    /,
    *,
    rate_hz: flags.Run[float | None] = None,
    decimal: flags.Run[Literal[".", ","] | None] = None,
    plot: flags.Result[Path | None] = None,
    save_map: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Show what a file holds before anything is computed: channels, rate, clipping, wraps, lost samples.

    Parameters
    ----------
    rate_hz
        Sampling rate in Hz, where the file tells none or two.
    decimal
        Decimal mark of a text, where its numbers can be read in two ways.
    plot
        Draw the channels here (.png, .svg or .pdf): the range of each in short windows along the file, before the rest.
    save_map
        Write a channel map here (.toml) to be filled in: which channel is which, in what unit.
    """
    file_arguments.check_output("save_map", save_map, file_arguments.SYSTEMS, new=True)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    if plot is not None:
        fl.plot(fl.identify.first_look(file, rate_hz, decimal), plot)
        screen.say(f"saved channels: {plot}")
    found = fl.identify.channels(file, rate_hz, decimal=decimal)
    if save_map is not None:
        found.write_map(save_map)
    shown.show(found, saved={"map": save_map, "plot": plot})


ProjectFile = Annotated[Path, Parameter(name="FILE", help="Recordings, and what each is (.toml).", group=flags.SYSTEM)]


@verb("bench FILE [OPTIONS]", "lab.toml", "lab.toml --out my-bench.toml --report certificate.html")
def bench(
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
    file_arguments.check_output("report", report, (".html",))
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


Before = Annotated[Path, Parameter(name="BEFORE", help="The older certificate (.html, or --json).", group=flags.SYSTEM)]
After = Annotated[Path, Parameter(name="AFTER", help="The newer one.", group=flags.SYSTEM)]


@verb("compare BEFORE AFTER [OPTIONS]", "certificate-1.html certificate.html")
def compare(before: Before, after: After, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Compare two certificates of a bench: which values have changed beyond their uncertainty."""
    shown.show(fl.identify.compare(before, after))


Kind = Annotated[
    Literal["weights", "hits", "quiet", "friction"],
    Parameter(name="KIND", help="What is recorded.", group=flags.SYSTEM),
]
DeviceAt = Annotated[str, Parameter(name="--device", metavar="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
LEVELS = 500
"""Samples between two looks at the level: a tenth of a second."""


@verb(
    "run weights|hits|quiet|friction --device ADDRESS [OPTIONS]",
    "quiet --device sim:",
    "weights --device serial:///dev/ttyACM0 --masses-g 0,50,100,150,200,150,100,50,0 --out weights.h5",
)
def run(
    kind: Kind,
    /,
    *,
    device: DeviceAt,
    masses_g: flags.Run[str | None] = None,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Record one measurement of a calibration: each step is asked for, the level is shown while it is recorded.

    A recording and its channel map are written, and the lines that a project file needs for them. The plate stays off.
    The recording holds the counts of the converter, for which ``identify bench`` finds the board's scale.
    At ``sim:`` nobody is asked: rigs stand in for hands that hang weights, tap, and let go.

    Parameters
    ----------
    masses_g
        Weights in g in the order in which they are hung, such as 0,50,100,50,0; without it up to 200 g and down again.
    out
        Recording (.h5); its map stands beside it. Without it KIND.h5.
    """
    out = out or Path(f"{kind}.h5")
    file_arguments.check_output("out", out, (".h5",))
    for path in (out, fl.identify.map_beside(out)):
        file_arguments.check_new("out", path)
    what = "numbers in g with commas between"
    masses = () if masses_g is None else (file_arguments.numbers_of("masses_g", masses_g, what),)
    fl.identify.steps_of(kind, *masses)  # refuses masses before a device is opened
    with ExitStack() as opening:
        with fl.progress.waiting(f"connecting {device}"):
            opened = opening.enter_context(fl.device.opened(device))
        level = _Level()
        asked = _said if device.startswith("sim:") else _asked
        found = fl.identify.run(kind, opened, *masses, ask=asked, watch=level)
        level.end()
    shown.show(found.saved_at(out), saved={"recording": out, "map": found.write(out)})


def _said(step: Any) -> None:
    screen.say(f"step {step.number} of {step.of}: {step.says}")


def _asked(step: Any) -> None:
    _said(step)
    input("Enter begins: ")


class _Level:
    """The level and how much it moves, on a terminal, ten times a second."""

    def __init__(self) -> None:
        self._held: list[float] = []
        self._shown = sys.stderr.isatty()

    def __call__(self, block: Any) -> None:
        self._held += block["f_m"].tolist() if self._shown else []
        if len(self._held) >= LEVELS:
            low, high = min(self._held), max(self._held)
            bar = "#" * int(min(max(abs(low), abs(high)) / 2.5, 1.0) * 30)
            print(f"\r{(low + high) / 2:+8.4f} N  +- {(high - low) / 2:.4f}  |{bar:30}|", end="", file=sys.stderr)
            self._held = []

    def end(self) -> None:
        if self._shown:
            print(file=sys.stderr)
