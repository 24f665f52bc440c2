"""Several runs on one device: what an earlier one left in the device and on the line is not taken for a later one's."""

from __future__ import annotations

from collections.abc import Callable
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

import frictionloop as fl


@pytest.fixture
def device() -> Any:
    with fl.connect("sim:") as found:
        yield found


def straight_on(device: fl.Device) -> None:
    """Do nothing between two runs."""


def a_pause(device: fl.Device) -> None:
    """Let the board go on while nobody reads."""
    pipe: Any = device._link.pipe
    for _ in range(1000):
        pipe._tick()


def the_loop_left_closed(device: fl.Device) -> None:
    """Leave the loop on, and telemetry with it."""
    device._link.ask("stream", decimation=1, mask=255)
    device.mode("closed")
    device._link.poll(0.1)


def a_look(device: fl.Device) -> None:
    """Look at the telemetry."""
    assert list(device.stream(0.05, decimation=3))


def a_fault(device: fl.Device) -> None:
    """Run into a fault and clear it; the board tells it while the run that follows begins."""
    device.set("safety.force_limit_n", 1e-3)
    device.commit()
    with TemporaryDirectory() as folder, pytest.raises(fl.Interrupted, match="fault force_range"):
        device.run(0.5, 1.0, path=f"{folder}/cut.h5")
    device.set("safety.force_limit_n", 2.4)
    device.commit()
    device.clear()


def a_fault_nobody_heard(device: fl.Device) -> None:
    """Close the loop, be silent until the board is at fault, and clear it."""
    device._link.ask("stream", decimation=1, mask=255)
    device.mode("closed")
    a_pause(device)
    a_pause(device)
    device.clear()


@pytest.mark.slow
@pytest.mark.parametrize("between", [straight_on, a_pause, the_loop_left_closed, a_look, a_fault, a_fault_nobody_heard])
def test_a_run_records_itself_alone(device: fl.Device, between: Callable[[fl.Device], None]) -> None:
    device.run(0.5, 0.2)
    between(device)
    began = device._link.pipe.clock()
    run = device.run(0.3, 0.2)
    assert set(run.f_r.values) == {0.3}
    assert (run.attrs["lost_samples"], run.attrs["gaps"], run.attrs["dropped_samples"]) == (0, 0, 0)
    assert run.attrs["start_tick"] > 5000 * began


def test_what_is_streamed_is_what_was_asked_for(device: fl.Device) -> None:
    last = 0
    for decimation in (10, 7, 10, 10, 1):
        ticks = np.concatenate([part["tick"] for part in device.stream(0.1, decimation)])
        assert ticks[0] > last
        assert set(np.diff(ticks)) == {decimation}
        assert set(ticks % decimation) == {0}
        last = ticks[-1]
