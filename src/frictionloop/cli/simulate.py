"""``frictionloop simulate``: one run, its metrics, its traces."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.loop.step_times import StepTime
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop simulate --preset feasible --controller.kp 12
  frictionloop simulate --setpoint.kind sine --plot forces.svg
  frictionloop simulate --preset feasible --save-system my-bench.toml
  frictionloop simulate my-bench.toml --duration-s 2 --out run.h5
  frictionloop simulate my-bench.toml --plot bench.png \
      --disturbance.kind recording --disturbance.path slide.csv \
      --disturbance.column force_n --disturbance.remove_mean true
  frictionloop simulate my-bench.toml --setpoint.kind recording \
      --setpoint.path wanted.csv --setpoint.column force_n
  Also of a recording: unit, scale, offset_n, rate_hz, resample_hz, decimal,
  start_s, stop_s, rectify, remove_mean
"""


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    seed: flags.Run[flags.Whole] = 0,
    score_from_s: flags.ScoreFromS = 0.0,
    split_hz: flags.Run[str | None] = None,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    save_system: flags.Result[Path | None] = None,
    every: Annotated[flags.Result[flags.Flag], Parameter(name="all")] = False,
    json: flags.Json = False,
) -> None:
    """Simulate one run and say how well the force followed its set-point.

    That is one finger with one slip length at one speed; ``design check`` says whether the gains hold for others.

    Parameters
    ----------
    seed
        Seed of all noise: the same seed gives the same run.
    split_hz
        Frequencies with commas between, such as 8 or 4,20: what is left of the disturbance below, between and above.
    out
        Save the traces here (HDF5, .h5).
    plot
        Draw forces, amplitude and motion here (.svg, .pdf or .png).
    save_system
        Write the system here (.toml): a start for a file of your own.
    every
        Write there also what a simple bench never needs.
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_output("save_system", save_system, checks.SYSTEMS)
    checks.check_new("save_system", save_system)
    if every and save_system is None:
        raise FrictionloopError("all: needs --save-system FILE.toml, the file that everything is to be in")
    checks.check_count("seed", seed, 0)
    checks.check_score(score_from_s, duration_s)
    there = [path for path in (out, plot) if path is not None and path.exists()]
    system, origin = flags.noted(file, preset, overrides)
    from frictionloop.cli import bands_asked

    _ask(system)
    edges_hz = bands_asked.edges_of(split_hz, system.controller.rate_hz)
    run, elapsed_s = _run(system, duration_s, seed)

    from frictionloop.cli import (
        advice,
        advice_text,
        describe,
        one_place,
        recorded,
        recorded_bands,
        recorded_followed,
        recorded_turns,
        recorded_units,
        ringing,
        scores,
        unscored,
    )
    from frictionloop.loop.record import VARIABLES

    with screen.waiting("scoring"):
        metrics, mask = scores.metrics_of(run, score_from_s), scores.scored_periods(run, score_from_s)
        opened_n = scores.open_error_n(run, mask)
        rings, unreached = advice.ringing(run, mask, metrics), advice_text.out_of_reach(run, mask)
        bands = bands_asked.by_band(run, mask, edges_hz)
        said = [*recorded_units.asked(system, "name", "small", "contact"), *recorded_units.negative(system)]
        said += recorded_units.resampled(system)
        said += bands_asked.notes(run, mask, bands)
        said += [*recorded_bands.lines(run, mask, split=bool(bands)), *recorded_followed.lines(run, mask)]
    said = [*unscored.lines(run, score_from_s), *said]
    said += [*recorded_turns.lines(run, system, duration_s), *recorded.notes(system, duration_s)]
    times, steps = _steps(run, system, score_from_s)
    # What is loaded again counts the same periods.
    units, meaning = VARIABLES["scored"]
    scored = ("time", mask, {"units": units, "long_name": meaning})
    counted = run.assign(scored=scored) if score_from_s else run
    saved = _save(
        counted, system, {"run": out, "plot": plot, "system": save_system}, every, set(flags.overrides_of(overrides))
    )
    if json:
        result = {"system": system.model_dump(), "duration_s": duration_s, "seed": seed, "score_from_s": score_from_s}
        result |= {"metrics": metrics, "units": scores.UNITS, "scored": float(mask.mean())}
        result |= {"steps": [each._asdict() for each in times], "ringing": ringing.as_json(rings)}
        result |= {} if math.isnan(opened_n) else {"open_loop": {"rms_error": opened_n}}
        result |= {"bands": bands} if bands else {}
        read = {name: each._asdict() for name, each in recorded_units.recordings(system).items()}
        result |= {"recording": {**read, "notes": " ".join([*unreached, *said])}} if read else {}
        screen.show_json(result | {"saved": saved, "elapsed_s": elapsed_s})
        return
    with screen.waiting("looking at the linear loop"):
        one = [] if rings else one_place.lines(system, file, preset, overrides, run, mask)
    periods, alone = f"{run.sizes['time']:,}".replace(",", " "), advice.by_itself(run, mask, rings)
    rows = [*scores.metric_rows(metrics, opened_n, alone), *scores.step_rows(times, steps)] if mask.any() else []
    rows += bands_asked.rows(bands, mask, recorded_bands.ends_at_hz(system), alone) + scores.scored_rows(mask)
    screen.show(
        screen.columns([("system", origin), *describe.system_rows(system)]),
        "",
        screen.columns(rows),
        "",
        *([*advice_text.lines(rings, metrics, alone), ""] if rings else []),
        *([*late, ""] if (late := advice_text.too_late(system, metrics)) else []),
        *([*unreached, ""] if unreached else []),
        *([*one, ""] if one else []),
        *([*said, ""] if said else []),
        f"{duration_s:g} s of signal, {periods} control periods, simulated in {screen.seconds(elapsed_s)}",
        *screen.saved(saved, there),
    )


def _ask(system: System) -> None:
    from frictionloop.cli import contact_turns
    from frictionloop.parameters.unit_sanity import of_ceiling

    contact_turns.ask(system)
    screen.note_findings(of_ceiling(system))


def _steps(run: xr.Dataset, system: System, score_from_s: float) -> tuple[list[StepTime], int]:
    """Return the times of the steps that were followed, and how many steps there were."""
    if system.setpoint.kind != "steps":
        return [], 0
    import numpy as np

    from frictionloop.loop.step_times import step_times

    starts = run["time"].values[1:][np.diff(run["f_r"].values) != 0]
    return [each for each in step_times(run) if each.start_s >= score_from_s], int(np.sum(starts >= score_from_s))


def _run(system: System, duration_s: float, seed: int) -> tuple[xr.Dataset, float]:
    """Return the run and the seconds it took, without those that loading the compiled loop took."""
    from frictionloop.loop.timing import periods_in

    periods_in(system, duration_s)  # refuses a wrong duration before anything is compiled
    if "recording" in (system.setpoint.kind, system.disturbance.kind):
        from frictionloop.cli.recorded_units import recordings

        with screen.waiting("reading the recording"):
            recordings(system)
    with screen.waiting("loading the compiled loop"):
        from frictionloop.loop.simulate import simulate

        simulate(system, 1 / system.controller.rate_hz, seed)
    with screen.waiting("simulating"):
        start_s = time.perf_counter()
        return simulate(system, duration_s, seed), time.perf_counter() - start_s


def _save(
    run: xr.Dataset, system: System, paths: dict[str, Path | None], every: bool, given: set[str]
) -> dict[str, Path | None]:
    """Save what was asked for and return the paths; ``given`` are the values that a person gave, by dotted name."""
    if paths["run"] is not None:
        from frictionloop.loop.record import save

        save(run, paths["run"])
    if paths["plot"] is not None:
        from frictionloop.report.plot import plot as draw

        draw(run, paths["plot"])
    if paths["system"] is not None:
        from frictionloop.parameters import write_toml

        write_toml(system, paths["system"], every, given=given)
    return paths
