"""What a controller has to hold, as flags that the commands on controllers share."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Group, Parameter

from frictionloop.cli import checks

if TYPE_CHECKING:
    from frictionloop.design.wanted import Wanted

ASKED = Group("What must hold", sort_key=2)


def _asked(said: str) -> Parameter:
    return Parameter(group=ASKED, help=said)


@Parameter(name="*")
@dataclass(frozen=True)
class MustHold:
    """Limits, and how far the bench may be from what is written down."""

    sensitivity_peak: Annotated[float, _asked("Largest Ms = max |1/(1 + G)| with the resonance as described.")] = 1.7
    resonance_error: Annotated[
        float,
        _asked(
            "Share by which the resonance may be off. Then, and at twice that, Ms may be larger: 2.0 and 2.6 if 1.7 "
            "is asked. Of one known to 15 % take 0.15; where that leaves too little gain, 0.075 holds the wider limit "
            "at 15 %."
        ),
    ] = 0.05
    sensor_error: Annotated[
        float,
        _asked(
            "Share by which the pole of the sensor's electronics may be off; the same limits hold. So do they for the "
            "next."
        ),
    ] = 0.0
    delay_error: Annotated[float, _asked("Share by which the delay may be off.")] = 0.0
    gain_error: Annotated[float, _asked("Share by which the sensor's sensitivity may be off.")] = 0.0
    q_error: Annotated[
        float, _asked("Share by which the Q of the sensor's resonance may be off, either way, all else as described.")
    ] = 0.0
    corners: Annotated[
        Path | None,
        _asked(
            "Certificate of ``identify bench`` (.html, or --json): each value that it measured may also be at either "
            "end of its interval, one at a time. Those that a share above covers are not."
        ),
    ] = None
    speeds: Annotated[
        str | None,
        _asked(
            "Slowest and fastest stroke in mm/s, between which all that holds: 20,60, or one; that of FILE if not "
            "given."
        ),
    ] = None

    slip_lengths_um: Annotated[
        str | None,
        _asked(
            "Least and largest slip length in um, between which all that holds: 0,30, or one; from 0 to that of FILE "
            "if not given."
        ),
    ] = None
    loads: Annotated[
        str | None,
        _asked(
            "Least and largest mean load in N, between which that holds: 0.4,1.2, or one; that of FILE if not given. "
            "A force that a finger cannot be given at a load counts as the nearest that it can."
        ),
    ] = None

    finger_gain: Annotated[
        float | None,
        _asked(
            "Loop gain of a finger over the believed one up to which Ms is at most 2.9: 2.7 of a finger that nobody "
            "measured, 1.1 of one whose friction and susceptibility are in FILE; controller.model.gain_spread if not "
            "given."
        ),
    ] = None

    @property
    def stated(self) -> set[str]:
        """Parameters that the flags give values of."""
        return {"motion.load_n"} if self.loads else set()

    def wanted(self) -> Wanted:
        """Return the same for a design."""
        from frictionloop.design.leaning import Lean
        from frictionloop.design.wanted import Wanted

        between = checks.two_values("speeds", self.speeds, "the slowest and the fastest in mm/s, such as 20,60, or one")
        loads = checks.two_values("loads", self.loads, checks.LOADS)
        asked = "the least and the largest in um, such as 0,30, or one"
        lengths = checks.two_values("slip_lengths_um", self.slip_lengths_um, asked, zero=True) or None
        shares = {"sensor.resonance_hz": self.resonance_error, "sensor.cutoff_hz": self.sensor_error}
        shares |= {"controller.delay_s": self.delay_error, "sensor.q": self.q_error}
        ends = _ends(self.corners, shares)
        lean = Lean(self.sensor_error, self.delay_error, self.gain_error, self.q_error, ends)
        return Wanted(self.sensitivity_peak, self.resonance_error, between, lean, lengths, loads, self.finger_gain)


def _ends(certificate: Path | None, shares: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """Return the ends of intervals that a certificate lists, but of values that a share covers."""
    if certificate is None:
        return ()
    from frictionloop.identification.certified import certified_corners

    return tuple((each.path, each.value) for each in certified_corners(certificate) if not shares.get(each.path))
