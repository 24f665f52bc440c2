"""``frictionloop compare``: control laws on one bench, on fingers that none of them was tuned on."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import checks, compare_effects, flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.design.comparison import Comparison
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop compare --fingers 26
  frictionloop compare my-bench.toml --fingers 1000 --seed 11 \
      --out results.h5 --resume
  frictionloop compare --fingers 50 --laws lookup,retuned_pi --speeds 20 \
      --csv scores.csv --plots figures
  frictionloop compare --effects grating,bump --fingers 26 \
      --laws lookup,notch_pi,limit_observer
"""
MOST_FINGERS = 1_000_000
DURATION_S = 11.0
SOON_S = 5.0
"""What takes less is not announced (chosen)."""
CELL_S, RUN_S, DESIGN_S = 0.1, 3e-4, 15.0
"""Time of a cell, of a second of a finger in it, and of a design, in s (measured once)."""
STROKES = ("speed_mm_s", "stroke_mm", "contact_s", "lifted_s")
PROTOCOLS = ("setpoint.", *(f"motion.{name}" for name in STROKES))
"""Starts of the names that the protocol gives values to."""
FORCES = "; `frictionloop sweep FILE --fingers 100` scores one controller at your own"


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Compared = None,
    fingers: flags.Run[flags.Whole] = 1000,
    seed: flags.Run[flags.Whole | None] = None,
    laws: flags.Run[str | None] = None,
    speeds: flags.Run[str] = "20,80,150",
    effects: flags.Run[str | None] = None,
    duration_s: flags.Run[float] = DURATION_S,
    jobs: flags.Run[flags.Whole | None] = None,
    out: flags.Result[Path | None] = None,
    resume: flags.Result[flags.Flag] = False,
    csv: flags.Result[Path | None] = None,
    plots: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Compare control laws: sines, holds, steps and landings on unseen fingers, at three speeds and two slip lengths.

    Parameters
    ----------
    fingers
        Number of random fingers that are scored.
    seed
        Seed of these fingers; 11 if not given. Any but 3, that of the fingers laws are tuned on.
    laws
        Laws to compare, all if not given: lookup, printed_pi and retuned_pi (kind pi), notch_pi, limit_observer,
        hinf (filtered_pi).
    speeds
        Speeds of the strokes in mm/s.
    effects
        Compare on these effects instead, names or TOML files: how much of each arrives. Without it on the set-point of
        FILE, if that is an effect.
    duration_s
        Duration of a run in s; the first second does not count.
    jobs
        Parallel workers; one per core if not given.
    out
        Keep the results here (HDF5, .h5), also on Ctrl-C.
    resume
        Continue what is kept in --out, also with more laws.
    csv
        Write every score here (.csv), one row each.
    plots
        Folder for figures: residuals, steps, sensitivities, each as .svg and .png.
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("csv", csv, checks.TABLES)
    checks.check_count("fingers", fingers, 1, MOST_FINGERS)
    checks.check_folder("plots", plots)
    checks.check_workers(jobs, resume, out, "comparison")
    _check_overrides(overrides)
    system, origin = flags.noted(file, preset, overrides, "bench", designed="notch_pi")

    from frictionloop.cli import recorded_units

    system = _without_recorded_set_point(system)
    recorded_units.ask(system, ("disturbance",))
    screen.tell_notes()  # before the comparison, which takes minutes
    felt = compare_effects.wanted(system, effects)
    if felt:
        longer = duration_s if duration_s != DURATION_S else None
        compare_effects.refuse({"out": out, "resume": resume, "jobs": jobs, "plots": plots, "duration_s": longer})
    with screen.waiting("loading what compares"):
        from frictionloop.design import comparison as rooms

    at = rooms.EVALUATION_SEED if seed is None else seed
    if felt:
        compare_effects.compare(system, origin, felt, fingers, at, _names(laws), checks.speeds_of(speeds), csv, json)
        return
    options: dict[str, Any] = {"path": out, "resume": resume, "n_jobs": jobs, "duration_s": duration_s}
    options |= {"begin": lambda cells: _say_how_long(cells, fingers * duration_s, jobs)}
    start_s = time.perf_counter()
    try:
        ran = rooms.compare(system, fingers, at, _names(laws), checks.speeds_of(speeds), **options)
    except rooms.ComparisonInterrupted as stop:
        raise screen.interrupted(f"{stop.done} of {stop.total} cells done", out) from None
    with screen.waiting("scoring, and margins of each law"):
        scored = rooms.scores(ran)
        rows, margins = rooms.score_rows(scored), rooms.margin_rows(ran)
    saved: dict[str, Any] = {"results": out, "table": csv, "figures": plots}
    if csv is not None:
        checks.write_csv(csv, rooms.tidy_rows(rows, margins))
    if plots is not None:
        with screen.waiting("drawing"):
            from frictionloop.report.figures.comparison import drawings

            drawn = {name: figure() for name, _, figure in drawings(ran, scored)}
        checks.write_figures("plots", plots, drawn)
    if json:
        from frictionloop.cli.comparison_advice import recommended

        found = {"scores": rows, "margins": margins, "saved": saved}
        found |= {"recommended": recommended(rows, margins)._asdict()}
        screen.show_json(_about(system, ran, scored) | found)
    else:
        from frictionloop.cli.comparison_text import summary

        took = screen.seconds(time.perf_counter() - start_s)
        said = f"{origin}, {fingers} fingers of seed {at}, runs of {duration_s:g} s, in {took}"
        screen.show(screen.columns([("bench", said)]), "", *summary(ran, scored, rows, margins), *screen.saved(saved))


def _without_recorded_set_point(system: System) -> System:
    """Return a system whose set-point has levels, which designs and margins need, and say that no law follows it."""
    from frictionloop.analysis.levels import RECORDED, at_levels

    if system.setpoint.kind not in RECORDED:
        return system
    screen.note(
        f"setpoint: laws are tuned for the range of the recording and compared on the protocol's own forces{FORCES}"
    )
    return system.evolve({"setpoint": at_levels(system).setpoint})


def _say_how_long(laws: Sequence[str], run_s: float, jobs: int | None) -> None:
    """Say how long cells of these laws take, each of so many seconds of fingers; nothing of what is soon done."""
    from frictionloop.design.comparison.entrants import DESIGNED

    screen.tell_notes()
    workers = jobs or os.cpu_count() or 1
    cells_s = (CELL_S + RUN_S * run_s / workers) * len(laws)
    design_s = sum(DESIGN_S for law in DESIGNED if law in laws)
    if cells_s + design_s < SOON_S:
        return
    first = f", of that {screen.about(design_s)} to design laws" if design_s else ""
    many = f"{workers} worker{'s' * (workers > 1)}"
    screen.say(f"{len(laws)} cells to run: about {screen.about(cells_s + design_s)} with {many}{first}")


def _names(laws: str | None) -> list[str] | None:
    return None if laws is None else [name.strip() for name in laws.split(",")]


def _check_overrides(overrides: list[str] | None) -> None:
    """Refuse values that the protocol, a finger or a law would replace."""
    given = flags.overrides_of(overrides)
    if not given:
        return
    from frictionloop.parameters.timing import Timing
    from frictionloop.physics.fingers import fingers

    one, timing = fingers(1, 0)[0], tuple(f"controller.{name}" for name in Timing.model_fields)
    for path in given:
        if path in one:
            raise FrictionloopError(f"{path}: every finger of a comparison brings its own; leave it out")
        if path.startswith(PROTOCOLS):
            raise FrictionloopError(
                f"{path}: the protocol of a comparison sets it; leave it out" + FORCES * path.startswith("setpoint.")
            )
        if path.startswith("controller.") and not path.startswith(timing):
            raise FrictionloopError(f"{path}: every law of a comparison brings its own; leave it out")


def _about(system: System, ran: Comparison, scored: xr.Dataset) -> dict[str, Any]:
    """Return what was run, for a program."""
    about: dict[str, Any] = {"system": system.model_dump(), "laws": ran.laws, "left_out": ran.left_out}
    about |= {"seed": ran.seed, "fingers": len(ran.people)}
    about |= {"speeds_mm_s": ran.speeds_mm_s, "duration_s": ran.duration_s, "score_from_s": ran.start_s}
    able = {f"{v:g}": scored["capable"].sel(speed_mm_s=v).values for v in ran.speeds_mm_s}
    return about | {"capable": able}
