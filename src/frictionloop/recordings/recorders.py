"""One channel of the files of recorders: LabVIEW's LVM and TDMS, and UFF of dataset 58."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from frictionloop.parameters.sources import Recording
from frictionloop.quantities import FrictionloopError
from frictionloop.recordings.arrays import in_array
from frictionloop.recordings.column import DEFAULT, Column, column_number, no_column
from frictionloop.recordings.contents import Channel, Contents, one_rate
from frictionloop.recordings.instruments import lvm_contents, tdms_contents, uff_contents

RECORDERS: Mapping[str, Callable[[Path], Contents]] = {
    ".lvm": lvm_contents,
    ".tdms": tdms_contents,
    **dict.fromkeys((".uff", ".unv"), uff_contents),
}
"""What reads all channels of such a file, by its ending."""


def read_recorder(recording: Recording) -> Column:
    """Return a channel by its name or number, the only one where none is named; what else the file has is told."""
    path = Path(recording.path)
    contents = RECORDERS[path.suffix.lower()](path)
    clock = contents.clock()
    signals = [each for each in contents.channels if each is not clock and _in_time(each)]
    if not signals:
        raise FrictionloopError(f"{path}: accepted: channels of real numbers over time")
    channel = _picked(recording, signals)
    others = [repr(each.name) for each in signals if each is not channel]
    times = None
    if clock is not None and clock.samples.size == channel.samples.size:
        times = _column(recording.model_copy(update={"column": clock.name}), clock)
    found = _column(recording, channel, times, others, "; ".join(map(str, contents.findings)))
    told = one_rate(recording.path, contents.rates_hz)
    return found if told is None else replace(found, rate_by=told[0], rate_hz=told[1])


def _in_time(channel: Channel) -> bool:
    return channel.samples.dtype.kind in "iufb" and channel.unit != "Hz"


def _picked(recording: Recording, signals: Sequence[Channel]) -> Channel:
    names = [each.name for each in signals]
    if len(signals) > 1 and recording.column == Recording.model_fields["column"].default:
        raise no_column(recording, list(map(repr, names)), f"{DEFAULT} may be any of {len(signals)} signals")
    return signals[column_number(recording, names, len(signals))]


def _column(
    recording: Recording, channel: Channel, times: Column | None = None, others: Sequence[str] = (), head: str = ""
) -> Column:
    samples = np.asarray(channel.samples)
    place = in_array(recording, samples)
    return Column(samples, place, channel.name, channel.unit, times=times, others=others, path=channel.name, head=head)
