"""Parameters of the tracker, which is experimental: an observer that learns the finger while it slides."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from frictionloop.parameters.block import NotNegative, Number, Positive
from frictionloop.parameters.timing import Timing

PLACES = (0.07, 0.125, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 1.875)
"""Places of the rows of a schedule (`limit_observer.place_of`): the share of the way to its limit that friction goes in
a period; 1 is a slider's up to 20 mm/s and 1.25 one's from 40 mm/s on. Strokes above 70 mm/s have 2 less the share:
1.5, 1.75 and 1.875 are those of 0.5, 0.25 and 0.125."""
Row = tuple[Number, Number, Number, Number, Number, Number, Number]
Schedule = tuple[Row, Row, Row, Row, Row, Row, Row, Row, Row, Row]
SCHEDULE: Schedule = (
    (30.26, 32.97, 1.884, 10.79, 0.9463, 0.3635, 0.9118),
    (19.63, 33.0, 1.908, 11.04, 0.9504, 0.4649, 1.1),
    (11.2, 33.0, 2.046, 11.92, 0.985, 0.4052, 0.5001),
    (4.392, 9.565, 1.514, 6.047, 0.879, 0.5182, 0.7329),
    (7.853, 15.19, 1.915, 9.97, 0.9639, 0.7688, 0.9334),
    (12.12, 12.12, 1.806, 8.907, 0.941, 1.0, 0.9497),
    (10.36, 10.36, 2.097, 12.19, 0.9827, 1.0, 0.9725),
    (1.213, 13.16, 1.743, 8.191, 0.9322, 0.5098, 1.011),
    (5.713, 32.94, 2.084, 12.18, 0.9939, 0.3578, 0.9603),
    (8.327, 32.85, 1.931, 11.23, 0.9548, 0.3239, 1.095),
)
"""Gains for `bench()` with the least predicted residual of those that kept Ms below its limits (docs/decisions).

With contact and finger known exactly, Ms is at most 1.7, 2.0 and 2.6 with the resonance off by 0, 5 and 10 %.
"""


class TrackerController(Timing):
    """Experimental: an observer of the friction limit that learns susceptibility and contact (control/tracker).

    Quick set-point steps can teach it the wrong contact, after which some fingers ring; `NotchPiController` does not
    learn, and is what is recommended.
    """

    kind: Literal["tracker"] = "tracker"
    schedule: Schedule = SCHEDULE
    """A row for each of 10 places: shares of the way to its limit that friction goes in a period, 0.07, 0.125,
    0.25, 0.5 and 0.75, a slider's up to 20 mm/s and from 40 mm/s on, then shares of strokes above 70 mm/s: 0.5, 0.25
    and 0.125.

    Gains per newton of innovation: on the limit (N), the friction (N), the springs' force and rate, the reading; then
    the share of the error to correct in a period, and the trust in the newest limit.
    """
    resonance_share: Annotated[Number, Field(gt=0, le=2)] = 0.91
    """Resonance that the observer is given over that of the model: too low is benign, too high fatal."""
    broadened_q: Positive = 6.0
    """Quality factor that the observer is given in place of the model's: broad, it holds for others."""
    compliance_um_per_n: Annotated[Number, Field(ge=0, le=1000)] = 40.0
    """Compliance of the contact to begin with: friction follows its limit with T = compliance F / speed; 0: at once.

    Near Dahl's: a slider rings with it, and is found by that (control/tracker.CALMED_C); from 20 um/N some of Dahl's
    contacts were taken for sliders (chosen on fingers(240, 3)).
    """
    largest_compliance_um_per_n: Annotated[Number, Field(ge=0, le=1000)] = 80.0
    """Largest compliance that is learnt: 50 is the bench's Dahl contact, the skin adds to it (assumed)."""
    compliance_learning: Annotated[Number, Field(ge=0, le=1)] = 0.02
    """Step of the estimate of the compliance; 0 keeps it."""
    susceptibility_learning: Annotated[Number, Field(ge=0, le=1)] = 5e-4
    """Step of the estimate of the susceptibility; 0 keeps it."""
    load_exponent: Annotated[Number, Field(ge=0, le=2)] = 0.85
    """Exponent with which the measured load is fed forward (middle of 2/3 to 1: Dzidek 2014); 0 feeds nothing."""
    load_hz: Positive = 120.0
    """Low-pass on the measured load before it is fed forward, above the tremor (chosen on fingers(120, 3))."""
    skin_stiffness_n_m: Positive = 1000.0
    """Believed stiffness of the skin: rising friction follows no faster than this times the speed (as Skin's)."""
    largest_jump_n: NotNegative = 0.3
    """Most that one reading may move the estimated limit: a reversal rings (chosen on fingers(240, 3): with 0.04 N rows
    of more gain no longer correct limit and springs alike)."""

    @property
    def overdrive(self) -> bool:
        """The amplitude command always overshoots so that the plate gets there in one period."""
        return True

    @model_validator(mode="after")
    def _one_period(self) -> Self:
        if self.delay_s * self.rate_hz > 1.0 + 1e-9:
            raise ValueError(
                f"delay_s = {self.delay_s:g} s: must be at most one control period, {1.0 / self.rate_hz:g} s, under a "
                "tracker"
            )
        return self

    @model_validator(mode="after")
    def _within(self) -> Self:
        if self.compliance_um_per_n > self.largest_compliance_um_per_n:
            raise ValueError(
                f"compliance_um_per_n = {self.compliance_um_per_n:g} um/N: must be at most "
                f"largest_compliance_um_per_n, {self.largest_compliance_um_per_n:g}"
            )
        return self

    @model_validator(mode="after")
    def _useful(self) -> Self:
        for row in self.schedule:
            if not (all(value >= 0 for value in row) and 0 < row[5] <= 1 and 0 < row[6] <= 1.5):
                raise ValueError(
                    f"schedule row {row}: gains must be at least 0, the share of the error above 0 and at most 1, the "
                    "trust above 0 and at most 1.5"
                )
        return self
