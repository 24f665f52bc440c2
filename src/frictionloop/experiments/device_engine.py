"""A device as what presents: strokes of a person's finger, recorded at the device's own clock."""

from __future__ import annotations

import time
from collections.abc import Sequence

from frictionloop.device.device import connect
from frictionloop.experiments.engine import Presented, Stroke
from frictionloop.experiments.timeline import Timeline
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect import Effect, Touch

VIRTUAL = ("sim:", "emulated:")
"""Devices whose clock runs as fast as they can."""


class DeviceEngine:
    """A device: onset and offset are ticks of its clock, and the force is what it measures.

    It plays effects that are the same everywhere: its set-points are forces over time.

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
            For an effect that is not the same everywhere; DeviceError, which is one, when the device faults or is
            gone: the trial is then lost, and those before it are kept.
        """
        found: list[Presented] = []
        for stroke in strokes:
            level = level_n(stroke.system)
            controller = stroke.system.controller
            is_open = controller.kind == "lookup"
            if not is_open and controller != self._loaded:
                self._device.upload(stroke.system)
                self._loaded = controller
            if self._waits:
                time.sleep(timeline.gap_s if found else timeline.cue_s)
            start = time.monotonic()
            run = self._device.run(level, stroke.duration_s, state="open" if is_open else "closed")
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


def level_n(system: System) -> float:
    """Return the force that a system's effect asks for everywhere.

    Raises
    ------
    FrictionloopError
        For an effect that differs from place to place.
    """
    effect = getattr(system.setpoint, "effect", None)
    if not isinstance(effect, Effect) or not effect.is_static or effect.period_mm != 0.0:
        kind = getattr(effect, "kind", system.setpoint.kind)
        raise FrictionloopError(
            f'stimulus.effect.kind = "{kind}": a device plays forces that are the same everywhere; run it on bench:'
        )
    return effect.force_n(Touch())
