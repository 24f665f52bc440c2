"""A control law that observes the friction limit: its parameters and what they make of control/limit_step."""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.control.law import Law, clamp_of
from frictionloop.control.limit_gains import LONGEST, limit_rows
from frictionloop.control.limit_step import FASTER, LimitGains, LimitState, limit_observer_step
from frictionloop.parameters import SuspendedSensor
from frictionloop.parameters.block import Number, Positive
from frictionloop.parameters.timing import Timing
from frictionloop.sensing.force_sensor import suspension_coefficients


class LimitObserverController(Timing):
    """Observer of the friction limit's logarithm that learns the susceptibility (control/limit_observer)."""

    kind: Literal["limit_observer"] = "limit_observer"
    compliance_um_per_n: Annotated[Number, Field(ge=0, le=1000)] = 50.0
    """Compliance of the contact, 1/s0 of a bristle, 0 of a slider: it is told, and not learnt."""
    bandwidth_hz: Annotated[Number, Field(gt=0, le=1e6)] = 80000.0
    """Ratio of what drives the limit to the reading's noise, as a frequency (as `Observing`), for a force of 1 N."""
    spring_noise: Annotated[Number, Field(gt=0, le=100)] = 0.5
    """What drives the springs beside friction, over what drives the limit: the more, the less springs are trusted."""
    skin_stiffness_n_m: Positive = 1000.0
    """Believed stiffness of the skin: friction rises no faster than this times the speed (as `Skin`)."""
    susceptibility_spread: Annotated[Number, Field(ge=1, le=10)] = 3.0
    """Bound of what is learnt: tau from the model's over this to the model's times this, where it begins; 1 learns not.

    3 is exp(3.1 x 0.35): one finger of a thousand has more, if ln tau has the standard deviation that is assumed
    of it (physics/fingers).
    """
    learning_s: Positive = 3.0
    """Time constant T_l with which the susceptibility is learnt."""

    @property
    def overdrive(self) -> bool:
        """The amplitude command always overshoots so that the plate gets there in one period."""
        return True

    @model_validator(mode="after")
    def _one_period(self) -> Self:
        if self.delay_s * self.rate_hz > 1.0 + 1e-9:
            raise ValueError(
                f"delay_s = {self.delay_s:g} s: must be at most one control period, {1.0 / self.rate_hz:g} s, under a "
                "limit observer"
            )
        return self


def limit_observer_gains(controller: LimitObserverController) -> LimitGains:
    """Return the gains of `limit_observer_step`.

    Raises
    ------
    FrictionloopError
        For a model without resonance, or one for which no observer settles.
    """
    c, model, dt = controller, controller.model, 1.0 / controller.rate_hz
    rest, plate = min(c.delay_s * c.rate_hz, 1.0), -2.0 * math.pi * model.plate_hz * dt
    quick, slow = limit_rows(model, c.rate_hz, c.bandwidth_hz, c.spring_noise)
    more = (slow - quick) / LONGEST
    springs = suspension_coefficients(
        SuspendedSensor(resonance_hz=model.resonance_hz, q=model.resonance_q, cutoff_hz=model.sensor_hz), dt
    )
    return LimitGains(
        math.exp(plate * rest), math.exp(plate * (1.0 - rest)),
        springs.a11, springs.a12, springs.a21, springs.a22, springs.a31, springs.a32, springs.a33,
        quick[0], more[0], more[1], quick[2], more[2], quick[3], more[3], quick[4], more[4],
        c.compliance_um_per_n, FASTER * c.skin_stiffness_n_m, model.max_amplitude_um,
        math.log2(model.nominal_n), model.susceptibility_per_um2 / math.log(2.0),
        c.susceptibility_spread, 1.0 / c.learning_s, *clamp_of(model),
    )  # fmt: skip


def limit_observer_start(controller: LimitObserverController) -> LimitState:
    """Return the state before the first reading: no vibration, the believed limit, and the largest susceptibility."""
    model = controller.model
    fall = controller.susceptibility_spread * model.susceptibility_per_um2 / math.log(2.0)
    known = {"limit": math.log2(model.nominal_n), "fall": fall}
    return LimitState(*(known.get(name, 0.0) for name in LimitState._fields))


LAW = Law(
    "limit_observer",
    limit_observer_step,
    LimitState,
    LimitGains,
    limit_observer_gains,
    limit_observer_start,
    frozen=("fall", "slow_target", "slow_limit", "swing", "stuck"),
)
