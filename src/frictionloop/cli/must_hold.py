"""What a controller has to hold, and for whom, as flags that a design and a check share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Group, Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags

ASKED = Group("What must hold", sort_key=2)
MOST_FINGERS = 100_000
"""More than a population needs for the worst of a thousand, at some 0.1 s each."""


def _asked(said: str) -> Parameter:
    return Parameter(group=ASKED, help=said)


@Parameter(name="*")
@dataclass(frozen=True)
class MustHold:
    """Limits, and how far the bench may be from what is written down.

    What is not given is as the file was designed for, else as the default of `fl.design.Requirements`.
    """

    sensitivity_peak: Annotated[float | None, _asked("Largest Ms = max |1/(1 + G)| as described; 1.7.")] = None
    resonance_error: Annotated[float | None, _asked("Share by which the resonance may be off; 0.05.")] = None
    sensor_error: Annotated[float | None, _asked("The same of the electronics' pole; 0.")] = None
    delay_error: Annotated[float | None, _asked("The same of the delay; 0.")] = None
    gain_error: Annotated[float | None, _asked("The same of the sensitivity; 0.")] = None
    q_error: Annotated[float | None, _asked("The same of the Q; 0.")] = None
    corners: Annotated[
        Path | None,
        _asked("Certificate of ``identify bench``, whose intervals count."),
    ] = None
    speeds: Annotated[str | None, _asked("Slowest and fastest stroke in mm/s: 20,60, or one; that of FILE.")] = None
    slip_lengths_um: Annotated[
        str | None, _asked("Least and largest slip length in um: 0,30, or one; 0 to that of FILE.")
    ] = None
    loads: Annotated[str | None, _asked("Least and largest mean load in N: 0.4,1.2, or one; that of FILE.")] = None
    finger_gain: Annotated[
        float | None, _asked("Largest loop gain over the believed one; controller.model.gain_spread.")
    ] = None

    def requirements(self, file: Path | None) -> Any:
        """Return the same for a design: what is not given is as in the file's table [designed]."""
        speeds = file_arguments.two_values("speeds", self.speeds, "mm/s, such as 20,60, or one")
        loads = file_arguments.two_values("loads", self.loads, file_arguments.LOADS)
        lengths = file_arguments.two_values(
            "slip_lengths_um", self.slip_lengths_um, "um, such as 0,30, or one", zero=True
        )
        shares = (
            "sensitivity_peak",
            "resonance_error",
            "sensor_error",
            "delay_error",
            "gain_error",
            "q_error",
            "finger_gain",
        )
        given: dict[str, Any] = {name: value for name in shares if (value := getattr(self, name)) is not None}
        ranges = {"speeds_mm_s": speeds, "loads_n": loads, "slip_lengths_um": lengths}
        given |= {name: tuple(dict.fromkeys(ends)) for name, ends in ranges.items() if ends}
        if self.corners is not None:
            shared = {"sensor.resonance_hz": self.resonance_error, "sensor.cutoff_hz": self.sensor_error}
            shared |= {"controller.delay_s": self.delay_error, "sensor.q": self.q_error}
            ends = fl.identify.certified_corners(self.corners)
            given["ends"] = tuple((each.path, each.value) for each in ends if not shared.get(each.path))
        table = None if file is None else fl.design.read_designed(file)
        return fl.design.Requirements(**({} if table is None else table.requirements.changes) | given)


@Parameter(name="*")
@dataclass(frozen=True)
class MustHoldForPeople(MustHold):
    """The same, on other people's fingers too."""

    fingers: Annotated[flags.Whole | None, _asked("So many random fingers besides.")] = None
    fingers_seed: Annotated[flags.Whole | None, _asked("Seed of the fingers; 0.")] = None
    coefficients: Annotated[
        str | None,
        _asked("Their least and largest friction coefficient: 0.4,1.2."),
    ] = None
    population: Annotated[Path | None, _asked("Measured population (.toml) they are drawn from.")] = None

    def check(self) -> None:
        """Refuse a number or a seed out of range, and what says where fingers come from without any."""
        whose = {"population": self.population, "coefficients": self.coefficients}
        file_arguments.check_fingers(self.fingers, self.fingers_seed, MOST_FINGERS, **whose)

    def people(self, system: fl.System, overrides: list[str] | None) -> Sequence[Any] | None:
        """Return the fingers; None if none are asked for."""
        if not self.fingers:
            return None
        coefficients = file_arguments.two_values("coefficients", self.coefficients, file_arguments.COEFFICIENTS) or None
        of = {"population": self.population, "coefficients": coefficients, "given": flags.overrides_of(overrides)}
        return fl.fingers_for(system, self.fingers, self.fingers_seed or 0, **of)
