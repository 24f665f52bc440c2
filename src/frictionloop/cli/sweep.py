"""``frictionloop sweep``: many runs over the values of some parameters, and the best point per metric.

The axes of a sweep, as written after ``--over``: ``controller.kp=1:100:32:log`` or ``controller.ki=0.1,1,10``.
"""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.flags import scalar
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.cli.outcome import Outcome
    from frictionloop.cli.sweep_points import Given
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] --over NAME=VALUES | --fingers N [OPTIONS]"
MOST_FINGERS = 1_000_000
EXAMPLES = r"""Examples

  frictionloop sweep --over controller.kp=1:100:32:log \
      --over controller.ki=0.1,1,10
  frictionloop sweep --preset feasible --seeds 4 --out noise.h5 \
      --over sensor.noise_rms_n=1e-6:1:25:log --plot noise.svg
  frictionloop sweep my-bench.toml --over controller.kp=5,10,20 --csv table.csv
  frictionloop sweep my-controller.toml --fingers 100 --loads 0.4,1.2
"""


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
    seeds: flags.Run[flags.Whole] = 1,
    duration_s: flags.DurationS = 10.0,
    score_from_s: flags.ScoreFromS = 0.0,
    jobs: flags.Run[flags.Whole | None] = None,
    metrics: flags.Result[str | None] = None,
    out: flags.Result[Path | None] = None,
    resume: flags.Result[flags.Flag] = False,
    csv: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Simulate every combination of some parameters' values and say which is best, or a population of fingers.

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
    seeds
        Runs per combination or finger, with noise seeds 0, 1, ...
    jobs
        Parallel workers; one per core if not given.
    metrics
        Metrics to keep, such as r2_identity,disturbance_left; if not given r2_identity, rms_error and
        saturation_index, with --fingers also perceptual_index, and disturbance_left of a recorded disturbance.
    out
        Keep the result here (HDF5, .h5), also on Ctrl-C.
    resume
        Continue the sweep kept in --out instead of starting over.
    csv
        Write a table with one row per run here (.csv).
    plot
        Draw curves or maps, of --fingers a point each, into this file (.svg, .pdf or .png).
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("csv", csv, checks.TABLES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_count("seeds", seeds, 1, 1_000_000)
    checks.check_workers(jobs, resume, out, "sweep")
    checks.check_score(score_from_s, duration_s)
    _check_points(over, fingers)
    checks.check_fingers(fingers, fingers_seed, MOST_FINGERS // max(seeds, 1), population=population, loads=loads)
    between = checks.two_values("loads", loads, checks.LOADS) or None
    from frictionloop.parameters.unit_sanity import of_axes, of_ceiling

    system, origin = flags.noted(file, preset, overrides)
    axes = axes_of(over or (), seeds)
    screen.note_findings(of_axes(axes))
    screen.note_findings(of_ceiling(system))
    names = None if metrics is None else [name.strip() for name in metrics.split(",")]
    with screen.waiting("loading the compiled loop"):
        from frictionloop.cli import contact_turns, outcome, recorded_units
        from frictionloop.cli.population import metrics_of, population_of

        people = population_of(system, fingers, fingers_seed or 0, overrides, population, between) if fingers else None
        points: Any = people or axes
        names = metrics_of(system) if names is None and fingers else names
        outcome.compiled(system, points, seeds, names)
    if out is not None and not resume:
        outcome.check_finished(out)
    recorded_units.ask(system)
    contact_turns.ask(system, axes)
    screen.tell_notes()
    options: dict[str, Any] = {"score_from_s": score_from_s, "n_jobs": jobs, "path": out, "resume": resume}
    found = _swept(system, points, duration_s, seeds, names, **options)
    if csv is not None:
        checks.write_csv(csv, found.table())
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(found.result, plot)
    saved = {"sweep": out, "table": csv, "plot": plot}
    about: dict[str, Any] = (
        {"fingers_seed": fingers_seed or 0, "population_file": population, "loads_n": between} if fingers else {}
    )
    if json:
        about |= {"system": system.model_dump(), "duration_s": duration_s, "score_from_s": score_from_s}
        screen.show_json(about | found.as_json() | {"saved": saved})
    else:
        whose = "" if population is None else f" of {population}"
        said = f"{origin}, {fingers} fingers{whose} of seed {fingers_seed or 0}" if fingers else origin
        of = None if fingers else (file, preset, overrides)
        screen.show(screen.columns([("system", said)]), "", *_told(found, system, of, duration_s), *screen.saved(saved))
    if not found.complete:
        raise screen.interrupted(f"{found.done} of {found.total} runs done", out)
    if not found.opened:
        raise screen.interrupted("all runs done, but not those in open loop", out)


def _told(found: Outcome, system: System, of: Given | None, duration_s: float) -> list[Any]:
    """Return what a person is shown; ``of`` is the command line of the system, None of fingers."""
    if of is None:
        return found.summary(duration_s)
    from frictionloop.cli import sweep_points

    listed, margins = sweep_points.listed(found, system), sweep_points.margins(found, system, of)
    return [*listed, *found.summary(duration_s), *margins]


def _swept(system: System, points: Any, duration_s: float, seeds: int, names: Any, **options: Any) -> Outcome:
    """Return what a sweep found, or what was done of it before Ctrl-C."""
    from frictionloop.cli import outcome, population
    from frictionloop.cli.population_open import with_open_loop
    from frictionloop.loop.record import save
    from frictionloop.loop.sweep import SweepInterrupted, sweep
    from frictionloop.physics.fingers import Fingers

    start_s, complete = time.perf_counter(), True
    try:
        result = sweep(system, points, duration_s, seeds, names, **options)
    except SweepInterrupted as stop:
        result, complete = stop.partial, False
    if not isinstance(points, Fingers):
        return outcome.Outcome(result, time.perf_counter() - start_s, complete)
    opened, how = complete, {name: options[name] for name in ("score_from_s", "n_jobs")}
    if complete:
        try:
            result = with_open_loop(result, system, points, duration_s, seeds, **how)
        except KeyboardInterrupt:  # what was swept is not lost for it
            opened = False
    found = population.Population(result, time.perf_counter() - start_s, complete, system, points)
    found.opened = opened
    if options["path"] is not None:  # what each finger can be given beside its metrics
        save(found.result, options["path"])
    return found


def _check_points(over: list[str] | None, fingers: int | None) -> None:
    """Refuse a sweep of nothing, or of two things at once."""
    if over and fingers is not None:
        raise FrictionloopError("over and fingers: give one; --fingers sweeps a population at the values of the system")
    if not over and fingers is None:
        raise FrictionloopError("over: give --over NAME=VALUES, such as controller.kp=1,2,5, or --fingers N")


ACCEPTED = "accepted: NAME=a,b,c or NAME=start:stop:count or NAME=start:stop:count:log"
MOST_RUNS = 20_000_000
"""Runs in one sweep: at about 350 bytes each while it lasts, 7 GB."""


def axes_of(given: Sequence[str], seeds: int = 1) -> dict[str, list[Any]]:
    """Return the values along each dotted path, in the order given; refuse more runs than a sweep can hold."""
    axes: dict[str, list[Any]] = {}
    for text in given:
        path, equals, values = text.partition("=")
        path = path.strip().removeprefix("--").replace("-", "_")
        if not (path and equals and values.strip()):
            raise FrictionloopError(f"over = {text!r}: {ACCEPTED}")
        if path in axes:
            raise FrictionloopError(f"over = {text!r}: {path} is swept twice; give all its values at once")
        axes[path] = (
            _range(text, values.split(":")) if ":" in values else [scalar(v.strip()) for v in values.split(",")]
        )
    runs = seeds * math.prod(map(len, axes.values()))
    if runs > MOST_RUNS:
        raise FrictionloopError(f"over: {runs} runs are more than {MOST_RUNS}; take fewer values or fewer seeds")
    return axes


def _range(text: str, parts: list[str]) -> list[float]:
    try:
        start, stop, count = float(parts[0]), float(parts[1]), int(parts[2])
        (log,) = [{"log": True, "lin": False}[spacing] for spacing in parts[3:]] or [False]
    except (ValueError, IndexError, KeyError):
        raise FrictionloopError(f"over = {text!r}: {ACCEPTED}") from None
    if not (2 <= count <= MOST_RUNS and math.isfinite(start) and math.isfinite(stop)):
        raise FrictionloopError(f"over = {text!r}: start and stop must be finite, count from 2 to {MOST_RUNS}")
    if log and not (start > 0 and stop > 0):
        raise FrictionloopError(f"over = {text!r}: start and stop must be positive for log spacing")
    import numpy as np

    values: list[float] = (np.geomspace if log else np.linspace)(start, stop, count).tolist()
    return values
