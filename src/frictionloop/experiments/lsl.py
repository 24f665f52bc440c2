"""Streams of the Lab Streaming Layer for other recorders: strokes and markers, on the device's clock."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.experiments.trial_records import force_of, rate_of
from frictionloop.quantities.optional_libraries import needed

CHANNELS = {"delivered force": "N", "set-point": "N", "position": "m", "speed": "m/s", "load": "N"}
"""Channels of the stream of strokes, and their units."""
SOURCE = "frictionloop"


class Streams:
    """Two outlets: ``frictionloop`` has the strokes, ``frictionloop-markers`` the ends of each and answers.

    A stroke goes out when it is over, as one chunk. Its time stamps, and those of markers, are seconds on the device's
    clock, which are the times in ``trials.tsv``; LSL's own clock is another, so a recorder must not correct them.

    Parameters
    ----------
    participant : str
        Code; part of the streams' source ids.

    Raises
    ------
    FrictionloopError
        If pylsl is missing.
    """

    def __init__(self, participant: str) -> None:
        self._lsl: Any = needed("pylsl", "pylsl", "lsl")
        self._participant = participant
        self._strokes: Any = None
        info = self._info("frictionloop-markers", "Markers", 1, 0.0, "string")
        self._markers = self._lsl.StreamOutlet(info)

    def tell(self, row: Mapping[str, Any], runs: Sequence[xr.Dataset]) -> None:
        """Pass a trial on.

        Parameters
        ----------
        row : mapping
            Its row.
        runs : sequence of Dataset
            Its strokes.
        """
        rate = rate_of(runs[0])
        if self._strokes is None:
            self._strokes = self._lsl.StreamOutlet(self._info(SOURCE, "Force", len(CHANNELS), rate, "double64"))
        for number, run in enumerate(runs, 1):
            lines = [run[name].values for name in (force_of(run), "f_r", "position", "speed", "load")]
            start_s = row["onset_s"] if number == 1 else row["offset_s"] - run.sizes["time"] / rate
            times = start_s + np.arange(run.sizes["time"]) / rate
            self._strokes.push_chunk(np.column_stack(lines).tolist(), times.tolist())
            self._mark(f"trial {row['trial']} stroke {number} onset", times[0])
            self._mark(f"trial {row['trial']} stroke {number} offset", times[0] + run.sizes["time"] / rate)
        if row["response"]:
            self._mark(f"trial {row['trial']} response {row['response']}", row["offset_s"] + row["rt_s"])

    def _mark(self, text: str, time_s: float) -> None:
        self._markers.push_sample([text], float(time_s))

    def _info(self, name: str, kind: str, channels: int, rate: float, form: str) -> Any:
        info = self._lsl.StreamInfo(name, kind, channels, rate, form, f"{name}-{self._participant}")
        described = info.desc()
        described.append_child_value("clock", "device")
        if kind == "Force":
            listed = described.append_child("channels")
            for label, unit in CHANNELS.items():
                one = listed.append_child("channel")
                one.append_child_value("label", label)
                one.append_child_value("unit", unit)
        return info
