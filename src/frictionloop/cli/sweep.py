"""``frictionloop sweep``: many runs over the values of some parameters, and the best point per metric."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.axes import axes_of
from frictionloop.quantities.units import FrictionloopError

ARGUMENTS = "[FILE] --over NAME=VALUES | --fingers N [OPTIONS]"
MOST_FINGERS = 1_000_000
EXAMPLES = r"""Examples

  frictionloop sweep --over controller.kp=1:100:32:log \
      --over controller.ki=0.1,1,10
  frictionloop sweep --preset feasible --seeds 4 --out noise.h5 \
      --over sensor.noise_rms_n=1e-6:1:25:log --plot noise.svg
  frictionloop sweep my-bench.toml --over controller.kp=5,10,20 --csv table.csv
  frictionloop sweep --preset bench --fingers 100 --csv fingers.csv \
      --controller.kp 0.062 --controller.ki 134
"""


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    over: Annotated[
        list[str] | None,
        Parameter(
            metavar="NAME=VALUES",
            help="Values of one parameter: a,b,c or start:stop:count, with :log at the end for equal ratios. "
            "Repeat it for more parameters: every combination is run.",
            group=flags.RUN,
        ),
    ] = None,
    fingers: Annotated[
        int | None,
        Parameter(
            help="Instead: number of random fingers on a bench, each with its own friction, skin and motion.",
            converter=flags.whole,
            group=flags.RUN,
        ),
    ] = None,
    fingers_seed: Annotated[
        int | None,
        Parameter(help="Seed of the fingers; 0 if not given.", converter=flags.whole, group=flags.RUN),
    ] = None,
    seeds: Annotated[
        int,
        Parameter(
            help="Runs per combination or finger, with noise seeds 0, 1, ...", converter=flags.whole, group=flags.RUN
        ),
    ] = 1,
    duration_s: flags.DurationS = 10.0,
    score_from_s: flags.ScoreFromS = 0.0,
    jobs: Annotated[
        int | None,
        Parameter(help="Parallel workers; one per core if not given.", converter=flags.whole, group=flags.RUN),
    ] = None,
    metrics: Annotated[
        str | None,
        Parameter(
            help="Metrics to keep, such as r2_identity,output_noise; if not given r2_identity, rms_error and "
            "saturation_index, with --fingers also perceptual_index.",
            group=flags.RESULT,
        ),
    ] = None,
    out: Annotated[
        Path | None, Parameter(help="Keep the result here (HDF5, .h5), also on Ctrl-C.", group=flags.RESULT)
    ] = None,
    resume: Annotated[
        bool,
        Parameter(
            help="Continue the sweep kept in --out instead of starting over.", show_default=False, group=flags.RESULT
        ),
    ] = False,
    csv: Annotated[
        Path | None, Parameter(help="Write a table with one row per run here (.csv).", group=flags.RESULT)
    ] = None,
    plot: Annotated[
        Path | None,
        Parameter(help="Draw curves, maps or a distribution into this file (.svg, .pdf or .png).", group=flags.RESULT),
    ] = None,
    json: flags.Json = False,
) -> None:
    """Simulate every combination of some parameters' values and say which is best, or a population of fingers."""
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("csv", csv, checks.TABLES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_count("seeds", seeds, 1, 1_000_000)
    checks.check_count("jobs", 1 if jobs is None else jobs, 1, 1024)
    checks.check_score(score_from_s, duration_s)
    _check_points(over, fingers, fingers_seed, seeds)
    if resume and out is None:
        raise FrictionloopError("resume: needs --out FILE.h5, the file of the sweep to continue")
    system = flags.system_from(file, preset, overrides)
    names = None if metrics is None else [name.strip() for name in metrics.split(",")]
    with screen.waiting("loading the compiled loop; after an installation it is compiled first"):
        from frictionloop.cli import outcome, population
        from frictionloop.loop.record import save
        from frictionloop.loop.sweep import SweepInterrupted, sweep

        people = population.population_of(system, fingers, fingers_seed or 0, overrides) if fingers else None
        points: Any = people or axes_of(over or (), seeds)
        names = list(population.METRICS) if names is None and fingers else names
        outcome.compiled(system, points, seeds, names)
    if out is not None and not resume:
        outcome.check_finished(out)
    clock, interrupted = screen.Stopwatch(), False
    options: dict[str, Any] = {"score_from_s": score_from_s, "n_jobs": jobs, "path": out, "resume": resume}
    try:
        result = sweep(system, points, duration_s, seeds, names, **options)
    except SweepInterrupted as stop:
        result, interrupted = stop.partial, True
    found: outcome.Outcome
    if fingers:
        found = population.Population(result, clock.elapsed_s(), not interrupted, system, points)
        if out is not None:  # what each finger can be given beside its metrics
            save(found.result, out)
    else:
        found = outcome.Outcome(result, clock.elapsed_s(), complete=not interrupted)
    if csv is not None:
        checks.write_csv(csv, found.table())
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(found.result, plot)
    saved = {"sweep": out, "table": csv, "plot": plot}
    if json:
        asked = {"system": system.model_dump(), "duration_s": duration_s, "score_from_s": score_from_s}
        if fingers:
            asked["fingers_seed"] = fingers_seed or 0
        screen.show_json(asked | found.as_json() | {"saved": saved})
    else:
        origin = flags.named(file, preset, overrides)
        if fingers:
            origin += f", {fingers} fingers of seed {fingers_seed or 0}"
        lines = [f"saved {what} as {path}" for what, path in saved.items() if path]
        screen.show(screen.columns([("system", origin)]), "", *found.summary(duration_s), *lines)
    if interrupted:
        kept = f"kept in {out}" if out else "not kept: without --out there is nothing to continue from"
        raise screen.Interrupted(f"{found.done} of {found.total} runs done, {kept}", resumable=out is not None)


def _check_points(over: list[str] | None, fingers: int | None, fingers_seed: int | None, seeds: int) -> None:
    """Refuse a sweep of nothing, or of two things at once."""
    if over and fingers is not None:
        raise FrictionloopError("over and fingers: give one; --fingers sweeps a population at the values of the system")
    if not over and fingers is None:
        raise FrictionloopError("over: give --over NAME=VALUES, such as controller.kp=1,2,5, or --fingers N")
    if fingers is None:
        if fingers_seed is not None:
            raise FrictionloopError(f"fingers_seed = {fingers_seed}: needs --fingers N, which it is the seed of")
        return
    checks.check_count("fingers", fingers, 1, MOST_FINGERS // seeds)
    checks.check_count("fingers_seed", fingers_seed or 0, 0)
