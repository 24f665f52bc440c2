"""Parameters of the PI behind filters: sections of any shape, or a notch."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from frictionloop.parameters.block import NotNegative, Number, Positive
from frictionloop.parameters.timing import Timing

FILTERS = 6
"""Most sections of a filter: with the rest of the law they fill the numbers a kernel keeps for it."""
LONGEST_DELAY = 3
"""Control periods of delay that feed-forward can follow."""


def _stable(section: tuple[float, ...]) -> tuple[float, ...]:
    """Refuse a section that is unstable or does not fit a Q31 core with a shift by one bit."""
    *_, a1, a2 = section
    largest = max(section, key=abs)
    if abs(largest) > 2.0:
        raise ValueError(f"coefficient {largest:g}: must be from -2 to 2")
    if not (abs(a2) < 1.0 and abs(a1) < 1.0 + a2):
        raise ValueError(f"a1 = {a1:g}, a2 = {a2:g}: unstable, needs |a2| < 1, |a1| < 1 + a2")
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

    @model_validator(mode="after")
    def _followed(self) -> Self:
        periods = self.delay_s * self.rate_hz
        if self.feedforward and periods > LONGEST_DELAY * (1 + 1e-9):
            raise ValueError(
                f"delay_s = {self.delay_s:g} s is {periods:.3g} control periods: feedforward follows at most "
                f"{LONGEST_DELAY}, {LONGEST_DELAY / self.rate_hz:g} s"
            )
        return self


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

    @model_validator(mode="after")
    def _below_nyquist(self) -> Self:
        if not self.notch_hz < self.rate_hz / 2:
            raise ValueError(f"notch_hz = {self.notch_hz:g} Hz: must be below half of rate_hz, {self.rate_hz / 2:g} Hz")
        return self

    @model_validator(mode="after")
    def _is_a_notch(self) -> Self:
        if self.notch_depth > self.notch_width:
            raise ValueError(f"notch_depth = {self.notch_depth:g}: at most notch_width, {self.notch_width:g}")
        return self
