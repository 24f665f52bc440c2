"""Parameters of the controllers: the simplest, and every kind there is."""

from __future__ import annotations

from typing import Annotated, Literal

from frictionloop.parameters.block import NotNegative
from frictionloop.parameters.filtered import FilteredPiController, NotchPiController
from frictionloop.parameters.kinds import Kinds
from frictionloop.parameters.timing import Timing


class PiController(Timing):
    """v = kp e + I, u = clip(v, g(a_max), f0), dI/dt = ki e with conditional integration (paper, Sec. 2.3)."""

    kind: Literal["pi"] = "pi"
    kp: NotNegative = 10.0
    """Proportional gain K_p (paper, Sec. 2.3)."""
    ki: NotNegative = 2.0
    """Integral gain K_i (paper, Sec. 2.3; per second is a reading)."""


class LookupController(Timing):
    """u = clip(f_r, g(a_max), f0): the lookup table alone, open loop (paper, Sec. 2.2 and ref. [15])."""

    kind: Literal["lookup"] = "lookup"
    overdrive: bool = False
    """Whether the amplitude command overshoots so that the plate gets there in one period (paper, ref. [14])."""


CONTROLLERS = Kinds(
    Timing,
    PiController,
    LookupController,
    FilteredPiController,
    NotchPiController,
    default="pi",
    tuned=True,
    beside={
        "limit_observer": "frictionloop.control.limit_observer:LimitObserverController",
    },
    gone={
        "oracle": "is no law; take 'notch_pi'",
        "tracker": "was removed; take 'notch_pi'",
        "observer": "was removed; take 'limit_observer'",
        "super_twisting": "was removed; take 'limit_observer'",
        "open_loop": "is no kind; open loop is 'lookup'",
    },
)
Controller = Annotated[Timing, CONTROLLERS]
