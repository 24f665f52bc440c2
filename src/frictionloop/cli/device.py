"""``frictionloop device``: a board on a port, or a simulated one."""

from __future__ import annotations

import json as lines
from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.effect import Name
from frictionloop.cli.verb import verb

ADDRESS = (
    "sim: (simulated bench), emulated:IMAGE (image on an emulated board), "
    "tcp://HOST:PORT, or a port: serial:///dev/ttyACM0, serial://COM3."
)
Address = Annotated[str, Parameter(name="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
SameAddress = Annotated[str, Parameter(name="ADDRESS", help="As in device info.", group=flags.SYSTEM)]
COLUMNS = (("s", 6, 2), ("f_r N", 6, 4), ("f_m N", 7, 4), ("u N", 6, 4), ("a um", 6, 3), ("position mm", 11, 2),
           ("speed mm/s", 10, 1), ("load N", 6, 3))  # fmt: skip
"""Heads of a reading, their width, and the places after the point; 80 columns with the state."""


@verb("list [OPTIONS]", "")
def list_ports(*, shown: screen.Shown = screen.BRIEFLY) -> None:
    """List the serial ports of this machine and the simulated board, by the address that `info` and `run` take."""
    shown.show(fl.device.list_ports())


@verb("clear ADDRESS [OPTIONS]", "serial:///dev/ttyACM0")
def clear(address: SameAddress, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Clear the fault that a device stopped with, and say which it was; refused while its cause lasts."""
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.clear(address)
    shown.show(found)


@verb("monitor ADDRESS [OPTIONS]", "sim: --duration-s 2", "serial:///dev/ttyACM0 --rate-hz 20")
def monitor(
    address: SameAddress,
    /,
    *,
    duration_s: flags.Run[float] = 10.0,
    rate_hz: flags.Run[float] = 10.0,
    json: flags.Result[flags.Flag] = False,
) -> None:
    """Print one line per sample, without asking the plate for anything: `device run` closes the loop.

    Parameters
    ----------
    duration_s
        How long to look, in s.
    rate_hz
        Lines a second, at most 100.
    json
        A JSON object a line.
    """
    head = "  ".join([*(f"{name:>{width}}" for name, width, _ in COLUMNS), "state"])
    for k, reading in enumerate(fl.device.monitor(address, duration_s, rate_hz)):
        if k == 0 and not json:
            print(head)
        values = [f"{value:{width}.{places}f}" for value, (_, width, places) in zip(reading, COLUMNS, strict=False)]
        print(lines.dumps(reading._asdict()) if json else "  ".join([*values, reading.state]), flush=True)


OpenLoop = Annotated[flags.Flag, Parameter(name="open", help="Lookup table alone, nothing fed back.", group=flags.RUN)]
Recording = Annotated[Path | None, Parameter(help="Save the recording here (HDF5, .h5).", group=flags.RESULT)]
Drawing = Annotated[Path | None, Parameter(help="Draw the recording here (.svg, .pdf or .png).", group=flags.RESULT)]
Compared = Annotated[Path | None, Parameter(name="FILE", help="System (.toml) to compare with.", group=flags.SYSTEM)]


@verb(
    "info ADDRESS [FILE] [OPTIONS]",
    "sim:",
    "serial:///dev/ttyACM0 my-controller.toml",
    "emulated:my-image my-controller.toml",
)
def info(address: Address, file: Compared = None, /, *, shown: screen.Shown = screen.BRIEFLY) -> None:
    """Say who answers at an address, what runs there, with which values, and what it has counted since reset."""
    given = flags.bench_of(file)
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.info(address, given.system)
    shown.show(found.with_findings(given.findings))


@verb(
    "set ADDRESS NAME=VALUE... [--system FILE]",
    "sim: controller.kp=0.05 controller.ki=100",
    "sim: drive.ceiling_um=2 setpoint.hold_n=0.5",
    "serial:///dev/ttyACM0 --system my-controller.toml",
)
def set_parameters(
    address: SameAddress,
    /,
    *assignments: Annotated[flags.Described[str], Parameter(name="NAME=VALUE")],
    system: flags.Described[Path | None] = None,
    unchecked: flags.Described[flags.Flag] = False,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Set parameters of a device, all at once; if one is wrong, none is. A reset forgets them.

    Refused while another host's loop is on.

    Parameters
    ----------
    assignments
        A parameter and its value: of the table, such as drive.ceiling_um=2, or of the controller, such as
        controller.kp=0.05.
    system
        Set the whole table from this system (.toml), and the values given on top. Without it a board tells the gains
        of law pi alone, and no analysis says whether new ones hold.
    unchecked
        Set gains that by analysis do not hold too.
    """
    values = _pairs(assignments)
    if not values and system is None:
        raise fl.FrictionloopError("set: needs NAME=VALUE or --system FILE")
    given = flags.bench_of(system)
    with fl.progress.waiting(f"connecting {address}"):
        found = fl.device.configure(address, values, given.system, unchecked=unchecked)
    shown.show(found.with_findings(given.findings))


def _pairs(assignments: Iterable[str]) -> dict[str, Any]:
    pairs: dict[str, Any] = {}
    for text in assignments:
        name, _, value = text.partition("=")
        if not name or not value:
            raise fl.FrictionloopError(f"{text!r}: must be NAME=VALUE, such as controller.kp=0.05")
        if name in pairs:
            raise fl.FrictionloopError(f"{name} = {value}: is given twice")
        pairs[name] = flags.scalar(value)
    return pairs


@verb(
    "run ADDRESS [FILE] [OPTIONS]",
    "sim: my-controller.toml --plot forces.svg",
    "serial:///dev/ttyACM0 my-controller.toml --out run.h5",
    "tcp://bench:5555 --setpoint.offset_n 0.5 --open",
)
def run(
    address: SameAddress,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    decimation: flags.Run[flags.Whole] = 1,
    open_loop: OpenLoop = False,
    out: Recording = None,
    plot: Drawing = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Load a controller into a device, close the loop, play the set-point and record.

    Of a run of more than ten minutes the last ten are scored and drawn.

    Parameters
    ----------
    file
        System whose controller is loaded first, and whose set-point is played; the preset without it.
    decimation
        Ticks per sample that is recorded.
    """
    file_arguments.check_run(out, plot)
    file_arguments.check_count("decimation", decimation, 1, 65535)
    given = flags.system_given(file, preset, overrides, "bench")
    doubted = fl.doubts(given.system, ("setpoint",))  # the disturbance is what there is
    with fl.progress.waiting(f"running on {address}"):
        found = fl.device.run(address, given.system, duration_s, decimation=decimation, open_loop=open_loop, out=out)
    if plot is not None:
        fl.plot(found.recording, plot)
    shown.show(found.with_findings([*given.findings, *doubted]), saved={"run": out, "figure": plot})


@verb(
    "play ADDRESS EFFECT [FILE] [OPTIONS]",
    "sim: bump --plot forces.svg",
    "serial:///dev/ttyACM0 my-effect.toml my-bench.toml --out run.h5",
    "sim: button --duration-s 2 --tables button.json",
)
def play(
    address: SameAddress,
    effect: Name,
    file: Annotated[flags.Described[Path | None], Parameter(name="FILE")] = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    duration_s: flags.DurationS = 10.0,
    open_loop: OpenLoop = False,
    out: Recording = None,
    plot: Drawing = None,
    tables: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Load a controller and an effect into a device, close the loop and record what it measures.

    Parameters
    ----------
    file
        System whose controller is loaded first; the bench with a notch PI without it.
    tables
        Write what the device is given of the effect here (.json): steps, values, and the words themselves.
    """
    file_arguments.check_run(out, plot)
    file_arguments.check_output("tables", tables, (".json",))
    named = ["setpoint.kind=effect", f"setpoint.effect={effect}"]
    given = flags.system_given(file, preset, [*(overrides or []), *named], "bench", closing=True)
    with fl.progress.waiting(f"playing {effect} on {address}"):
        found = fl.device.play(address, given.system, duration_s, open_loop=open_loop, out=out)
    if tables is not None:
        found.write_tables(tables)
    if plot is not None:
        fl.plot(found.recording, plot)
    shown.show(found.with_findings(given.findings), saved={"run": out, "figure": plot, "tables": tables})


@verb("recover FILE [--out FILE] [OPTIONS]", "run.partial-1a2b3c4d.h5", "run.partial-1a2b3c4d.h5 --out mended.h5")
def recover(
    file: Annotated[flags.Described[Path], Parameter(name="FILE")],
    /,
    *,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Write what an unfinished recording holds as a finished file, and say what that is; FILE stays as it is.

    Parameters
    ----------
    file
        The file that the recording left, with .partial- in its name.
    out
        Save it here (.h5); by default under the name that the recording was to have, if that is free.
    """
    file_arguments.check_output("out", out, file_arguments.RUN_FILES)
    with fl.progress.waiting("reading"):
        found = fl.device.recover(file, out)
    shown.show(found)


@verb("flash IMAGE", "my-image/teensy41.hex")
def flash(
    image: Annotated[flags.Described[Path], Parameter(name="IMAGE")], /, *, shown: screen.Shown = screen.BRIEFLY
) -> None:
    """Flash an image: press the button on the board when asked to.

    Parameters
    ----------
    image
        Intel hex file of `firmware build`.
    """
    with fl.progress.waiting("press the button on the board"):
        found = fl.device.flash(image)
    shown.show(found)
