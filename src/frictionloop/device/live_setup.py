"""A device is set up beside its telemetry: a frame at a time, so that samples and stops go on meanwhile."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from frictionloop.device import effects
from frictionloop.device.device import Device
from frictionloop.device.errors import Unplugged
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError, must_be

CHANGEABLE = "controller", "setpoint"
"""Blocks of a System that a page may change on a device: all else is the bench that stands there."""
KEPT = 32
"""Effects whose tables are kept: more than the library has."""


class SetUp:
    """What a device is set up from, and what of it has still to be written.

    Parameters
    ----------
    device : Device
        What is driven.
    system : System
        Description of its bench, with a controller and an effect; written before this returns.

    Raises
    ------
    FrictionloopError
        For a set-point that is no effect, or what the device refuses.
    """

    def __init__(self, device: Device, system: System) -> None:
        self._device = device
        self._steps: Iterator[None] = iter(())
        self.wanted = self._in_force = system
        """What was asked for last."""
        self.ceiling_um = 0.0
        """Largest amplitude that the board allows."""
        self._plays: np.ndarray | None = None
        self._played: dict[object, effects.Played] = {}
        self.again()
        for _ in self._steps:
            pass

    def again(self) -> None:
        """Write everything anew, to a device that may have forgotten it."""
        self._plays = None
        self.begin(self.wanted)

    def begin(self, system: System) -> None:
        """Let a System be written from now on, in place of what is on its way.

        Raises
        ------
        FrictionloopError
            For another bench, a set-point that is no effect, and an effect that the device has no room for.
        """
        for name in type(system).model_fields:
            if name not in CHANGEABLE and getattr(system, name) != getattr(self._in_force, name):
                raise FrictionloopError(f"{name}: fixed; accepted: {', '.join(CHANGEABLE)}")
        self.prepare(system)
        self._steps, self.wanted = self._writing(system, self._played[_effect_of(system)]), system

    def ready(self, system: System) -> bool:
        """Tell whether the tables of a System's effect are made: `begin` then takes no time."""
        return _effect_of(system) in self._played

    def prepare(self, system: System) -> None:
        """Make the tables of a System's effect, which takes a second for a rough one; may run in another thread."""
        if self.ready(system):
            return
        played = effects.played(system.setpoint, system, self._device.info.waveform)
        if played is None:
            raise must_be("setpoint.kind", system.setpoint.kind, "effect")
        kept = dict(list(self._played.items())[1 - KEPT :])
        self._played = kept | {_effect_of(system): played}

    def go_on(self) -> None:
        """Send one more frame of what has still to be written.

        Raises
        ------
        FrictionloopError
            For what the device refuses: what was in force before is then wanted again. `Unplugged` changes nothing.
        """
        try:
            next(self._steps, None)
        except Unplugged:
            raise
        except FrictionloopError:
            self._steps, self.wanted = iter(()), self._in_force
            raise

    def _writing(self, system: System, played: effects.Played) -> Iterator[None]:
        device = self._device
        yield from device.uploading(system)
        words = played.tables.words
        if self._plays is None or not np.array_equal(words, self._plays):
            self._plays = None
            yield from played.sending(device._link)
            self._plays = words
        self.ceiling_um = float(device.parameters["drive.ceiling_um"])
        self._in_force = system


def _effect_of(system: System) -> object:
    """Return what decides on the tables of an effect."""
    return system.setpoint, system.touch.load.length_mm
