"""A synthesised controller with what is known of it, and the overdrive that its synthesis leaves the plate to."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.analysis.state_space import Complex
from frictionloop.design.noise_model import NoiseModel
from frictionloop.design.plants import lead
from frictionloop.design.quadruple import Quadruple, series
from frictionloop.design.sections import Cascade
from frictionloop.design.weighted_plant import Weights

Method = Literal["hinf", "lqg"]


@dataclass(frozen=True, eq=False)
class Synthesised:
    """A synthesised controller and how it holds."""

    cascade: Cascade
    """Sections and PI, as the law ``filtered_pi`` runs them."""
    decay: float
    """Of the believed plate over a period, where overdrive stands behind them; 0 without."""
    method: Method
    gamma: float
    """H-infinity norm that the full-order controller keeps; NaN for LQG."""
    order: int
    """States, the integrator included."""
    full_order: int
    """States before reduction."""
    weights: Weights
    """With the performance that was found."""
    noise: NoiseModel = field(repr=False)
    peaks: Mapping[float, float]
    """Largest Ms over the contacts by the share that the resonance is off."""
    command_noise_n: float
    """Rms of the command u that sensor noise causes on the bench as described, N."""
    residual_rms_n: float
    """Rms that is left of the disturbance from 1 to 500 Hz on the bench as described, N."""

    @property
    def overrides(self) -> dict[str, object]:
        """The controller as overrides for ``System.evolve``, with feed-forward of the set-point."""
        overdriven = self.decay > 0.0
        return self.cascade.overrides | {"controller.feedforward": True, "controller.overdrive": overdriven}

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C at z = exp(j 2 pi f Ts), error to the force command behind overdrive, f in Hz above 0."""
        return self.cascade.response(frequency_hz) * lead(self.decay, frequency_hz, self.cascade.period_s)


def lagged(controller: Quadruple, decay: float) -> Quadruple:
    """Return the controller in front of overdrive that does what one without it does: the lag 1/lead behind it."""
    p = np.array([[decay]])
    return series([controller, Quadruple(p, np.ones((1, 1)), (1.0 - p) * p, 1.0 - p)]) if decay else controller
