"""``frictionloop sweep``: many runs over the values of some parameters and their best points, or over people.

The axes of a sweep, as written after ``--over``: ``controller.kp=1:100:32:log`` or ``controller.ki=0.1,1,10``.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop import FrictionloopError
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb

MOST_FINGERS = 1_000_000


@verb(
    "sweep [FILE] --over NAME=VALUES | --fingers N [OPTIONS]",
    "--over controller.kp=1:100:32:log --over controller.ki=0.1,1,10",
    "--preset feasible --seeds 4 --out noise.h5 --over sensor.noise_rms_n=1e-6:1:25:log --plot noise.svg",
    "my-bench.toml --over controller.kp=5,10,20 --csv table.csv",
    "my-controller.toml --fingers 100 --coefficients 0.4,1.2",
    "my-controller.toml --fingers 100000 --out people --shard 3/64",
    "--status people",
)
def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    over: Annotated[flags.Run[list[str] | None], Parameter(metavar="NAME=VALUES")] = None,
    fingers: flags.Run[flags.Whole | None] = None,
    fingers_seed: flags.Run[flags.Whole | None] = None,
    population: flags.Run[Path | None] = None,
    loads: flags.Run[str | None] = None,
    coefficients: flags.Run[str | None] = None,
    seeds: flags.Run[flags.Whole] = 1,
    duration_s: flags.DurationS = 10.0,
    score_from_s: flags.ScoreFromS = 0.0,
    jobs: flags.Jobs = None,
    metrics: flags.Result[str | None] = None,
    out: flags.Result[Path | None] = None,
    resume: flags.Result[flags.Flag] = False,
    force: flags.Result[flags.Flag] = False,
    shard: flags.Result[str | None] = None,
    status: flags.Result[Path | None] = None,
    csv: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Simulate combinations of values, or a population of fingers.

    Parameters
    ----------
    over
        Values of one parameter: a,b,c or start:stop:count, with :log at the end for equal ratios. Repeat it for
        more parameters: every combination is run.
    fingers
        Instead: number of random fingers, each with its own friction, skin, load and tremor in place of those of FILE.
    fingers_seed
        Seed of the fingers; 0 if not given.
    population
        Draw the fingers from this measured population (.toml, from ``identify bench --population``) in place of the
        assumed one.
    loads
        Least and largest mean load of the fingers in N, drawn evenly between them: 0.4,1.2, or one; as people press by
        themselves if not given.
    coefficients
        Least and largest friction coefficient of the fingers, likewise: 0.4,1.2.
    seeds
        Runs per combination or finger, with noise seeds 0, 1, ...
    metrics
        Metrics to keep, such as r2_identity,disturbance_left; if not given r2_identity, rms_error and
        saturation_index, with --fingers also perceptual_index, and disturbance_left of a recorded disturbance.
    out
        Keep the result here (HDF5, .h5), also on Ctrl-C.
    resume
        Continue the sweep kept in --out instead of starting over.
    force
        Start over in --out whatever it holds.
    shard
        Run part i of n, such as 3/64, into the folder --out; `fl.open_sweep` reads them all.
    status
        Say which shards in this folder are done instead.
    csv
        Write a table with one row per run here (.csv).
    plot
        Draw curves or maps, of --fingers a point each, into this file (.svg, .pdf or .png).
    """
    if status is not None:
        if over or fingers or out:
            raise FrictionloopError("status: without --over, --fingers and --out; it runs nothing")
        shown.show(fl.sweep_status(status))
        return
    part = None if shard is None else _part(shard, out)
    if part is None:
        file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    file_arguments.check_output("csv", csv, file_arguments.TABLES)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    file_arguments.check_count("seeds", seeds, 1, 1_000_000)
    file_arguments.check_workers(jobs, resume, out, "sweep")
    file_arguments.check_score(score_from_s, duration_s)
    if bool(over) == (fingers is not None):
        raise FrictionloopError("over: give --over NAME=VALUES, such as controller.kp=1,2,5, or --fingers N")
    whose = {"population": population, "loads": loads, "coefficients": coefficients}
    file_arguments.check_fingers(fingers, fingers_seed, MOST_FINGERS // max(seeds, 1), **whose)
    drawn: dict[str, Any] = {"count": fingers, "seed": fingers_seed or 0, "population": population}
    drawn["loads_n"] = file_arguments.two_values("loads", loads, file_arguments.LOADS) or None
    drawn["coefficients"] = file_arguments.two_values("coefficients", coefficients, file_arguments.COEFFICIENTS) or None
    axes = axes_of(over or (), seeds)
    given = flags.system_given(file, preset, overrides)
    names = None if metrics is None else [name.strip() for name in metrics.split(",")]
    doubts = fl.doubts(given.system, speeds_mm_s=axes.get("motion.speed_mm_s", ()))
    how: dict[str, Any] = {"score_from_s": score_from_s, "n_jobs": jobs, "path": out, "resume": resume, "force": force}
    how |= {"duration_s": duration_s, "seeds": seeds, "metrics": names}
    brought = tuple(flags.overrides_of(overrides))
    if part is not None:
        if csv is not None or plot is not None:
            raise FrictionloopError("shard: without --csv and --plot; fl.open_sweep has all parts")
        how["metrics"] = fl.design.metrics_for(given.system) if fingers and names is None else names
        points = axes if not fingers else fl.fingers_for(given.system, drawn.pop("count"), **drawn, given=brought)
        try:
            fl.sweep(given.system, points, **how, shard=part)
        except fl.SweepInterrupted as stop:
            raise screen.interrupted(f"shard {shard} stopped", out) from stop
        shown.show(fl.sweep_status(out).with_findings((*given.findings, *doubts)), saved={"shards": out})
        return
    found, stopped = _found(given.system, axes, {**drawn, "given": brought} if fingers else {}, how)
    if csv is not None:
        file_arguments.write_csv(csv, found.tidy())
    if plot is not None:
        fl.plot(found.grid, plot)
    shown.show(found.with_findings((*given.findings, *doubts)), saved={"sweep": out, "table": csv, "plot": plot})
    if stopped:
        raise screen.interrupted(f"{found.runs_done} of {found.runs} runs done", out)


def _part(shard: str, out: Path | None) -> tuple[int, int]:
    """Return the part of a sweep that is named, and refuse one without a folder."""
    numbers = shard.split("/")
    if out is None:
        raise FrictionloopError("shard: needs --out FOLDER")
    if len(numbers) != 2 or not all(each.isdecimal() for each in numbers):
        raise FrictionloopError(f"shard = {shard!r}: must be a part of parts, such as 3/64")
    return int(numbers[0]), int(numbers[1])


def _found(
    system: fl.System, axes: Mapping[str, Any], people: Mapping[str, Any], how: Mapping[str, Any]
) -> tuple[Any, bool]:
    """Return what was found of people, or else over axes, and whether Ctrl-C stopped it."""
    try:
        return fl.people(system, **people, **how) if people else fl.best(fl.sweep(system, axes, **how)), False
    except fl.PeopleInterrupted as stop:
        return stop.partial, True
    except fl.SweepInterrupted as stop:
        return fl.best(stop.partial), True


ACCEPTED = "NAME=a,b,c or NAME=start:stop:count or NAME=start:stop:count:log"
MOST_RUNS = 20_000_000
"""Runs in one sweep: at about 350 bytes each while it lasts, 7 GB."""


def axes_of(given: Sequence[str], seeds: int = 1) -> dict[str, list[Any]]:
    """Return the values along each dotted path, in the order given; refuse more runs than a sweep can hold."""
    axes: dict[str, list[Any]] = {}
    for text in given:
        path, equals, values = text.partition("=")
        path = path.strip().removeprefix("--").replace("-", "_")
        if not (path and equals and values.strip()):
            raise FrictionloopError(f"over = {text!r}: must be {ACCEPTED}")
        if path in axes:
            raise FrictionloopError(f"over = {text!r}: {path} is there twice")
        axes[path] = (
            _range(text, values.split(":"))
            if ":" in values
            else [flags.scalar(value.strip()) for value in values.split(",")]
        )
    runs = seeds * math.prod(map(len, axes.values()))
    if runs > MOST_RUNS:
        raise FrictionloopError(f"over: {runs} runs; must be at most {MOST_RUNS}")
    return axes


def _range(text: str, parts: list[str]) -> list[float]:
    try:
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
        (log,) = [{"log": True, "lin": False}[spacing] for spacing in parts[3:]] or [False]
    except (ValueError, IndexError, KeyError):
        raise FrictionloopError(f"over = {text!r}: must be {ACCEPTED}") from None
    if not (2 <= count <= MOST_RUNS and math.isfinite(start) and math.isfinite(stop)):
        raise FrictionloopError(f"over = {text!r}: must have finite ends and 2 to {MOST_RUNS} values")
    if log and not (start > 0 and stop > 0):
        raise FrictionloopError(f"over = {text!r}: must have ends above 0 for log")
    shares = [k / (count - 1) for k in range(1, count - 1)]
    between = [start * (stop / start) ** share if log else start + (stop - start) * share for share in shares]
    return [start, *between, stop]
