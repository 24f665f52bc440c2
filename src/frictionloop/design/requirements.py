"""What a controller has to hold, and what comes of a synthesis."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, NamedTuple

from frictionloop.design.grid_corners import Corner
from frictionloop.design.operating_grid import Lean, OperatingGrid
from frictionloop.findings import Finding
from frictionloop.parameters import SuspendedSensor, System
from frictionloop.parameters.controller import LONGEST_DELAY
from frictionloop.parameters.input_signals import largest_n
from frictionloop.quantities import FrictionloopError, must_be

SEARCHED, CHECKED, COARSE = (3, 2), (9, 3), (2, 3)
"""How many speeds and loads a search begins with, its result is looked at, and other places are."""
WIDER = (1.0, 10.0 / 7.0, 16.0 / 7.0)
"""How Ms - 1 may grow with the resonance off by 0, e and 2 e: 1.7, 2.0 and 2.6."""


@dataclass(frozen=True)
class Requirements:
    """What a controller has to hold."""

    sensitivity_peak: float = 1.7
    """Largest Ms with the resonance as described, above 1."""
    resonance_error: float = 0.05
    """Share by which the resonance may be off, either way, 0 to 0.25; at twice that it still has to be calm."""
    speeds_mm_s: tuple[float, ...] = ()
    """Speeds of the stroke at which all that holds, and between which it does; none: that of the system."""
    slip_lengths_um: tuple[float, ...] | None = None
    """Slip lengths of a skin at which all that holds, and between which it does; empty: that of the system. None: from
    0 to that of the system, as nobody knows a finger's, and that of the system alone where the range cannot be had."""
    loads_n: tuple[float, ...] = ()
    """Mean loads at which all that holds, and between which it does, N; none: that of the system."""
    finger_gain: float | None = None
    """Loop gain over the believed one up to which Ms is at most `MOST_PEAK`; None: ``controller.model.gain_spread``."""
    sensor_error: float = 0.0
    """Share by which the pole of the electronics may be off, 0 to 0.5, as of the next; the same limits hold."""
    delay_error: float = 0.0
    gain_error: float = 0.0
    """Of the sensor's sensitivity."""
    q_error: float = 0.0
    """Of the Q of the sensor's resonance, at one end or the other with all else as described."""
    ends: tuple[tuple[str, float], ...] = ()
    """Values that the bench may have instead, by dotted name, one at a time: ends of measured intervals."""

    def __post_init__(self) -> None:
        if not 1.0 < self.sensitivity_peak <= 10.0:
            raise must_be("sensitivity_peak", self.sensitivity_peak, "above 1, up to 10")
        if not 0.0 <= self.resonance_error <= 0.25:
            raise must_be("resonance_error", self.resonance_error, "from 0 to 0.25")
        self.lean.check()
        if self.finger_gain is not None and not 1.0 <= self.finger_gain <= 10.0:
            raise must_be("finger_gain", self.finger_gain, "from 1 to 10")
        for name in ("speeds_mm_s", "loads_n"):
            if not all(0.0 < each < math.inf for each in getattr(self, name)):
                raise must_be(name, getattr(self, name), "above 0")
        if not all(0.0 <= each <= 1000.0 for each in self.slip_lengths_um or ()):
            raise must_be("slip_lengths_um", self.slip_lengths_um, "from 0 to 1000")

    @property
    def lean(self) -> Lean:
        """How far loops lean."""
        return Lean(self.sensor_error, self.delay_error, self.gain_error, self.q_error, self.ends)

    @property
    def changes(self) -> dict[str, Any]:
        """What is not as usual, by name."""
        return {each.name: value for each in fields(self) if (value := getattr(self, each.name)) != each.default}

    def grid(self, speeds: int | None = None, loads: int | None = None) -> OperatingGrid:
        """Return where all that holds, at so many speeds and loads; as they are listed without."""
        places = _spread(self.speeds_mm_s, speeds), _spread(self.loads_n, loads)
        return OperatingGrid(self.slip_lengths_um, *places, self.limits, self.lean)

    def gain_of(self, system: System) -> float:
        """Return the largest loop gain of a finger over the believed one."""
        return system.controller.model.gain_spread if self.finger_gain is None else self.finger_gain

    @property
    def limits(self) -> dict[float, float]:
        """Largest Ms by the share that the resonance is off: {0: 1.7, 0.05: 2.0, 0.1: 2.6}."""
        return self.scaled(1.0)

    def scaled(self, share: float) -> dict[float, float]:
        """Return the limits with so much of Ms - 1."""
        room = (self.sensitivity_peak - 1.0) * share
        wider = WIDER if self.resonance_error > 0 else WIDER[:1]
        return {k * self.resonance_error: round(1.0 + room * factor, 12) for k, factor in enumerate(wider)}


def _spread(values: tuple[float, ...], count: int | None) -> tuple[float, ...]:
    """Return so many values in equal ratios from the lowest to the highest; one where they are the same."""
    if not values or count is None:
        return values
    low, high = min(values), max(values)
    return (low,) if low == high else tuple(low * (high / low) ** (k / (count - 1)) for k in range(count))


class Designed(NamedTuple):
    """What comes of a synthesis."""

    overrides: Mapping[str, Any]
    """For ``System.evolve``."""
    findings: tuple[Finding, ...] = ()
    corners: tuple[Corner, ...] = ()
    """Its margins wherever it was looked at."""


def springs_told(system: System) -> dict[str, float]:
    """Return what the controller must believe of the springs that its notch is made for, where it believes otherwise.

    Feed-forward expects the force behind the springs that are believed.
    """
    model, sensor = system.controller.model, system.sensor
    assert isinstance(sensor, SuspendedSensor)  # as for a notch
    true = {"resonance_hz": sensor.resonance_hz, "resonance_q": sensor.q}
    return {f"controller.model.{name}": value for name, value in true.items() if value != getattr(model, name)}


def unheld(law: str, asked: Requirements, worst: Corner) -> FrictionloopError:
    """Return the error of a law that does not hold: how far it gets, where, and the nearest that may hold."""
    room = (worst.sensitivity_peak - 1.0) / (worst.limit - 1.0) * (asked.sensitivity_peak - 1.0)
    peak = f"{worst.sensitivity_peak:.3g}"
    peak = f"{worst.sensitivity_peak:.5g}" if peak == f"{worst.limit:.3g}" else peak
    nearest = f"; --sensitivity-peak {math.ceil(100 * (1.0 + room)) / 100:g} may hold" * (room < 10.0)
    other = "" if law == "pi" else ", or --law pi"
    return FrictionloopError(
        f"law {law}: Ms {peak}, {worst.limit:.3g} asked, {worst.condition}{nearest}{other}", NOT_HELD
    )


NOT_HELD = "NO-CONTROLLER"
"""Code of a design that ends without one."""


def feedforward(system: System) -> tuple[bool, tuple[Finding, ...]]:
    """Return whether feed-forward can follow delay and set-point, and why not.

    Where the set-point reaches the believed f0 its command has no room above: the overdrive is clipped to one side.
    """
    controller = system.controller
    highest_n, nominal_n = largest_n(system.setpoint), controller.model.nominal_n
    if highest_n >= nominal_n:
        return False, (Finding("FORWARD-CLIPPED", value=highest_n, unit="N", limit=nominal_n),)
    periods = controller.delay_s * controller.rate_hz
    if periods <= LONGEST_DELAY * (1 + 1e-9):
        return True, ()
    return False, (Finding("FORWARD-DELAY", value=periods, limit=LONGEST_DELAY),)
