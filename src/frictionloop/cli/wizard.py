"""Steps of a calibration: what is asked for on the screen, and who answers when nobody is there."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from frictionloop.quantities import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.device.device import Device

Block = Mapping[str, NDArray[np.float64]]
MASSES_G = (0.0, 40.0, 80.0, 120.0, 160.0, 200.0, 160.0, 120.0, 80.0, 40.0, 0.0)
LASTS_S = {"weights": 4.0, "hits": 20.0, "quiet": 10.0, "friction": 12.0}
"""Seconds of a recording, of weights for each weight."""
SAYS = {
    "hits": "Tap the glass with a pen, ten times, and let it ring out each time.",
    "quiet": "Take the finger off, let go of the table.",
    "friction": "Slide a finger to and fro at an even speed; lift it now and then.",
}
TICK_HZ = 5000


class Step(NamedTuple):
    """One recording of a calibration."""

    says: str
    """What is to be done before it."""
    lasts_s: float
    mass_kg: float | None = None


class Line(Protocol):
    """What readings come from: a device, or a rig in its place."""

    def stream(self, duration_s: float, decimation: int) -> Iterator[Block]:
        """Yield ``tick`` and readings as they come."""


def steps_of(kind: str, masses_g: tuple[float, ...] = MASSES_G) -> list[Step]:
    """Return what is to be done, in order.

    Raises ``FrictionloopError`` for masses that are fewer than three, negative or all alike.
    """
    if kind != "weights":
        return [Step(SAYS[kind], LASTS_S[kind])]
    if len(masses_g) < 3 or min(masses_g) < 0 or len(set(masses_g)) < 2:
        listed = ",".join(f"{mass:g}" for mass in masses_g)
        raise FrictionloopError(f"masses_g = {listed}: must be at least three, none below 0, not all alike")
    return [
        Step(f"Hang {mass:g} g and wait until it is still." if mass else "Hang nothing.", LASTS_S[kind], 1e-3 * mass)
        for mass in masses_g
    ]


class Rig:
    """The simulated rig that stands in for hands at ``sim:``: weights, hits and silence of `identification.rigs`."""

    def __init__(self, kind: str, steps: list[Step], seed: int = 0) -> None:
        from frictionloop.identification import rigs

        if kind == "weights":
            masses = [step.mass_kg or 0.0 for step in steps]
            run = rigs.weights_rig(masses, dwell_s=steps[0].lasts_s, seed=seed)
        elif kind == "hits":
            run = rigs.hammer_rig(peak_n=0.3, hits=10, interval_s=steps[0].lasts_s / 10, seed=seed)
        else:
            run = rigs.floor_rig(duration_s=steps[0].lasts_s, seed=seed)
        self._reading, self._at = run["f_m"].values, 0

    def stream(self, duration_s: float, decimation: int) -> Iterator[Block]:
        """Yield the next seconds, a tenth of one at a time."""
        stop = min(self._at + round(duration_s * TICK_HZ), self._reading.size)
        for first in range(self._at, stop, TICK_HZ // 10):
            rows = np.arange(first, min(first + TICK_HZ // 10, stop), decimation)
            yield {"tick": rows.astype(float), "f_m": self._reading[rows]}
        self._at = stop


def with_counts(columns: dict[str, NDArray[np.float64]], device: Device) -> float | None:
    """Add what the converter read, by the calibration that the device has; return newtons in a count.

        counts = f_m / n_per_count + zero_counts

    None, and nothing is added, where the force is the magnitude of two channels, which tells neither.
    """
    if int(device.parameters["force.axes"]) != 1:
        return None
    unit_n = float(np.ravel(device.parameters["force.n_per_count"])[0])
    zero = float(np.ravel(device.parameters["force.zero_counts"])[0])
    columns["counts"] = np.rint(columns["f_m"] / unit_n + zero)
    return unit_n


def line_of(kind: str, steps: list[Step], device: Device, simulated: bool) -> Line:
    """Return what to record: the device, or at ``sim:`` a rig where hands would be needed."""
    return Rig(kind, steps) if simulated and kind != "friction" else device
