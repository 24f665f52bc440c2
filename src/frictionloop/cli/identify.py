"""``frictionloop identify channels``: what is in a file before anything is computed from it."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen

CHANNELS_EXAMPLES = (
    "hits.mat",
    "hits.mat --plot hits.png",
    "hits.mat --save-map hits-map.toml",
)
RecordingFile = Annotated[Path, Parameter(name="FILE", help="A recording.", group=flags.SYSTEM)]


def channels(
    file: RecordingFile,
    /,
    *,
    rate_hz: flags.Run[float | None] = None,
    decimal: flags.Run[Literal[".", ","] | None] = None,
    plot: flags.Result[Path | None] = None,
    save_map: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Show what a file holds before anything is computed: channels, rate, clipping, wraps, lost samples.

    Parameters
    ----------
    rate_hz
        Sampling rate in Hz, where the file tells none or two.
    decimal
        Decimal mark of a text, where its numbers can be read in two ways.
    plot
        Draw the channels here (.png, .svg or .pdf): the range of each in short windows along the file, before the rest.
    save_map
        Write a channel map here (.toml) to be filled in: which channel is which, in what unit.
    """
    file_arguments.check_output("save_map", save_map, file_arguments.SYSTEMS)
    file_arguments.check_new("save_map", save_map)
    file_arguments.check_output("plot", plot, file_arguments.FIGURES)
    if plot is not None:
        fl.plot(fl.identify.first_look(file, rate_hz, decimal), plot)
        screen.say(f"saved channels: {plot}")
    found = fl.identify.channels(file, rate_hz, decimal=decimal)
    if save_map is not None:
        found.write_map(save_map)
    shown.show(found, saved={"map": save_map, "plot": plot})
