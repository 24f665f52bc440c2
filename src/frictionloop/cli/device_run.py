"""``frictionloop device run``: the loop on a device, recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import advice, advice_text, checks, flags, ringing, screen
from frictionloop.cli.device import SameAddress, connected
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr

ARGUMENTS = "ADDRESS [FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop device run sim: my-controller.toml --plot forces.svg
  frictionloop device run serial:///dev/ttyACM0 my-controller.toml --out run.h5
  frictionloop device run tcp://bench:5555 --setpoint.offset_n 0.5 --open

The PI gains that bench() begins with are the paper's, and ring on it: the run
says so, and names gains that hold.
"""
TURN_MM = 2.0
"""So near to a turn nothing counts: the friction changes its sign there. As in `simulate` at a
stiffness of 1000 N/m; that of a real finger is not known."""

ON_FINGER = (
    "on the finger, known of a simulated bench only; it is what simulate calls rms_error. f_m has the sensor's "
    "springs, lag and noise on top"
)

LONGEST_S = 86400.0
SCORED_S = 600.0
"""Of a longer run the last part is scored and drawn: what it takes in memory does not grow with the run."""


def command(
    address: SameAddress,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    decimation: flags.Run[flags.Whole] = 1,
    open_loop: Annotated[flags.Run[flags.Flag], Parameter(name="open")] = False,
    out: flags.Result[Path | None] = None,
    plot: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Load a controller into a device, close the loop, play the set-point and record.

    Of a run of more than ten minutes the last ten are scored and drawn.

    Parameters
    ----------
    file
        System whose controller is loaded first, and whose set-point is played; the preset without it.
    decimation
        Ticks per sample that is recorded.
    open_loop
        Lookup table alone, nothing fed back.
    out
        Save the recording here (HDF5, .h5).
    plot
        Draw the recording here (.svg, .pdf or .png).
    """
    checks.check_output("out", out, checks.RUN_FILES)
    checks.check_output("plot", plot, checks.FIGURES)
    checks.check_count("decimation", decimation, 1, 65535)
    if not 0 < duration_s <= LONGEST_S:
        raise FrictionloopError(f"duration_s = {duration_s:g} s: must be above 0 s and at most {LONGEST_S:g} s, a day")
    if duration_s > SCORED_S and out is None:
        raise FrictionloopError(f"out: needs a FILE.h5 for a run of more than {SCORED_S:g} s, which no memory holds")
    system, origin = flags.noted(file, preset, overrides, "bench")

    from frictionloop.firmware.board_fit import carrier_said, misfits

    if system.setpoint.kind in ("recording", "samples"):  # what asks is loaded for nothing else
        from frictionloop.cli import recorded_units

        recorded_units.ask(system, ("setpoint",))  # the disturbance is what there is
    for line in misfits(system):
        screen.note(f"warning: {line}")
    with connected(address, system) as device:
        device.upload(system)
        device.clear()  # of a fault that an earlier run ended with; refused while its cause lasts
        with _progress(duration_s, decimation / device.info.tick_hz) as progress:
            run = device.run(
                system.setpoint,
                duration_s,
                path=out,
                state="open" if open_loop else "closed",
                decimation=decimation,
                progress=progress,
            )
    samples, run = run.sizes["time"], last(run, SCORED_S)
    if plot is not None:
        from frictionloop.report.plot import plot as draw

        draw(with_counted(run), plot)
    found, mask = {**summary(run), "samples": samples, "scored_samples": run.sizes["time"]}, counted(run)
    with screen.waiting("scoring"):
        metrics = advice.of_recording(run, mask)
        rings = None if open_loop else advice.ringing(run, mask, metrics)
        largest_um = system.plate.max_amplitude_um
        limited = advice_text.at_ceiling(run, mask, system.board.ceiling_um or largest_um, largest_um)
    if json:
        screen.show_json({**found, "ringing": ringing.as_json(rings), "saved": {"run": out, "plot": plot}})
        return
    rows = [("device", address), ("system", origin), *worded(found)]
    if address != "sim:" and (carrier := carrier_said(system)):
        rows.append(("carrier", f"{carrier}, if the board's image was built from this system"))
    screen.show(
        screen.columns(rows),
        *(["", *advice_text.lines(rings, metrics), ""] if rings else []),
        *(["", *limited, ""] if limited else []),
        *(f"saved as {path}" for path in (out, plot) if path),
    )


def last(run: xr.Dataset, longest_s: float) -> xr.Dataset:
    """Return the last part of a run, read from its file if it is not in memory."""
    times = run["time"]
    rows = round(longest_s / float(times[1] - times[0])) if times.size > 1 else 1
    part = run.isel(time=slice(-max(rows, 1), None)).load()
    if part.sizes["time"] < times.size:
        run.close()
    return part


def counted(run: xr.Dataset) -> np.ndarray:
    """Return which samples count: recorded, of a finger that slides, away from its turns."""
    from frictionloop.device.counted import away_from_turns

    away = away_from_turns(run["position"].values, run["speed"].values, 1e-3 * TURN_MM)
    return (run["scored"] & run["sliding"]).values.astype(bool) & away


def with_counted(run: xr.Dataset) -> xr.Dataset:
    """Return a run for its figure, which scores the samples whose error is told."""
    return run.assign(scored=run["scored"].copy(data=counted(run)))


def summary(run: xr.Dataset) -> dict[str, Any]:
    """Return what a recording says of itself: error of the measured force where it counts, and what was lost."""
    import numpy as np

    counts = counted(run)
    error = (run["f_m"] - run["f_r"]).values[counts]
    rms = float(np.sqrt(np.nanmean(error**2))) if np.isfinite(error).any() else float("nan")
    names = ("lost_samples", "gaps", "reconnects", "broken_frames", "missed_frames")
    lost = {name: run.attrs[name] for name in names if name in run.attrs}
    about = {"samples": run.sizes["time"], "counted": float(counts.mean()), "measured_rms_error_n": rms, **lost}
    if "f_a" in run and counts.any():
        inner = (run["f_a"] - run["f_r"]).values[counts]
        about["rms_error_n"] = float(np.sqrt(np.nanmean(inner**2)))
    return about


def worded(found: dict[str, Any]) -> list[tuple[str, str]]:
    """Return these as rows."""
    lost, inner = int(found["lost_samples"]), found.get("rms_error_n")
    error = (
        f"{1e3 * found['measured_rms_error_n']:.3g} mN rms by the device's own sensor" if found["counted"] else "none"
    )
    return [
        ("recorded", f"{found['samples']:,} samples{_part(found)}"),
        ("counted", f"{100 * found['counted']:.3g} %: a finger slides, {TURN_MM:g} mm or more from where it turns"),
        ("f_m - f_r", error),
        *([] if inner is None else [("f_a - f_r", f"{1e3 * inner:.3g} mN rms {ON_FINGER}")]),
        ("lost", f"{lost:,} samples" if lost else "nothing"),
    ]


def _part(found: dict[str, Any]) -> str:
    scored = found["scored_samples"]
    return f"; what follows is of the last {scored:,}" if scored < found["samples"] else ""


@contextmanager
def _progress(duration_s: float, sample_s: float) -> Iterator[Callable[[int], None]]:
    """Yield what takes the number of samples recorded so far; the bar counts seconds."""
    from frictionloop.loop.progress import progress_bar

    shown = 0
    with progress_bar("recording, s", max(math.ceil(duration_s), 1)) as another:

        def go_to(samples: int) -> None:
            nonlocal shown
            while shown < math.floor(samples * sample_s + 1e-9):
                another()
                shown += 1

        yield go_to
