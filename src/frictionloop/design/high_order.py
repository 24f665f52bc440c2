"""A synthesised controller with what is known of it, and the overdrive that its synthesis leaves the plate to."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from frictionloop.analysis.margins import Margins
from frictionloop.analysis.state_space import Complex
from frictionloop.design.noise_model import NoiseModel
from frictionloop.design.quadruple import Quadruple, series
from frictionloop.design.robustness import worst
from frictionloop.design.sections import Cascade
from frictionloop.design.weighted_plant import Weights

Method = Literal["hinf", "lqg"]


@dataclass(frozen=True)
class Lead:
    """(1 - p/z)/(1 - p), what overdrive does to a force command for small signals; p = 0 is none."""

    decay: float
    """Decay p of the believed plate over a period."""
    period_s: float

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return it at z = exp(j 2 pi f Ts), f in Hz."""
        back = np.exp(-2j * np.pi * np.asarray(frequency_hz, dtype=float) * self.period_s)
        return np.asarray((1.0 - self.decay * back) / (1.0 - self.decay))

    def taken_out(self, controller: Quadruple) -> Quadruple:
        """Return the controller in front of overdrive that does what one without it does: the lag 1/lead behind it."""
        p = np.array([[self.decay]])
        return series([controller, Quadruple(p, np.ones((1, 1)), (1.0 - p) * p, 1.0 - p)]) if self.decay else controller


@dataclass(frozen=True, eq=False)
class Synthesised:
    """A synthesised controller and how it holds."""

    cascade: Cascade
    """Sections and PI, as the law ``filtered_pi`` runs them."""
    lead: Lead
    """Overdrive behind them."""
    method: Method
    gamma: float
    """H-infinity norm that the full-order controller keeps; NaN for LQG."""
    order: int
    """States, the integrator included."""
    full_order: int
    """States before reduction."""
    weights: Weights
    """With the performance that was found."""
    margins: Margins
    """At the operating point, on the bench as described."""
    command_noise_n: float
    """Rms of the command u that sensor noise causes on the bench as described, N."""
    table: xr.Dataset = field(repr=False)
    """Ms, stability and residual over the plants of `robustness`."""
    noise: NoiseModel = field(repr=False)

    @property
    def overrides(self) -> dict[str, object]:
        """The controller as overrides for ``System.evolve``, with feed-forward of the set-point."""
        overdriven = self.lead.decay > 0.0
        return self.cascade.overrides | {"controller.feedforward": True, "controller.overdrive": overdriven}

    @property
    def worst(self) -> dict[str, object]:
        """The largest Ms over the whole grid, and where."""
        return worst(self.table)

    @property
    def residual_rms_n(self) -> float:
        """Rms that is left of the disturbance from 1 to 500 Hz on the bench as described, N."""
        return float(self.table["residual_rms_n"].sel(resonance=0.0, gain=1.0).isel(contact=0, speed_mm_s=0))

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return C at z = exp(j 2 pi f Ts), error to the force command behind overdrive, f in Hz above 0."""
        return self.cascade.response(frequency_hz) * self.lead.response(frequency_hz)
