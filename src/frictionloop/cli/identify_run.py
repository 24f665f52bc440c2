"""``frictionloop identify run``: record weights, hits, silence or slides from a device, step by step."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.device import ADDRESS, connected
from frictionloop.cli.wizard import TICK_HZ, Line, Step, line_of, steps_of, with_counts
from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from numpy.typing import NDArray

ARGUMENTS = "weights|hits|quiet|friction --device ADDRESS [OPTIONS]"
EXAMPLES = """Examples

  frictionloop identify run quiet --device sim:
  frictionloop identify run weights --device serial:///dev/ttyACM0 \\
      --masses-g 0,50,100,150,200,150,100,50,0 --out weights.h5
"""
Kind = Annotated[
    Literal["weights", "hits", "quiet", "friction"],
    Parameter(name="KIND", help="What is recorded.", group=flags.SYSTEM),
]
DeviceAt = Annotated[str, Parameter(name="--device", metavar="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
COLUMNS = {"weights": ("f_m",), "hits": ("f_m",), "quiet": ("f_m",), "friction": ("f_m", "load", "position")}
UNITS = {"counts": "counts", "f_m": "N", "load": "N", "position": "m", "mass": "kg"}
LIVE_S = 0.1
FILES = (".h5",)


def command(
    kind: Kind,
    /,
    *,
    device: DeviceAt,
    masses_g: flags.Run[str | None] = None,
    out: flags.Result[Path | None] = None,
    json: flags.Json = False,
) -> None:
    """Record one measurement of a calibration: each step is asked for, the level is shown while it is recorded.

    A recording and its channel map are written, and the lines that a project file needs for them. The plate stays off.
    The recording holds the counts of the converter, for which ``identify bench`` finds the board's scale.
    At ``sim:`` nobody is asked: rigs stand in for hands that hang weights, tap, and let go.

    Parameters
    ----------
    masses_g
        Weights in g in the order in which they are hung, such as 0,50,100,50,0; without it up to 200 g and down again.
    out
        Recording (.h5); its map stands beside it. Without it KIND.h5.
    """
    out = out or Path(f"{kind}.h5")
    checks.check_output("out", out, FILES)
    chart = out.with_name(f"{out.stem}-map.toml")
    for path in (out, chart):
        checks.check_new("out", path)
    steps = steps_of(kind, *([_masses(masses_g)] if masses_g else []))
    simulated = device.startswith("sim:")
    with connected(device) as opened:
        line = line_of(kind, steps, opened, simulated)
        columns = _recorded(kind, steps, line, asked=not simulated)
        unit_n = with_counts(columns, opened)
    _write(out, columns)
    chart.write_text(_map(kind, unit_n), encoding="utf-8")
    lines = ["[[recording]]", f'kind = "{"slides" if kind == "friction" else kind}"', f'files = ["{out.name}"]']
    lines.append(f'map = "{chart.name}"')
    lost = _lost(columns["time"])
    if json:
        told = {"kind": kind, "samples": columns["time"].size, "lost_samples": lost, "project": "\n".join(lines)}
        screen.show_json(told | {"saved": {"recording": out, "map": chart}})
        return
    seconds = columns["time"].size / TICK_HZ
    screen.show(f"recorded {seconds:.1f} s" + (f", {lost} samples were lost" if lost else ", nothing was lost"))
    screen.show(*screen.saved({"the recording": out, "its channel map": chart}))
    screen.show("", "in the project file:", *lines)


def _masses(text: str) -> tuple[float, ...]:
    try:
        return tuple(float(each) for each in text.split(","))
    except ValueError:
        raise FrictionloopError(f"masses_g = {text!r}: must be numbers in g with commas between them") from None


def _recorded(kind: str, steps: list[Step], line: Line, asked: bool) -> dict[str, NDArray[np.float64]]:
    """Return the columns of all steps, one after the other; times of steps follow each other without a gap."""
    parts: list[dict[str, NDArray[np.float64]]] = []
    began_s = 0.0
    for number, step in enumerate(steps):
        screen.say(f"step {number + 1} of {len(steps)}: {step.says}")
        if asked:
            input("Enter begins: ")
        blocks = list(_live(line.stream(step.lasts_s, 1)))
        if not blocks:
            raise FrictionloopError("device: sends no samples; accepted: a device whose telemetry comes through")
        tick = np.concatenate([block["tick"] for block in blocks])
        part = {name: np.concatenate([block[name] for block in blocks]) for name in COLUMNS[kind]}
        part["time"] = began_s + ((tick - tick[0]) % 2**32) / TICK_HZ
        if step.mass_kg is not None:
            part["mass"] = np.full(tick.size, step.mass_kg)
        began_s = float(part["time"][-1]) + 1 / TICK_HZ
        parts.append(part)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _live(stream: Iterator[Any]) -> Iterator[Any]:
    """Pass blocks on; on a terminal show the level and how much it moves, ten times a second."""
    shown = sys.stderr.isatty()
    held: list[NDArray[np.float64]] = []
    for block in stream:
        yield block
        held.append(block["f_m"])
        if shown and sum(map(len, held)) >= LIVE_S * TICK_HZ:
            level = np.concatenate(held)
            bar = "#" * int(min(max(np.abs(level).max() / 2.5, 0), 1) * 30)
            print(f"\r{level.mean():+8.4f} N  +- {np.ptp(level) / 2:.4f}  |{bar:30}|", end="", file=sys.stderr)
            held = []
    if shown:
        print(file=sys.stderr)


def _write(path: Path, columns: dict[str, NDArray[np.float64]]) -> None:
    import h5py

    from frictionloop.quantities import replacing

    with replacing(path) as beside, h5py.File(beside, "w") as file:
        file.attrs["fs"] = float(TICK_HZ)
        for name, values in columns.items():
            file[name] = values
            file[name].attrs["units"] = "s" if name == "time" else UNITS[name]


def _map(kind: str, unit_n: float | None) -> str:
    names = (*COLUMNS[kind], *(("mass",) if kind == "weights" else ()))
    lines = [f"# Channels of identify run {kind}."]
    for name in names:
        column = "counts" if name == "f_m" and unit_n is not None else name
        lines += ["", f"[channels.{name}]", f'column = "{column}"', f'unit = "{UNITS[column]}"']
        if column == "counts":
            lines.append(f"newtons_per_unit = {unit_n:.9g}  # by the device's calibration, where there are no weights")
    return "\n".join(lines) + "\n"


def _lost(time: NDArray[np.float64]) -> int:
    return int(np.sum(np.rint(np.diff(time) * TICK_HZ) - 1)) if time.size > 1 else 0
