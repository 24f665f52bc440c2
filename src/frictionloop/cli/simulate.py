"""``frictionloop simulate``: one run, its metrics, its traces."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import flags, screen
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    import xarray as xr

    from frictionloop.parameters import System

EXAMPLES = """\
Examples

  frictionloop simulate --preset feasible --controller.kp 12
  frictionloop simulate --setpoint.kind sine --setpoint.frequency_hz 5 --plot forces.svg
  frictionloop simulate --preset feasible --save-system my-bench.toml
  frictionloop simulate my-bench.toml --duration-s 2 --out run.h5
"""

RUN_FILES = (".h5", ".hdf5", ".nc")


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.Preset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    seed: Annotated[int, Parameter(help="Seed of all noise: the same seed gives the same run.", group=flags.RUN)] = 0,
    score_from_s: flags.ScoreFromS = 0.0,
    out: Annotated[Path | None, Parameter(help="Save the traces here (HDF5, .h5).", group=flags.RESULT)] = None,
    plot: Annotated[
        Path | None, Parameter(help="Draw set-point and force here (.svg, .pdf or .png).", group=flags.RESULT)
    ] = None,
    save_system: Annotated[
        Path | None,
        Parameter(help="Write the system here (TOML): a start for a file of your own.", group=flags.RESULT),
    ] = None,
    json: Annotated[bool, Parameter(help="Print one JSON object instead of the summary.", group=flags.RESULT)] = False,
) -> None:
    """Simulate one run of the loop and say how well the force followed its set-point."""
    from frictionloop.cli import describe, plot as drawing
    from frictionloop.loop.record import save
    from frictionloop.parameters import write_toml

    check_suffix(out, RUN_FILES, "out")
    check_suffix(plot, drawing.FORMATS, "plot")
    flags.check_seed(seed)
    flags.check_score(score_from_s, duration_s)
    system = flags.system_from(file, preset, overrides)
    if save_system is not None and save_system.exists():
        raise FrictionloopError(f"{save_system}: exists already and is not replaced; choose another --save-system")
    run, elapsed_s = _timed(system, duration_s, seed)
    metrics = describe.metrics_of(run, score_from_s)
    if save_system is not None:
        write_toml(system, save_system)
    if out is not None:
        save(run, out)
    if plot is not None:
        drawing.draw(run, plot)
    saved = {"system": save_system, "run": out, "plot": plot}
    if json:
        screen.show_json(
            {
                "system": system.model_dump(),
                "duration_s": duration_s,
                "seed": seed,
                "score_from_s": score_from_s,
                "metrics": metrics,
                "units": describe.UNITS,
                "saved": saved,
                "elapsed_s": elapsed_s,
            }
        )
    ...
