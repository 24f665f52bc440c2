"""A device as what presents: strokes of a person's finger, recorded at the device's own clock."""

from __future__ import annotations

import time
from collections.abc import Sequence

from frictionloop.device.device import connect
from frictionloop.experiments.engine import Presented, Stroke
from frictionloop.experiments.timeline import Timeline
from frictionloop.parameters import System

VIRTUAL = ("sim:", "emulated:")
"""Devices whose clock runs as fast as they can."""


class DeviceEngine:
    """A device: onset and offset are ticks of its clock, and the force is what it measures.

    It plays the effect of a trial by its own tables (`Device.run`). How far these are from the effect is in the traces,
    as ``setpoint_error_n``.

    Parameters
    ----------
    address : str
        As of ``fl.connect``.
    system : System
        What it is set up from, and what a simulated board is.

    Raises
    ------
    FrictionloopError
        As ``fl.connect``.
    """

    def __init__(self, address: str, system: System) -> None:
        self.source = "simulated" if address.startswith(VIRTUAL) else "device"
        self._waits = not address.startswith(VIRTUAL)
        self._device = connect(address, system)
        self._loaded: object = None

    def present(self, strokes: Sequence[Stroke], timeline: Timeline) -> list[Presented]:
        """Play the strokes of a trial.

        Raises
        ------
        FrictionloopError
            For an effect that a device has no room for; DeviceError, which is one, when the device faults or is gone:
            the trial is then lost, and those before it are kept.
        """
        found: list[Presented] = []
        for stroke in strokes:
            controller = stroke.system.controller
            is_open = controller.kind == "lookup"
            if not is_open and controller != self._loaded:
                self._device.upload(stroke.system)
                self._loaded = controller
            if self._waits:
                time.sleep(timeline.gap_s if found else timeline.cue_s)
            start = time.monotonic()
            run = self._device.run(stroke.system.setpoint, stroke.duration_s, state="open" if is_open else "closed")
            late = time.monotonic() - start - stroke.duration_s if self._waits else 0.0
            onset = float(run.attrs["start_tick"]) / self._device.info.tick_hz
            # An answer's time counts from when the run came back, which is later than its end by at most this.
            unsure = max(float(run.attrs["clock_residual_s"]), late)
            found.append(Presented(run, onset, onset + stroke.duration_s, unsure))
        return found

    def answered(self, rt_s: float) -> None:
        """Do nothing: its clock goes on by itself."""

    def close(self) -> None:
        """Let go of the line, the plate switched off."""
        self._device.close()
