"""Ten minutes of telemetry at 5 kHz over a bad line: every loss is reported, and no wrong value comes through."""

from __future__ import annotations

import random
from typing import Any

import numpy as np
import pytest

from frictionloop.device.device import Device
from frictionloop.device.link import Link
from frictionloop.device.recording import ALL, SCALES
from frictionloop.live.telemetry_channels import Rows


@pytest.mark.parametrize("kind", ["Board", "Firmware"])
@pytest.mark.parametrize("duration_s", [6.0, pytest.param(600.0, marks=[pytest.mark.soak, pytest.mark.timeout(600)])])
def test_a_bad_line_loses_samples_and_invents_none(boards: Any, duration_s: float, kind: str) -> None:
    board, lines, draw = getattr(boards, kind)(), [], random.Random(5)

    def opened() -> Any:
        lines.append(boards.BadLine(board, draw))
        return lines[-1]

    device = Device(opened)
    run = device.run(0.5, duration_s)
    events = [event for line in lines for event in line.events]
    assert {"damage", "stall"} <= set(events)

    there = np.isfinite(run.f_m.values)
    ticks = run.attrs["start_tick"] + np.arange(run.sizes["time"])
    sent = board.values(ticks, 2)
    for channel, name in enumerate(("f_r", "f_m", "u", "a", "position", "speed", "load")):
        np.testing.assert_array_equal(run[name].values[there], (sent[:, channel] * SCALES[channel])[there])
        assert np.isnan(run[name].values[~there]).all()
    np.testing.assert_array_equal(run.sliding.values[there], (sent[there, 7] & 1) != 0)
    assert not run.scored.values[~there].any()
    np.testing.assert_array_equal(run.saturated.values[there], (sent[there, 7] & 2) != 0)
    assert run.attrs["implausible_samples"] == 0

    # Every loss is reported twice over: by the rows that are missing and by the sequence of the frames.
    assert run.attrs["lost_samples"] == np.sum(~there) > 0
    assert run.attrs["lost_samples"] <= 16 * run.attrs["missed_frames"]
    assert run.attrs["reconnects"] == events.count("gone")
    # A damaged frame takes at most its neighbour with it; a line that goes away what was under way, up to a stall.
    assert run.attrs["lost_samples"] <= 16 * 2 * len(events) + 5000 * events.count("gone")


def test_samples_that_come_in_one_piece_with_the_first_status_are_not_lost(boards: Any) -> None:
    board = boards.Board()

    class Together(boards.Line):  # type: ignore[misc]
        def write(self, data: bytes) -> None:
            super().write(data)
            self.board.advance(40)

    link = Link(Together(board))
    rows = Rows(link.listen(1, ALL)["tick"], 5000)
    for _ in range(3):
        for message in link.poll(0.01):
            rows.take(message)
    assert rows.next_tick > board.tick - boards.SAMPLES
    assert rows.lost == 0
