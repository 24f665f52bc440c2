"""``frictionloop simulate``: one run, how good it is, its traces."""

from __future__ import annotations

from pathlib import Path

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb


@verb(
    "simulate [FILE] [OPTIONS]",
    "--preset feasible --controller.kp 12",
    "--setpoint.kind sine --plot forces.svg",
    "--preset feasible --save-system my-bench.toml",
    "my-bench.toml --duration-s 2 --out run.h5",
    "my-bench.toml --disturbance.kind recording --disturbance.path slide.csv --disturbance.column force_n",
    "my-bench.toml --setpoint.kind recording --setpoint.path wanted.csv --setpoint.column force_n",
)
def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    seed: flags.SeedOfRun = 0,
    score_from_s: flags.ScoreFromS = 0.0,
    split_hz: flags.Run[str | None] = None,
    advise: flags.Run[flags.Flag] = False,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    save_system: flags.Result[Path | None] = None,
    whole: flags.Result[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Simulate one run, and say how well the force followed.

    That is one finger with one slip length at one speed; ``design check`` says whether the gains hold for others.

    Parameters
    ----------
    split_hz
        Frequencies with commas between, such as 8 or 4,20: what is left of the disturbance below, between and above.
    advise
        Design a controller for this system too.
    out
        Save the traces here (HDF5, .h5).
    plot
        Draw forces, amplitude and motion here (.svg, .pdf or .png).
    save_system
        Write the system here (.toml): a start for a file of your own.
    whole
        Write there also what a simple bench never needs.
    """
    file_arguments.check_run(out, plot)
    file_arguments.check_output("save_system", save_system, file_arguments.SYSTEMS, new=True)
    if whole and save_system is None:
        raise fl.outputs.must_be("whole", True, "with --save-system FILE.toml")
    file_arguments.check_count("seed", seed, 0)
    file_arguments.check_score(score_from_s, duration_s)
    what = "Hz with commas between, such as 8 or 4,20"
    edges_hz = () if split_hz is None else file_arguments.numbers_of("split_hz", split_hz, what)
    given = flags.system_given(file, preset, overrides)
    with fl.progress.waiting("simulating"):
        run = fl.simulate(given.system, duration_s, seed)
    with fl.progress.waiting("designing" if advise else "scoring"):
        found = fl.diagnose(run, score_from_s, advise, edges_hz)
    if out is not None:  # what is loaded again counts the same periods
        fl.save(fl.scored_from(run, score_from_s) if score_from_s else run, out)
    if plot is not None:
        fl.plot(run, plot)
    if save_system is not None:
        fl.write_toml(given.system, save_system, whole, given=set(flags.overrides_of(overrides)))
    shown.show(found.with_findings(given.findings), saved={"run": out, "plot": plot, "system": save_system})
