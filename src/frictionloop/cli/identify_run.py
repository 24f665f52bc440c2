"""``frictionloop identify run``: record weights, hits, silence or slides from a device, step by step."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.device import ADDRESS, connected

ARGUMENTS = "weights|hits|quiet|friction --device ADDRESS [OPTIONS]"
EXAMPLES = (
    "quiet --device sim:",
    "weights --device serial:///dev/ttyACM0 --masses-g 0,50,100,150,200,150,100,50,0 --out weights.h5",
)
Kind = Annotated[
    Literal["weights", "hits", "quiet", "friction"],
    Parameter(name="KIND", help="What is recorded.", group=flags.SYSTEM),
]
DeviceAt = Annotated[str, Parameter(name="--device", metavar="ADDRESS", help=ADDRESS, group=flags.SYSTEM)]
LEVELS = 500
"""Samples between two looks at the level: a tenth of a second."""
FILES = (".h5",)


def command(
    kind: Kind,
    /,
    *,
    device: DeviceAt,
    masses_g: flags.Run[str | None] = None,
    out: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
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
    file_arguments.check_output("out", out, FILES)
    for path in (out, fl.identify.map_beside(out)):
        file_arguments.check_new("out", path)
    masses = () if masses_g is None else (file_arguments.numbers_of("masses_g", masses_g, "g"),)
    fl.identify.steps_of(kind, *masses)  # refuses masses before a device is opened
    with connected(device) as opened:
        level = _Level()
        asked = _said if device.startswith("sim:") else _asked
        found = fl.identify.run(kind, opened, *masses, ask=asked, watch=level)
        level.end()
    shown.show(found.saved_at(out), saved={"recording": out, "map": found.write(out)})


def _said(step: Any) -> None:
    screen.say(f"step {step.number} of {step.of}: {step.says}")


def _asked(step: Any) -> None:
    _said(step)
    input("Enter begins: ")


class _Level:
    """The level and how much it moves, on a terminal, ten times a second."""

    def __init__(self) -> None:
        self._held: list[float] = []
        self._shown = sys.stderr.isatty()

    def __call__(self, block: Any) -> None:
        self._held += block["f_m"].tolist() if self._shown else []
        if len(self._held) >= LEVELS:
            low, high = min(self._held), max(self._held)
            bar = "#" * int(min(max(abs(low), abs(high)) / 2.5, 1.0) * 30)
            print(f"\r{(low + high) / 2:+8.4f} N  +- {(high - low) / 2:.4f}  |{bar:30}|", end="", file=sys.stderr)
            self._held = []

    def end(self) -> None:
        if self._shown:
            print(file=sys.stderr)
