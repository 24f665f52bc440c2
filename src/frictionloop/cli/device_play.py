"""``frictionloop device play``: an effect on a device, recorded; and the tables that it is given."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.device import SameAddress, connected
from frictionloop.cli.device_run import LONGEST_S, SCORED_S, counted, last, summary, with_counted, worded
from frictionloop.cli.effect import LAW, Name
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.firmware.effect_tables import EffectTables
    from frictionloop.parameters import System

ARGUMENTS = "ADDRESS EFFECT [FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop device play sim: bump --plot forces.svg
  frictionloop device play serial:///dev/ttyACM0 my-effect.toml my-bench.toml --out run.h5
  frictionloop device play sim: button --duration-s 2 --tables button.json
"""


def command(
    address: SameAddress,
    effect: Name,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    open_loop: Annotated[flags.Run[flags.Flag], Parameter(name="open")] = False,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    tables: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Load a controller and an effect into a device, close the loop and record what it measures.

    Parameters
    ----------
    file
        System whose controller is loaded first; the bench with a notch PI without it.
    open_loop
        Lookup table alone, nothing fed back.
    out
        Save the recording here (HDF5, .h5).
    plot
        Draw the recording here (.svg, .pdf or .png).
    tables
        Write what the device is given of the effect here (.json): steps, values, and the words themselves.
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_output("tables", tables, (".json",))
    longest_s = LONGEST_S if out is not None else SCORED_S
    if not 0 < duration_s <= longest_s:
        raise FrictionloopError(f"duration_s = {duration_s:g} s: must be above 0 s and at most {longest_s:g} s")
    system, origin = _system(effect, file, preset, overrides)

    from frictionloop.device.effects import played

    with connected(address, system) as device:
        made = played(system.setpoint, system, device.info.waveform)
        assert made is not None
        device.upload(system)
        device.clear()  # of a fault that an earlier run ended with; refused while its cause lasts
        with screen.waiting("recording"):
            run = device.run(made.source, duration_s, path=out, state="open" if open_loop else "closed")
    given = made.tables
    if tables is not None:
        from frictionloop.firmware.effect_files import write_tables

        write_tables(given, tables)
    samples, run = run.sizes["time"], last(run, SCORED_S)
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(with_counted(run), plot)
    found = {**summary(run), "samples": samples, "scored_samples": run.sizes["time"]}
    found["counted"] = float(counted(run).mean())
    saved = {"run": out, "figure": plot, "tables": tables}
    if json:
        screen.show_json({**_as_json(given), **found, "saved": saved})
        return
    rows = [("device", address), ("system", origin), ("effect", effect), *_given_rows(given), *worded(found)]
    screen.show(screen.columns(rows), *screen.saved(saved))


def _system(effect: str, file: Path | None, preset: Any, overrides: list[str] | None) -> tuple[System, str]:
    """Return the bench with an effect as set-point; the preset has a law that closes its loop well."""
    wanted = flags.overrides_of(overrides)
    own = file is None and preset in (None, "bench") and not any(name.startswith("controller.") for name in wanted)
    added = [f"{name}={value}" for name, value in (LAW if own else {}).items()]
    named = ["setpoint.kind=effect", f"setpoint.effect={effect}"]
    return flags.noted(file, preset, [*added, *(overrides or []), *named], "bench")


def _as_json(given: EffectTables) -> dict[str, Any]:
    return {"words": len(given.words), "steps": len(given.program.code), "error_n": given.error_n, "told": given.told}


def _given_rows(given: EffectTables) -> list[tuple[str, str]]:
    steps = len(given.program.code)
    return [
        ("given", f"{steps} {'step' if steps == 1 else 'steps'} and their values, {len(given.words)} words"),
        *(("coarser", line) for line in given.told),
    ]
