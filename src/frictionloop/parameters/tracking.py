"""Parameters of the tracker: an observer of the friction limit that learns the finger while it slides."""

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
    (33.16, 20.54, 1.35, 9.128, 1.718, 0.4041, 1.388),
    (19.87, 22.57, 1.707, 12.37, 1.176, 0.3765, 0.961),
    (12.81, 22.85, 2.039, 15.91, 1.371, 0.1953, 0.5232),
    (2.057, 12.96, 1.878, 5.418, 0.8959, 0.4114, 1.166),
    (5.807, 12.89, 1.85, 6.527, 0.9136, 0.6174, 1.078),
    (17.03, 11.26, 1.71, 8.878, 0.9622, 0.8726, 0.4678),
    (9.02, 12.84, 1.826, 7.478, 0.9287, 0.794, 1.003),
    (2.233, 11.82, 1.789, 5.017, 1.066, 0.474, 1.367),
    (11.75, 18.06, 2.4, 12.89, 0.9025, 0.1948, 0.8125),
    (19.11, 19.62, 2.194, 13.51, 1.003, 0.09992, 0.5482),
)
"""Gains for the bench at Ms 1.7, its resonance measured: moved from rows that `design.tune_tracker` finds to the least
residual simulated with learning on (chosen on fingers(240, 3); decision 4). Those at 0.75 and of quick sliders are on
the line from that of 0.5 to what is tuned for a slider: farther on it, strokes at 80 mm/s let feel more."""


class TrackerController(Timing):
    """An observer of the friction limit that learns susceptibility and contact, and inverts them (control/tracker)."""

    kind: Literal["tracker"] = "tracker"
    schedule: Schedule = SCHEDULE
    """A row for each of 10 places: shares of the way to its limit that friction goes in a period, 0.07, 0.125,
    0.25, 0.5 and 0.75, a slider's up to 20 mm/s and from 40 mm/s on, then shares of strokes above 70 mm/s: 0.5, 0.25
    and 0.125.

    Gains per newton of innovation: on the limit (N), the friction (N), the springs' force and rate, the reading; then
    the share of the error to correct in a period, and the trust in the newest limit.
    """
    resonance_share: Annotated[Number, Field(gt=0, le=2)] = 0.96
    """Resonance that the observer is given over that of the model: too low is benign, too high fatal (tune_tracker).

    The model's is to be that of the device, measured (`identification.fit_ring_down`): where it is the device's that is
    5 % below the model's, less is left of the margins, and 10 % below the loop is not stable.
    """
    broadened_q: Positive = 7.0
    """Quality factor that the observer is given in place of the model's: broad, it holds for others (tune_tracker)."""
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
