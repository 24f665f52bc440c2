"""Parameters of the controllers: what all have (when they run, what they believe of the plant), and every kind."""

from __future__ import annotations

import math
import sys
from itertools import pairwise
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field, SerializerFunctionWrapHandler, model_serializer

from frictionloop.parameters.block import Block, Kinded, Kinds, NotNegative, Number, Positive, Whole
from frictionloop.quantities import must_be


class Model(Block):
    """What the controller believes: it alone feeds the lookup table, the clamp, notches and observers."""

    nominal_n: Positive = 0.8
    """Believed friction f0 without vibration: upper end of the clamp."""
    susceptibility_per_um2: Positive = 0.38
    """Believed susceptibility tau."""
    gain_spread: Annotated[Number, Field(ge=1, le=10)] = 2.7
    """Factor by which a finger's loop gain may be above the believed one; designs hold Ms 2.9 up to it.

    Of the capable people of the assumed population five in six bring less than 2.7. Of a finger measured by two plain
    strokes it is 1.1 (assumed: load and speed change by 10 % from stroke to stroke).
    """
    max_amplitude_um: Positive = 2.5
    """Believed largest amplitude: g(max_amplitude_um) is the lower end of the clamp."""
    plate_hz: Positive = 100.0
    """Believed cutoff of the plate's envelope."""
    resonance_hz: NotNegative = 0.0
    """Believed resonance of the force sensor's springs; 0 is none. Better too low than too high (docs/controllers)."""
    resonance_q: Positive = 20.0
    """Believed quality factor of that resonance."""
    sensor_hz: Positive = 1000.0
    """Believed cutoff of the sensor's electronics."""
    table_size: Annotated[Whole, Field(ge=0, le=65536)] = 0
    """Entries of the lookup table, interpolated linearly in amplitude squared; 0 is the exact inverse."""
    table_um2: tuple[NotNegative, ...] = ()
    """Measured table: a^2 at forces evenly from g(max_amplitude_um) to f0, falling to 0; none: the law's own."""

    def _check(self) -> None:
        if self.table_size == 1:
            raise must_be("table_size", 1, "0 or at least 2")
        if self.table_um2:
            table = self.table_um2
            if len(table) < 2 or table[-1] != 0 or any(b >= a for a, b in pairwise(table)):
                raise ValueError("table_um2 must fall to 0")
            if self.table_size == 0:
                raise ValueError(f"table_um2 needs table_size = {len(table)}")
        if not sys.float_info.min <= self.floor_n < self.nominal_n:
            raise ValueError(
                f"susceptibility_per_um2, max_amplitude_um: clamp from {self.floor_n:g} to {self.nominal_n:g} N "
                "must rise above 0"
            )

    @property
    def floor_n(self) -> float:
        """Lowest force the controller believes reachable, g(max_amplitude_um)."""
        return self.nominal_n * math.exp(-self.susceptibility_per_um2 * (self.max_amplitude_um * self.max_amplitude_um))


class Timing(Kinded):
    """What all controllers have: when they run, and what they believe of the plant."""

    rate_hz: Annotated[Number, Field(gt=0, le=1e9)] = 5000.0
    """Rate of the control periods (paper, Sec. 4.1: "5 kHz timer")."""
    delay_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Time from taking the sample to applying the amplitude command."""
    jitter_s: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Chance lateness of the command, |normal| of this standard deviation, at most to the end of its period."""
    lost_ticks: Annotated[Number, Field(ge=0, lt=1)] = 0.0
    """Share of ticks that do not happen: the controller keeps its state and its command."""
    open_until_s: Annotated[Number, Field(ge=0, le=1e6)] = 0.0
    """Until then the loop of a run is open, the lookup alone commands; it closes without a bump (control/law).

    A device is opened and closed by message instead, as the linear analysis has the loop closed.
    """
    model: Model = Model()
    """What the controller believes of the plant."""

    @model_serializer(mode="wrap")
    def _law_first(self, dump: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """Give the law and its gains before what all controllers have."""
        tree: dict[str, Any] = dump(self)
        return {name: value for name, value in tree.items() if name not in Timing.model_fields} | tree


FILTERS = 6
"""Most sections of a filter: with the rest of the law they fill the numbers a kernel keeps for it."""
LONGEST_DELAY = 3
"""Control periods of delay that feed-forward can follow."""


def _stable(section: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse a section that is unstable or whose coefficients are beyond 2."""
    *_, a1, a2 = section
    largest = max(section, key=abs)
    if abs(largest) > 2.0:
        raise must_be("coefficient", largest, "from -2 to 2")
    if not (abs(a2) < 1.0 and abs(a1) < 1.0 + a2):
        raise must_be("a1, a2", (a1, a2), "stable: |a2| < 1, |a1| < 1 + a2")
    return section


def _few(sections: tuple[Any, ...]) -> tuple[Any, ...]:
    if len(sections) > FILTERS:
        raise ValueError(f"must be at most {FILTERS} sections, not {len(sections)}")
    return sections


Section = Annotated[tuple[Number, Number, Number, Number, Number], AfterValidator(_stable)]
"""b0, b1, b2, a1, a2 of (b0 + b1/z + b2/z^2) / (1 + a1/z + a2/z^2)."""


class FeedForward(Timing):
    """PI gains, and whether the set-point acts by itself besides the error."""

    kp: NotNegative = 0.0
    """Proportional gain K_p, on the filtered error (``RETUNED``)."""
    ki: NotNegative = 111.0
    """Integral gain K_i, on the filtered error (``RETUNED``)."""
    feedforward: bool = False
    """Whether f_r is commanded and the error taken against the reading that ``model`` expects of it."""
    overdrive: bool = False
    """Whether the amplitude command overshoots so that the plate gets there in one period (paper, ref. [14])."""

    def _check(self) -> None:
        periods = self.delay_s * self.rate_hz
        if self.feedforward and periods > LONGEST_DELAY * (1 + 1e-9):
            raise ValueError(
                f"delay_s = {self.delay_s:g} s is {periods:.3g} control periods: feedforward follows at most "
                f"{LONGEST_DELAY}, {LONGEST_DELAY / self.rate_hz:g} s"
            )


class FilteredPiController(FeedForward):
    """PI on F(z) (f_ref - f_m), F a cascade of second-order sections (control/filtered_pi)."""

    kind: Literal["filtered_pi"] = "filtered_pi"
    sections: Annotated[tuple[Section, ...], AfterValidator(_few)] = ()
    """Rows b0, b1, b2, a1, a2 of the filter, at most 6, each stable and within -2 to 2; slow ones last."""


class NotchPiController(FeedForward):
    """PI on (s^2 + 2 depth w s + w^2)/(s^2 + 2 width w s + w^2) (f_ref - f_m), w = 2 pi notch_hz (control/notch)."""

    kind: Literal["notch_pi"] = "notch_pi"
    kp: NotNegative = 3.8
    """Proportional gain K_p, on the filtered error.

    With the other defaults a place to begin: for the finger of the bench, slip lengths 0 to 30 um, Ms is 1.6 with the
    resonance 5 % off and 1.9 with 10 %. `retune_notch` finds better ones.
    """
    ki: NotNegative = 80.0
    """Integral gain K_i, on the filtered error."""
    notch_hz: Positive = 141.0
    """Centre of the notch; best a little below the resonance (`retune_notch`)."""
    notch_depth: Annotated[Number, Field(ge=0, le=10)] = 0.065
    """Damping ratio of the numerator: depth/width is what is left at the centre (`retune_notch`)."""
    notch_width: Annotated[Number, Field(gt=0, le=10)] = 9.5
    """Damping ratio of the denominator; well above 1 the notch is the inverse of the resonance (`retune_notch`)."""

    def _check(self) -> None:
        super()._check()
        if not self.notch_hz < self.rate_hz / 2:
            raise must_be("notch_hz", self.notch_hz, f"below half of rate_hz, {self.rate_hz / 2:g} Hz", "Hz")
        if self.notch_depth > self.notch_width:
            raise must_be("notch_depth", self.notch_depth, f"at most notch_width, {self.notch_width:g}")


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
