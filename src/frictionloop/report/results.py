"""Everything that figures and claims are made of, and what each is cited by: version, command and seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import xarray as xr

from frictionloop.loop.progress import Bar, silent
from frictionloop.parameters import System, feasible, paper
from frictionloop.quantities.version import cited_version
from frictionloop.report import (
    beyond,
    calibration,
    effect_arrivals,
    gain_stability,
    gains,
    other_fingers,
    paper_protocol,
    sensor_noise,
    systems,
)


def command_of(name: str) -> str:
    """Return the command that makes a figure again."""
    return f"frictionloop reproduce --only {name}"


def cited(command: str, seeds: str) -> tuple[str, str, str]:
    """Return version, command and seeds in words; of a clone the version ends with the commit."""
    words = f"seeds {seeds}" if seeds not in ("none", "") else "no random numbers"
    return f"frictionloop {cited_version()}", command, words


HALF = "half a period of delay"
"""What the text leaves open with which the optimum is the printed one."""


class Field(NamedTuple):
    """What a field of ``Results`` is for, as the progress line says it, and the seeds of its runs."""

    words: str
    seeds: str


FIELDS = {
    "population": Field("Fig. 1a, sliding trials", "0"),
    "maps": Field("Fig. 2a, map of both gains", "0 and 1"),
    "over_kp": Field("Fig. 2a, proportional gain", "0 to 3"),
    "per_sample": Field("Fig. 2a, Ki per sample", "0 to 3"),
    "over_ki": Field("Fig. 2a, integral gain", "0 to 3"),
    "runs": Field("Fig. 2b to 2d", "0"),
    "noise": Field("Fig. 2e and 2f", "0 to 7"),
    "variants": Field("Fig. 2a, what the text leaves open", "0 to 3"),
    "steady": Field("equation (3)", "0"),
    "rigs": Field("Fig. 4, weights, hammer and silence", "0"),
    "tracked": Field("Fig. 5a", "0 to 14"),
    "stepped": Field("Fig. 5b and 5c", "0 to 4"),
    "stronger": Field("Fig. 5b, a stronger plate", "0 to 4"),
    "felt": Field("what is felt", "5"),
    "fluctuations": Field("where fluctuations come from", "5 to 9"),
    "people": Field("Fig. 5a, 26 fingers", "0, 5 and 10, fingers of seed 1"),
    "checked": Field("where the re-tuned gains hold", "0 to 14, of gains that hold"),
    "beyond": Field("laws, a stored study", "11, of the stored study"),
    "arrivals": Field("effects, a stored study", "0, fingers of seed 11, of the stored study"),
}
"""In the order of the page."""


class Results:
    """The data of the report, each field computed when it is first asked for, once.

    A dictionary is keyed by the names of ``systems.compared()``.
    """

    population: xr.Dataset
    maps: dict[str, xr.Dataset]
    over_kp: dict[str, xr.Dataset]
    per_sample: dict[str, xr.Dataset]
    """The same as ``over_kp`` if Ki = 2 is per sample; names say so."""
    over_ki: dict[str, xr.Dataset]
    variants: dict[str, xr.Dataset]
    runs: dict[str, dict[float, xr.Dataset]]
    noise: dict[str, xr.Dataset]
    steady: xr.Dataset
    rigs: calibration.Rigs
    tracked: dict[str, xr.Dataset]
    """Sines on the bench by controller, and by lookup table without control."""
    stepped: dict[str, xr.Dataset]
    """Steps on the bench by controller."""
    stronger: dict[str, xr.Dataset]
    """Steps with a plate of twice the amplitude."""
    people: dict[str, xr.Dataset]
    """A population by controller."""
    felt: dict[str, dict[str, float]]
    """Perceptual indices by controller."""
    fluctuations: dict[str, dict[str, float]]
    """rms of the error at a constant set-point by controller and by what is taken away, N."""
    checked: gain_stability.Held
    """What a design asks of the re-tuned gains, and where they hold it."""
    beyond: beyond.Beyond
    """Control laws compared on fingers that none of them was tuned on, from the stored study."""
    arrivals: effect_arrivals.Arrivals
    """How much of effects arrives at such fingers, from the stored study."""

    def __init__(self, bar: Bar | None = None) -> None:
        self.systems: dict[str, System] = systems.compared()
        self._parts, self._bar = list(parts()), bar or silent()

    def watched(self) -> Watched:
        """Return a view that notes which fields are asked for."""
        return Watched(self)

    def __getattr__(self, field: str) -> Any:
        """Compute a field, told part by part to the bar."""
        if field.startswith("_"):
            raise AttributeError(field)
        return self._compute(field)

    def _compute(self, field: str) -> Any:
        own = [(name, work) for name, work in self._parts if name.partition(".")[0] == field]
        if not own:
            raise AttributeError(field)
        found: Any = {}
        for name, work in own:
            key = name.partition(".")[2]
            self._bar.doing(f"{FIELDS[field].words}{key and ', '}{key}")
            value = work()
            if key:
                found[key] = value
            else:
                found = value
            self._bar()
        setattr(self, field, found)
        return found


class Watched(Results):
    """Results that note which of their fields are asked for, so that a figure or a number can name its seeds."""

    def __init__(self, results: Results) -> None:
        self._results, self._asked = results, set[str]()

    def __getattr__(self, field: str) -> Any:
        """Note the field and return it."""
        if field.startswith("_"):
            raise AttributeError(field)
        self._asked.add(field)
        return getattr(self._results, field)

    def seeds(self) -> str:
        """Return the seeds of all that was asked for, in words."""
        found = [FIELDS[field].seeds for field in FIELDS if field in self._asked]
        return "; ".join(dict.fromkeys(found)) or "none"


def variants() -> dict[str, dict[str, float]]:
    """Return what the text leaves open beside the amplitudes, as overrides of ``feasible()``: noise and delay."""
    sigma = {name: reading.sigma_n(1e-5) for name, reading in sensor_noise.NOISE_READINGS.items() if name != "rms"}
    delays_s = {HALF: 1e-4, "one period of delay": 2e-4}
    return {f"noise as {name}": {sensor_noise.NOISE: value} for name, value in sigma.items()} | {
        name: {"controller.delay_s": value} for name, value in delays_s.items()
    }


def left_open() -> dict[str, System]:
    """Return the systems of ``variants``."""
    return {name: feasible().evolve(overrides) for name, overrides in variants().items()}


Part = tuple[str, Callable[[], Any]]


def parts() -> Iterator[Part]:
    """Yield (field of ``Results``, how to compute it) in order; a field with several parts names them after a dot."""
    compared = systems.compared()
    ends = {systems.WORKING: paper(), systems.FEASIBLE: feasible()}
    yield "population", systems.sliding_trials
    for name, system in ends.items():
        yield f"maps.{name}", partial(gains.fidelity_map, system)
    for name, system in compared.items():
        yield f"over_kp.{name}", partial(gains.fidelity_over, system, gains.KP)
        yield f"over_ki.{name}", partial(gains.fidelity_over, system, gains.KI, gains.KIS)
        yield f"runs.{name}", partial(systems.tracking_runs, system)
        yield f"noise.{name}", partial(sensor_noise.noise_sweep, system)
    for name, system in systems.in_both_units(left_open()).items():
        yield f"variants.{name}", partial(gains.fidelity_over, system, gains.KP)
    for name, system in systems.in_both_units(compared).items():
        if name not in compared:
            yield f"per_sample.{name}", partial(gains.fidelity_over, system, gains.KP)
    yield "steady", partial(sensor_noise.noise_gain, feasible())
    yield "rigs", calibration.all_rigs
    yield from bench_parts()
    yield "beyond", beyond.stored
    yield "arrivals", effect_arrivals.stored


def bench_parts() -> Iterator[Part]:
    """Yield the parts that run on the bench, in the same form."""
    finger = other_fingers.the_finger()
    system = paper_protocol.finger_system(finger)
    for name, overrides in paper_protocol.CONTROLLERS.items():
        yield f"tracked.{name}", partial(paper_protocol.tracking, system, overrides)
        yield f"stepped.{name}", partial(paper_protocol.stepping, system, overrides)
    for name in other_fingers.LOOKUPS[1:]:
        table = {**paper_protocol.CONTROLLERS[paper_protocol.OPEN], **other_fingers.lookup(name, finger)}
        yield f"tracked.{name}", partial(paper_protocol.tracking, system, table)
    for name in paper_protocol.CLOSED:
        overrides = paper_protocol.CONTROLLERS[name]
        yield f"felt.{name}", partial(other_fingers.felt, finger, overrides)
        taken = tuple(other_fingers.WITHOUT) if name == paper_protocol.RETUNED_GAINS else other_fingers.ENDS
        yield f"fluctuations.{name}", partial(other_fingers.fluctuations, finger, overrides, taken)
    for name in (paper_protocol.RETUNED_GAINS, paper_protocol.IDEAL):
        stronger = other_fingers.stronger(paper_protocol.CONTROLLERS[name])
        yield f"stronger.{name}", partial(paper_protocol.stepping, system, stronger)
    for name in (paper_protocol.OPEN, paper_protocol.PRINTED, paper_protocol.RETUNED_GAINS):
        yield f"people.{name}", partial(other_fingers.population, name)
    yield "checked", gain_stability.gains_hold
