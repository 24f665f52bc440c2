"""``frictionloop compare``: control laws on one bench, on fingers that none of them was tuned on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import frictionloop as fl
from frictionloop import FrictionloopError
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb

MOST_FINGERS = 1_000_000
SEED, DURATION_S = 11, 11.0
SOON_S = 10.0
"""What takes less is not announced (chosen)."""


@verb(
    "compare [FILE] [OPTIONS]",
    "--fingers 26",
    "my-bench.toml --fingers 1000 --seed 11 --out results.h5 --resume",
    "--fingers 50 --laws lookup,retuned_pi --speeds 20 --csv scores.csv --plots figures",
    "--effects grating,bump --fingers 26 --laws lookup,notch_pi,limit_observer",
)
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
    jobs: flags.Jobs = None,
    out: flags.Result[Path | None] = None,
    resume: flags.Result[flags.Flag] = False,
    csv: flags.Result[Path | None] = None,
    plots: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Compare control laws on fingers that none was tuned on.

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
    out
        Keep the results here (HDF5, .h5), also on Ctrl-C.
    resume
        Continue what is kept in --out, also with more laws.
    csv
        Write every score here (.csv), one row each.
    plots
        Folder for figures: residuals, steps, sensitivities, each as .svg and .png.
    """
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    file_arguments.check_output("csv", csv, file_arguments.TABLES)
    file_arguments.check_count("fingers", fingers, 1, MOST_FINGERS)
    file_arguments.check_folder("plots", plots)
    file_arguments.check_workers(jobs, resume, out, "comparison")
    given = flags.system_given(file, preset, overrides, "bench", designed="notch_pi")
    doubts = fl.doubts(given.system, ("disturbance",))
    names = None if laws is None else [name.strip() for name in laws.split(",")]
    speeds_mm_s = list(file_arguments.numbers_of("speeds", speeds, "numbers in mm/s with commas between"))
    common: tuple[Any, ...] = (names, fingers, SEED if seed is None else seed, speeds_mm_s)
    brought = tuple(flags.overrides_of(overrides))
    found: Any
    if effects is not None or given.system.setpoint.kind == "effect":
        longer = duration_s if duration_s != DURATION_S else None
        others = {"out": out, "resume": resume, "jobs": jobs, "plots": plots, "duration_s": longer}
        if refused := next((name for name, value in others.items() if value), None):
            raise FrictionloopError(f"{refused} = {others[refused]}: not with effects; accepted: --csv, --json")
        named = None if effects is None else [name.strip() for name in effects.split(",")]
        found = fl.compare_effects(given.system, named, *common, given=brought)
    else:
        options: dict[str, Any] = {"path": out, "resume": resume, "n_jobs": jobs, "duration_s": duration_s}
        try:
            found = fl.compare(given.system, *common, given=brought, begin=_say_how_long, **options)
        except fl.ComparisonInterrupted as stop:
            raise screen.interrupted(f"{stop.done} of {stop.total} cells done", out) from None
    if csv is not None:
        file_arguments.write_csv(csv, found.tidy())
    if plots is not None:
        with fl.progress.waiting("drawing"):
            file_arguments.write_figures("plots", plots, found.figures())
    shown.show(found.with_findings((*given.findings, *doubts)), saved={"results": out, "table": csv, "figures": plots})


def _say_how_long(cells: int, about_s: float) -> None:
    """Say how long it takes; nothing of what is soon done."""
    if about_s >= SOON_S:
        screen.say(f"{cells} cells to run: about {screen.about(about_s)}")
