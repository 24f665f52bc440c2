"""Parameters of what tells where and how hard the finger touches: a position sensor and four load cells."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from frictionloop.parameters.block import Block, NotNegative, Number, Positive


class PositionSensor(Block):
    """Position along the stroke: white noise, and a speed from a tracker without lag at constant speed."""

    noise_um: NotNegative = 10.0
    """Standard deviation of one sample (assumed; 25 um features with the sensor of the paper's ref. [14])."""
    fastest_mm_s: Positive = 500.0
    """Fastest stroke the sensor follows (assumed)."""
    tracking_hz: Positive = 45.0
    """Bandwidth of the tracker that gives the speed (assumed: tremor of 10 Hz is followed, and noise is 0.3 mm/s)."""


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
    developed_mm: NotNegative = 0.5
    """Way since landing before a reading is valid: the skin stretches by F/k, and the load still rises (assumed)."""


class Touch(Block):
    """What the controller gets to know besides the friction force."""

    position: PositionSensor = PositionSensor()
    """Position sensor."""
    load: LoadCells = LoadCells()
    """Load cells."""
