"""A calibration recorded from a device, step by step: weights, hits, silence or slides; and what to play meanwhile."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol, get_args

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from frictionloop.findings import Condition, Finding, Result
from frictionloop.findings.result import Row
from frictionloop.identification import rigs
from frictionloop.identification.weights_calibration import MASSES
from frictionloop.parameters import System, check_system
from frictionloop.parameters.input_signals import ColouredNoise, Signal, Sine, Steps
from frictionloop.parameters.plant import Friction
from frictionloop.physics.friction import friction_force
from frictionloop.quantities import check_known, must_be, replacing
from frictionloop.quantities.value_checks import number

LEVELS = 7
DWELL_S = 0.7
"""Time at each level: longer than a turn of the finger, and no part of a stroke of 3 s (assumed)."""
SWEEP_HZ, NOISE_HZ = 0.31, 2.0
"""Slow for the skin, and not in step with strokes; noise ends where the skin no longer follows (assumed)."""


def amplitude_protocol(
    system: System, form: Literal["steps", "sweep", "noise"] = "steps", duration_s: float = 60.0, seed: int = 0
) -> Signal:
    """Return a set-point that, in open loop, drives the plate through all its amplitudes.

    In open loop the lookup table turns the set-point u into the amplitude a = sqrt(ln(f0/u)/tau) by
    ``controller.model``, so u = f0 exp(-tau a^2) commands any a, whatever the finger's own f0 and tau are. Steps take
    seven levels, even in a^2 from 0 to the largest, in random order; sweep is a slow sine of the force; noise is that
    of the force, mostly below 2 Hz.

    Parameters
    ----------
    system : System
        Its ``controller.model`` and the plate's largest amplitude.
    form : str
        "steps", "sweep" (the one that a device plays exactly, with its table of 1024 points) or "noise".
    duration_s : float
        Time in s, at least 5.
    seed : int
        Seed of the order of the steps.

    Raises
    ------
    FrictionloopError
        For another form or a time too short.
    """
    check_system(system)
    number("duration_s", duration_s, "s", 5.0)
    model = system.controller.model
    law = Friction(nominal_n=model.nominal_n, susceptibility_per_um2=model.susceptibility_per_um2)
    largest = min(model.max_amplitude_um, system.plate.max_amplitude_um)
    low = float(friction_force(largest, law))
    middle, half = (law.nominal_n + low) / 2, (law.nominal_n - low) / 2
    if form == "steps":
        count = math.ceil(duration_s / DWELL_S)
        rng = np.random.default_rng(seed)
        order = np.concatenate([rng.permutation(LEVELS) for _ in range(math.ceil(count / LEVELS))])[:count]
        forces = friction_force(largest * np.sqrt(order / (LEVELS - 1)), law)
        return Steps(times_s=tuple((DWELL_S * np.arange(count)).tolist()), levels_n=tuple(forces.tolist()))
    if form == "sweep":
        return Sine(offset_n=middle, amplitude_n=half, frequency_hz=SWEEP_HZ)
    if form == "noise":
        return ColouredNoise(offset_n=middle, rms_n=half / 2, exponent=2.0, low_hz=0.2, high_hz=NOISE_HZ)
    raise must_be("form", form, "'steps', 'sweep' or 'noise'")


Block = Mapping[str, NDArray[np.float64]]
Kind = Literal["weights", "hits", "quiet", "friction"]
MASSES_G = (0.0, 40.0, 80.0, 120.0, 160.0, 200.0, 160.0, 120.0, 80.0, 40.0, 0.0)
LASTS_S = {"weights": 4.0, "hits": 20.0, "quiet": 10.0, "friction": 12.0}
"""Seconds of a recording, of weights for each weight."""
SAYS = {
    "hits": "ten taps with a pen",
    "quiet": "finger off, table untouched",
    "friction": "slide both ways, sometimes lift",
}
RIG_HZ = 5000.0
"""Samples of the simulated rig."""
TENTH = 500
"""Of these in a tenth of a second."""
COLUMNS = {"weights": ("f_m",), "hits": ("f_m",), "quiet": ("f_m",), "friction": ("f_m", "load", "position")}
UNITS = {"counts": "counts", "f_m": "N", "load": "N", "position": "m", "mass": "kg", "time": "s"}


class Step(NamedTuple):
    """One recording of a calibration."""

    number: int
    """From 1."""
    of: int
    says: str
    """What is to be done before it."""
    lasts_s: float
    mass_kg: float | None = None


Ask = Callable[[Step], object]
Watch = Callable[[Block], object]


class Line(Protocol):
    """What readings come from: a device, or a rig in its place."""

    def stream(self, duration_s: float, decimation: int) -> Iterator[Block]:
        """Yield ``tick`` and readings as they come."""


class Recorded(Result, schema="identify.run/1", without="columns"):
    """What was recorded from a device."""

    kind: str
    samples: int
    lost_samples: int
    duration_s: float
    newtons_per_count: float | None
    """By the device's calibration; None where it tells none."""
    columns: Mapping[str, NDArray[np.float64]]
    rate_hz: float
    project: str = ""
    """The entry of a project file, once it is known where the recording is (`saved_at`)."""

    def rows(self) -> list[Row]:
        """Return how long it is, and the lines of a project file."""
        found = [(self.kind, f"{self.duration_s:.1f} s, {self.samples} samples, {self.lost_samples} lost")]
        return [*found, *(("project" if k == 0 else "", line) for k, line in enumerate(self.project.splitlines()))]

    def recording(self) -> xr.Dataset:
        """Return the samples as the analyses take them, over ``time`` in s."""
        data = {n: ("time", v, {"units": UNITS[n]}) for n, v in self.columns.items() if n != "time"}
        return xr.Dataset(data, {"time": ("time", self.columns["time"], {"units": "s"})})

    def channel_map(self) -> str:
        """Return the channel map in TOML."""
        names = (*COLUMNS[self.kind], *(("mass",) if self.kind == "weights" else ()))
        lines = [f"# identify run {self.kind}"]
        for name in names:
            column = "counts" if name == "f_m" and self.newtons_per_count is not None else name
            lines += ["", f"[channels.{name}]", f'column = "{column}"', f'unit = "{UNITS[column]}"']
            if column == "counts":
                lines.append(f"newtons_per_unit = {self.newtons_per_count:.9g}  # without weights")
        return "\n".join(lines) + "\n"

    def write(self, path: str | os.PathLike[str]) -> Path:
        """Write the recording (.h5) and its channel map beside it, whose path is returned."""
        import h5py

        chart = map_beside(path)
        with replacing(path) as beside, h5py.File(beside, "w") as file:
            file.attrs["fs"] = self.rate_hz
            for name, values in self.columns.items():
                file[name] = values
                file[name].attrs["units"] = UNITS[name]
        with replacing(chart) as beside:
            beside.write_text(self.channel_map(), encoding="utf-8")
        return chart

    def saved_at(self, path: str | os.PathLike[str]) -> Recorded:
        """Return it with the entry of a project file, for a recording written to this path."""
        kind = "slides" if self.kind == "friction" else self.kind
        lines = ["[[recording]]", f'kind = "{kind}"', f'files = ["{Path(path).name}"]']
        return replace(self, project="\n".join([*lines, f'map = "{map_beside(path).name}"', ""]))


def map_beside(path: str | os.PathLike[str]) -> Path:
    """Return where the channel map of a recording stands."""
    return Path(path).with_name(f"{Path(path).stem}-map.toml")


def run(
    kind: Kind,
    device: Any,
    masses_g: tuple[float, ...] = MASSES_G,
    *,
    ask: Ask | None = None,
    watch: Watch | None = None,
) -> Recorded:
    """Record one measurement of a calibration from a device; the plate stays off.

    At ``sim:`` rigs stand in for hands that hang weights, tap, and let go.

    Parameters
    ----------
    kind : str
        "weights", "hits", "quiet" or "friction".
    device : Device
        From ``fl.connect``.
    masses_g : sequence of float
        Weights in g in the order in which they are hung, at least three, none negative, not all alike.
    ask : callable, optional
        Called before each step, and returns when it may begin.
    watch : callable, optional
        Called with every block of samples as it comes.

    Raises
    ------
    FrictionloopError
        For an unknown kind, masses that are no calibration, or a device that sends no samples.
    """
    check_known("kind", [kind], get_args(Kind))
    steps = steps_of(kind, masses_g)
    simulated = device.address.startswith("sim:")
    line: Line = Rig(kind, steps) if simulated and kind != "friction" else device
    rate_hz, tick_hz = (RIG_HZ, RIG_HZ) if isinstance(line, Rig) else (device.sample_hz, device.info.tick_hz)
    columns = recorded(kind, steps, line, ask or (lambda step: None), watch or (lambda block: None), rate_hz, tick_hz)
    unit_n = with_counts(columns, device)
    time = columns["time"]
    lost = int(np.sum(np.rint(np.diff(time) * rate_hz) - 1)) if time.size > 1 else 0
    row = int(np.argmax(np.diff(time) * rate_hz > 1.5)) if lost else 0
    gaps = [Finding("DATA-GAPS", value=lost, where=Condition(recording=kind), more={"row": row})] if lost else []
    return Recorded(
        kind=kind,
        samples=time.size,
        lost_samples=lost,
        duration_s=time.size / rate_hz,
        rate_hz=rate_hz,
        newtons_per_count=unit_n,
        columns=columns,
        findings=tuple(gaps),
    )


def steps_of(kind: str, masses_g: tuple[float, ...] = MASSES_G) -> list[Step]:
    """Return what is to be done, in order.

    Raises ``FrictionloopError`` for masses that are fewer than three, negative or all alike.
    """
    if kind != "weights":
        return [Step(1, 1, SAYS[kind], LASTS_S[kind])]
    if len(masses_g) < 3 or min(masses_g) < 0 or len(set(masses_g)) < 2:
        raise must_be("masses_g", list(masses_g), MASSES, "g")
    count, lasts_s = len(masses_g), LASTS_S[kind]
    return [
        Step(k + 1, count, f"hang {mass:g} g, wait until still", lasts_s, 1e-3 * mass)
        for k, mass in enumerate(masses_g)
    ]


def recorded(
    kind: str, steps: list[Step], line: Line, ask: Ask, watch: Watch, rate_hz: float, tick_hz: float
) -> dict[str, NDArray[np.float64]]:
    """Return the columns of all steps, one after the other; times of steps follow each other without a gap."""
    parts: list[dict[str, NDArray[np.float64]]] = []
    began_s = 0.0
    for step in steps:
        ask(step)
        blocks = []
        for block in line.stream(step.lasts_s, round(tick_hz / rate_hz)):
            watch(block)
            blocks.append(block)
        if not blocks:
            raise must_be("device: samples", 0, "1 or more")
        tick = np.concatenate([block["tick"] for block in blocks])
        part = {name: np.concatenate([block[name] for block in blocks]) for name in COLUMNS[kind]}
        part["time"] = began_s + ((tick - tick[0]) % 2**32) / tick_hz
        if step.mass_kg is not None:
            part["mass"] = np.full(tick.size, step.mass_kg)
        began_s = float(part["time"][-1]) + 1.0 / rate_hz
        parts.append(part)
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


class Rig:
    """The simulated rig that stands in for hands at ``sim:``: weights, hits and silence."""

    def __init__(self, kind: str, steps: list[Step], seed: int = 0) -> None:
        if kind == "weights":
            masses = [step.mass_kg or 0.0 for step in steps]
            found = rigs.weights_rig(masses, dwell_s=steps[0].lasts_s, seed=seed)
        elif kind == "hits":
            found = rigs.hammer_rig(peak_n=0.3, hits=10, interval_s=steps[0].lasts_s / 10, seed=seed)
        else:
            found = rigs.floor_rig(duration_s=steps[0].lasts_s, seed=seed)
        self._reading, self._at = found["f_m"].values, 0

    def stream(self, duration_s: float, decimation: int) -> Iterator[Block]:
        """Yield the next seconds, a tenth of one at a time."""
        stop = min(self._at + round(duration_s * RIG_HZ), self._reading.size)
        for first in range(self._at, stop, TENTH):
            rows = np.arange(first, min(first + TENTH, stop), decimation)
            yield {"tick": rows.astype(float), "f_m": self._reading[rows]}
        self._at = stop


def with_counts(columns: dict[str, NDArray[np.float64]], device: Any) -> float | None:
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
