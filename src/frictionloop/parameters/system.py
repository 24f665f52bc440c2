"""System: the whole loop as one frozen value."""

from __future__ import annotations

import os
import reprlib
from typing import Any, Self

from pydantic import model_validator

from frictionloop.parameters.board import Board
from frictionloop.parameters.controller import Controller
from frictionloop.parameters.description import Description
from frictionloop.parameters.finger import AnyFriction, Finger, RigidFinger
from frictionloop.parameters.motion import Motion, Sliding, Touch
from frictionloop.parameters.plant import FrictionLaw, Plate, Sensor, SuspendedSensor
from frictionloop.parameters.sources import Source, largest_n
from frictionloop.quantities import FrictionloopError

_STEEPEST = 700.0
"""Largest tau a_max^2: g(a_max) = f0 e^-700 is still a normal number."""


class System(Description):
    """A closed friction loop: signals, plant and controller (paper, Fig. 1b)."""

    setpoint: Source
    """Set-point force f_r over time."""
    disturbance: Source
    """Disturbance d added to the friction force."""
    friction: AnyFriction
    """How friction falls with vibration, and what else it depends on."""
    plate: Plate
    """How the amplitude follows its command."""
    sensor: Sensor
    """How the force is measured."""
    controller: Controller
    """How the amplitude command is computed."""
    finger: Finger = RigidFinger()
    """The skin between friction and bone."""
    motion: Motion = Sliding()
    """How the finger moves and presses."""
    touch: Touch = Touch()
    """What is measured of the motion."""
    board: Board = Board()
    """How a device is wired; nothing of it enters a simulation."""

    @classmethod
    def from_toml(cls, path: str | os.PathLike[str]) -> Self:
        """Return the System a TOML file describes; `read_toml` has the errors."""
        from frictionloop.parameters.files import read_toml

        return read_toml(path)  # type: ignore[return-value]

    @model_validator(mode="after")
    def _some_friction_is_left(self) -> Self:
        if not isinstance(self.friction, FrictionLaw):
            return self
        fall = self.friction.susceptibility_per_um2 * (self.plate.max_amplitude_um * self.plate.max_amplitude_um)
        if not fall <= _STEEPEST:
            raise ValueError(
                f"friction.susceptibility_per_um2 * plate.max_amplitude_um^2 = {fall:g}: must be at most {_STEEPEST:g}"
            )
        return self

    @model_validator(mode="after")
    def _moves(self) -> Self:
        for block, kind in (("friction", self.friction.kind), ("finger", self.finger.kind)):
            if kind in ("finger", "skin") and self.motion.kind == "sliding":
                raise ValueError(f'{block}.kind = "{kind}": needs motion.kind = "strokes"')
        return self

    @model_validator(mode="after")
    def _has_a_place(self) -> Self:
        if self.disturbance.kind == "effect":
            raise ValueError('disturbance.kind = "effect": is a set-point')
        if self.setpoint.kind == "effect" and self.motion.kind == "sliding":
            raise ValueError('setpoint.kind = "effect": needs motion.kind = "strokes"')
        return self

    @model_validator(mode="after")
    def _reads_what_it_controls(self) -> Self:
        if isinstance(self.sensor, SuspendedSensor):
            wanted, model = largest_n(self.setpoint), self.controller.model.nominal_n
            for name, force in (("the set-point reaches", wanted), ("controller.model.nominal_n is", model)):
                if force > self.sensor.range_n:
                    raise ValueError(
                        f"sensor.range_n = {self.sensor.range_n:g} N: {name} {force:g} N; must be at least that"
                    )
        return self


def check_system(system: Any) -> None:
    """Refuse what is not a System where one is needed."""
    if not isinstance(system, System):
        given = " ".join(reprlib.repr(system).split())
        raise FrictionloopError(f"system = {given}: must be a System, e.g. fl.paper()")
