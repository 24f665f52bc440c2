"""System: the whole loop as one frozen value, with the wiring of a builder's board."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, Field

from frictionloop.parameters.block import Block, Number, Positive, Whole
from frictionloop.parameters.controller import Controller
from frictionloop.parameters.frozen_blocks import Description, flat
from frictionloop.parameters.input_signals import Source, largest_n
from frictionloop.parameters.motion import Motion, Sliding, Touch
from frictionloop.parameters.plant import AnyFriction, Finger, FrictionLaw, Plate, RigidFinger, Sensor, SuspendedSensor
from frictionloop.quantities import must_be
from frictionloop.quantities.value_checks import ABOVE_0, number


def _is_there(value: float) -> float:
    if value == 0:
        raise ValueError("must not be 0")
    return value


Counts = Annotated[Whole, Field(ge=-(2**15), le=2**15 - 1)]
"""Reading of a converter, 16 bit."""


class Board(Block):
    """The wiring of the microcontroller's board, which only a device has: a simulation does not depend on it.

    The force along the motion is ``force_n_per_count * (counts - force_zero_counts[0])``, load and position likewise; a
    scale may be negative, which turns the sign. A channel with scale 0 is one that the bench has not got.
    """

    force_axes: Annotated[Whole, Field(ge=1, le=2)] = 1
    """1: the first channel is the force, positive when it opposes the motion; 2: the magnitude of both channels is.

    A sensor that is fixed to the bench reads the other sign on the way back, and needs 2 (docs/firmware-states).
    """
    force_zero_counts: tuple[Counts, Counts] = (0, 0)
    """What the two force channels read at no force."""
    force_n_per_count: Annotated[Number, AfterValidator(_is_there)] | None = None
    """Force of a count of the first channel; left out: 16 bit over the sensor's range both ways (2.5 N if it has none).
    """
    across_n_per_count: Number = 0.0
    """Force of a count of the second channel; 0: there is none."""
    load_zero_counts: Counts = 0
    """What the load channel reads at no load."""
    load_n_per_count: Number = 10.0 / 2**16
    """Load of a count (assumed: 16 bit over 5 N both ways, ten times the usual load); 0: no load cells."""
    position_m_per_count: Number = 1e-6
    """Way of a count (assumed: a tenth of the sensor's noise); 0: no position sensor."""
    ceiling_um: Positive | None = None
    """Largest amplitude ever commanded; left out: the plate's largest."""
    ramp_s: Annotated[Positive, Field(le=0.1)] = 0.01
    """Time to ramp down the largest amplitude (assumed: six time constants of the plate in bench()), at most 0.1 s."""
    force_limit_n: Positive | None = None
    """Largest plausible force, below what the converter reads; left out: 0.96 of its range (assumed: short of it)."""
    hum_share: Annotated[Positive, Field(le=1.0)] = 0.12
    """Mains pick-up that is tolerated, peak to peak over the sensor's range (assumed: 0.3 N of 2.5 N); more is a fault.

    The loop takes what is tolerated for force, and errs by half of it. A set-point that moves by an eighth of it within
    26 ms hides the mains, so a smaller one is watched for less of the time.
    """


COEFFICIENT = "friction.coefficient"
"""Friction over load: taken in place of ``friction.nominal_n``, and told to the controller's model."""
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

    def resolved(self, overrides: Mapping[str, Any]) -> dict[str, Any]:
        """Return overrides with a friction coefficient as the friction at the reference load: f0 = mu N0."""
        if COEFFICIENT not in overrides and not isinstance(overrides.get("friction"), Mapping):
            return dict(overrides)
        own = flat(overrides)
        if COEFFICIENT not in own:
            return dict(overrides)
        if "friction.nominal_n" in own:
            raise must_be(COEFFICIENT, own[COEFFICIENT], "without friction.nominal_n, which it sets")
        mu = number(COEFFICIENT, own.pop(COEFFICIENT), "", ABOVE_0)
        load_n = own.get("friction.reference_load_n", getattr(self.friction, "reference_load_n", None))
        if load_n is None:
            raise must_be("friction.kind", self.friction.kind, '"finger" for a coefficient')
        return {"friction.nominal_n": mu * load_n, "controller.model.nominal_n": mu * load_n} | own

    def _check(self) -> None:
        tau = self.friction.susceptibility_per_um2 if isinstance(self.friction, FrictionLaw) else 0.0
        fall = tau * (self.plate.max_amplitude_um * self.plate.max_amplitude_um)
        if not fall <= _STEEPEST:
            raise must_be("friction.susceptibility_per_um2 * plate.max_amplitude_um^2", fall, f"at most {_STEEPEST:g}")
        for block, kind in (("friction", self.friction.kind), ("finger", self.finger.kind)):
            if kind in ("finger", "skin") and self.motion.kind == "sliding":
                raise ValueError(f'{block}.kind = "{kind}": needs motion.kind = "strokes"')
        if self.disturbance.kind == "effect":
            raise must_be("disturbance.kind", "effect", "another; an effect is a set-point")
        if self.setpoint.kind == "effect" and self.motion.kind == "sliding":
            raise must_be("motion.kind", "sliding", "strokes, for an effect")
        if isinstance(self.sensor, SuspendedSensor):
            wanted, model = largest_n(self.setpoint), self.controller.model.nominal_n
            for name, force in (("the set-point reaches", wanted), ("controller.model.nominal_n is", model)):
                if force > self.sensor.range_n:
                    raise ValueError(
                        f"sensor.range_n = {self.sensor.range_n:g} N: {name} {force:g} N; must be at least that"
                    )


def check_system(system: Any) -> None:
    """Refuse what is not a System where one is needed."""
    if not isinstance(system, System):
        given = " ".join(reprlib.repr(system).split())
        raise must_be("system", given, "a System, e.g. fl.paper()")
