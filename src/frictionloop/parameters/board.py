"""Parameters of a builder's board: how sensors and plate are wired to it, and the limits it keeps by itself."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator, Field

from frictionloop.parameters.block import Block, Number, Positive, Whole


def _is_there(value: float) -> float:
    if value == 0:
        raise ValueError("must not be 0")
    return value


Counts = Annotated[Whole, Field(ge=-(2**15), le=2**15 - 1)]
"""Reading of a converter, 16 bit."""


class Board(Block):
    """The wiring of the microcontroller's board, which only a device has: a simulation does not depend on it.

    The force along the motion is ``force_n_per_count * (counts - force_zero_counts[0])``, load and position likewise; a
    scale may be negative, which turns the sign. A channel with scale 0 is one that the bench has not got.
    """

    force_axes: Annotated[Whole, Field(ge=1, le=2)] = 1
    """1: the first channel is the force, positive when it opposes the motion; 2: the magnitude of both channels is.

    A sensor that is fixed to the bench reads the other sign on the way back, and needs 2 (docs/firmware-states).
    """
    force_zero_counts: tuple[Counts, Counts] = (0, 0)
    """What the two force channels read at no force."""
    force_n_per_count: Annotated[Number, AfterValidator(_is_there)] | None = None
    """Force of a count of the first channel; left out: 16 bit over the sensor's range both ways (2.5 N if it has none).
    """
    across_n_per_count: Number = 0.0
    """Force of a count of the second channel; 0: there is none."""
    load_zero_counts: Counts = 0
    """What the load channel reads at no load."""
    load_n_per_count: Number = 10.0 / 2**16
    """Load of a count (assumed: 16 bit over 5 N both ways, ten times the usual load); 0: no load cells."""
    position_m_per_count: Number = 1e-6
    """Way of a count (assumed: a tenth of the sensor's noise); 0: no position sensor."""
    ceiling_um: Positive | None = None
    """Largest amplitude ever commanded; left out: the plate's largest."""
    ramp_s: Annotated[Positive, Field(le=0.1)] = 0.01
    """Time to ramp down the largest amplitude (assumed: six time constants of the plate in bench()), at most 0.1 s."""
    force_limit_n: Positive | None = None
    """Largest plausible force, below what the converter reads; left out: 0.96 of its range (assumed: short of it)."""
    hum_share: Annotated[Positive, Field(le=1.0)] = 0.12
    """Mains pick-up that is tolerated, peak to peak over the sensor's range (assumed: 0.3 N of 2.5 N); more is a fault.

    The loop takes what is tolerated for force, and errs by half of it. A set-point that moves by an eighth of it within
    26 ms hides the mains, so a smaller one is watched for less of the time.
    """
