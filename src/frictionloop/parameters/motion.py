"""Parameters of how the finger moves and presses, endless or in strokes, and of what is measured of that."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from frictionloop.parameters.block import Block, Kinds, NotNegative, Number, Positive, Whole
from frictionloop.quantities import must_be

TURN_SHARE = 0.625
"""Distance covered in a reversal over that at full speed for as long, 5/8 (physics/motion)."""
IN_STEP = 1e-3
"""Share by which a stroke may last longer than a contact with the lift after it, and count as one with it."""


class Sliding(Block):
    """The finger always slides; its position, speed and load are not known (paper, Sec. 2)."""

    kind: Literal["sliding"] = "sliding"


class Strokes(Block):
    """Back and forth at a constant speed with smooth reversals, under a load that drifts, trembles and lifts."""

    kind: Literal["strokes"] = "strokes"
    speed_mm_s: Positive = 20.0
    """Speed between reversals (paper, Sec. 4.2)."""
    stroke_mm: Positive = 60.0
    """Distance between the two ends, around the middle of the plate (assumed)."""
    reversal_s: Positive = 0.1
    """Time from full speed to full speed the other way (assumed)."""
    start: Annotated[Number, Field(ge=0, le=1)] = 0.0
    """Where in the cycle t = 0 is: 0 at rest at the left end, 0.25 mid-stroke going right, 0.5 at the right end."""
    load_n: Positive = 0.5
    """Mean normal force in contact (0.49 N: Smith 2002)."""
    load_drift: Annotated[Number, Field(ge=0, lt=0.5)] = 0.1
    """Standard deviation of the slow drift of the load, relative (0.1 to 0.2, assumed)."""
    load_drift_s: Positive = 10.0
    """Period of the faster of the drift's two components (assumed)."""
    tremor_um: NotNegative = 30.0
    """Standard deviation of the tremor's displacement along the stroke (about 30 um: Growdon 2000)."""
    tremor_n: NotNegative = 0.03
    """Standard deviation of the tremor's normal force (15 to 60 mN, assumed: 30 um on 0.5 to 2 N/mm)."""
    tremor_hz: Annotated[Number, Field(ge=1, le=50)] = 10.0
    """Frequency at which the tremor's spectrum peaks (8 to 12 Hz: Sutton & Sykes 1967)."""
    tremor_width_hz: Annotated[Number, Field(ge=0.1, le=50)] = 4.0
    """Width of that peak at half power (assumed: 8 to 12 Hz)."""
    landing_s: Positive = 0.05
    """Duration of the load's rise at landing and of its fall at lift-off (assumed)."""
    contact_s: NotNegative = 0.0
    """Time on the plate from landing to lift-off, both included; 0: landed before t = 0, never lifts."""
    lifted_s: Positive = 0.5
    """Time in the air between lift-off and landing, where ``contact_s`` is not 0 (assumed)."""
    person: Annotated[Whole, Field(ge=0, lt=2**31)] = 0
    """Number of the person: others tremble otherwise, and over other skin, at the same seed."""
    unscored_n: NotNegative = 1.0
    """Friction force F that a reversal is taken to turn over; metrics leave out the way that the skin yields meanwhile.

    That is 2F/k on both sides of the turn: 2 mm at a stiffness of 1000 N/m, and as much for a rigid finger. On a stroke
    of less than twice that nothing counts. Nothing counts below half the mean load either.
    """

    def _check(self) -> None:
        longest = self.stroke_mm / (TURN_SHARE * self.speed_mm_s)
        if self.reversal_s > longest:
            raise ValueError(
                f"reversal_s = {self.reversal_s:g} s at {self.speed_mm_s:g} mm/s: must be at most {longest:.6g}, or "
                f"stroke_mm at least {TURN_SHARE * self.speed_mm_s * self.reversal_s:.6g}"
            )
        if 0 < self.contact_s < 2 * self.landing_s:
            raise must_be("contact_s", self.contact_s, f"0 or at least {2 * self.landing_s:g}", "s")

    def in_contacts(self) -> dict[str, float]:
        """Return overrides with which each contact is one stroke, which turns in the air."""
        return {
            "motion.stroke_mm": self.speed_mm_s * (self.contact_s + TURN_SHARE * self.lifted_s),
            "motion.reversal_s": self.lifted_s,
            "motion.start": 0.25 * self.lifted_s / (self.contact_s + self.lifted_s),
        }

    @property
    def plateau_s(self) -> float:
        """Time at full speed in one stroke."""
        return self.stroke_mm / self.speed_mm_s - TURN_SHARE * self.reversal_s

    @property
    def cycle_s(self) -> float:
        """Time of one stroke there and back."""
        return 2.0 * (self.plateau_s + self.reversal_s)


def one_stroke_a_contact(motion: Strokes) -> bool:
    """Tell whether each contact is one stroke, which turns in the air, as `Strokes.in_contacts` makes it."""
    period_s = motion.contact_s + motion.lifted_s
    in_step = abs(0.5 * motion.cycle_s - period_s) < IN_STEP * period_s
    return motion.contact_s > 0.0 and in_step and motion.reversal_s <= motion.lifted_s * (1.0 + IN_STEP)


Motion = Annotated[Sliding | Strokes, Kinds(Block, Sliding, Strokes, default="sliding")]


class PositionSensor(Block):
    """Position along the stroke: white noise, and a speed from an alpha-beta filter without lag at constant speed."""

    noise_um: NotNegative = 10.0
    """Standard deviation of one sample (assumed; 25 um features with the sensor of the paper's ref. [14])."""
    resolution_um: NotNegative = 0.0
    """Step that a sample is rounded to; 0: none (assumed: the steps are lost in the noise)."""
    fastest_mm_s: Positive = 500.0
    """Fastest stroke the sensor follows (assumed)."""
    tracking_hz: Positive = 45.0
    """Bandwidth of the filter that gives the speed (assumed: tremor of 10 Hz is followed, and noise is 0.3 mm/s)."""


class LoadCells(Block):
    """Four normal-force sensors at the corners of the plate (paper, Sec. 4.1)."""

    noise_n: NotNegative = 1e-3
    """Standard deviation of one sample of one cell (assumed)."""
    length_mm: Positive = 255.0
    """Distance between cells along the stroke (paper, Sec. 4.1: the plate's length)."""
    touch_n: Positive = 0.02
    """Least measured load that counts as touch (assumed: ten standard deviations of its noise)."""
    touch_share: Annotated[Number, Field(ge=0, lt=1)] = 0.7
    """Least share of the load's running mean under which a reading is valid: a finger that lifts is let go early
    (assumed)."""
    mean_s: Positive = 0.5
    """Time constant of that mean, which waits while nothing touches (assumed)."""
    least_speed_mm_s: NotNegative = 2.0
    """Least measured speed that counts as sliding (assumed)."""
    speed_share: Annotated[Number, Field(ge=0, lt=1)] = 0.25
    """Least share of the running mean of the speed at which a reading is valid: a finger that turns is let go early.

    The tracked speed is late by 2/w, w of ``tracking_hz``, while a reversal in R goes down by 3 v/R: 6/(w R) of v, 0.21
    in 0.1 s.
    """
    developed_mm: NotNegative = 0.635
    """Way from landing to a skin that is stretched, F/k + 3 z, after which a reading is valid; a turn takes it twice.

    F is 0.6 N and k 1000 N/m; after three slip lengths z friction is at 95 % (assumed).
    """
    turn_mm: NotNegative = 0.22
    """Way back that is a turn: as far as a tremor of 30 um rms goes back once in 1,000 periods, 2 (2 ln 1000)^(1/2) of
    it."""


class Touch(Block):
    """What the controller gets to know besides the friction force."""

    position: PositionSensor = PositionSensor()
    """Position sensor."""
    load: LoadCells = LoadCells()
    """Load cells."""
