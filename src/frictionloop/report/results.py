"""Everything that figures and claims are made of, and what each is cited by: version, command and seeds."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from copy import copy
from functools import partial
from typing import Any, NamedTuple

from frictionloop.loop.progress import Bar, silent
from frictionloop.parameters import System, feasible, paper
from frictionloop.quantities.code_version import cited_version
from frictionloop.report import (
    control_law_study,
    effect_arrivals,
    gain_maps,
    gain_stability,
    other_fingers,
    paper_protocol,
    rig_characterisation,
    sensor_noise,
    system_comparison,
)


def command_of(name: str) -> str:
    """Return the command that makes a figure again."""
    return f"frictionloop reproduce --only {name}"


def cited(command: str, seeds: str) -> tuple[str, str, str]:
    """Return version, command and seeds in words; of a clone the version ends with the commit."""
    words = f"seeds {seeds}" if seeds not in ("none", "") else "no random numbers"
    return f"frictionloop {cited_version()}", command, words


HALF, DELAY = "half a period of delay", "controller.delay_s"
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
    """The data of the report: ``FIELDS``, each computed when it is first asked for, once.

    What `parts` makes of several parts is a dictionary by their names: those of ``systems``, or controllers.
    """

    def __init__(self, bar: Bar | None = None) -> None:
        self.systems: dict[str, System] = system_comparison.compared()
        self._bar, self._computed, self._asked = bar or silent(), dict[str, Any](), set[str]()

    def watched(self) -> Results:
        """Return a view that notes which fields are asked for of it."""
        view = copy(self)
        view._asked = set()
        return view

    def seeds(self) -> str:
        """Return the seeds of all that was asked for, in words."""
        found = [FIELDS[field].seeds for field in FIELDS if field in self._asked]
        return "; ".join(dict.fromkeys(found)) or "none"

    def computed(self) -> set[str]:
        """Return the names of the fields that are there."""
        return set(self._computed)

    def __getattr__(self, field: str) -> Any:
        """Return a field, computed if need be, told part by part to the bar."""
        if field not in FIELDS:
            raise AttributeError(field)
        self._asked.add(field)
        if field not in self._computed:
            self._computed[field] = self._compute(field)
        return self._computed[field]

    def _compute(self, field: str) -> Any:
        found = {}
        for name, work in parts():
            own, _, key = name.partition(".")
            if own == field:
                self._bar.doing(f"{FIELDS[field].words}{key and ', '}{key}")
                found[key] = work()
                self._bar()
        return found.get("", found)


def left_open() -> dict[str, System]:
    """Return ``feasible()`` with what the text leaves open beside the amplitudes: what noise and delay may be."""
    base, system = system_comparison.FEASIBLE, feasible()
    noises = {name: reading.sigma_n(1e-5) for name, reading in sensor_noise.NOISE_READINGS.items() if name != "rms"}
    found = {f"{base}, noise as {name}": {sensor_noise.NOISE: value} for name, value in noises.items()}
    found |= {f"{base}, {HALF}": {DELAY: 1e-4}, f"{base}, one period of delay": {DELAY: 2e-4}}
    return {name: system.evolve(overrides) for name, overrides in found.items()}


Part = tuple[str, Callable[[], Any]]


def parts() -> Iterator[Part]:
    """Yield (field of ``Results``, how to compute it) in order; a field with several parts names them after a dot."""
    compared = system_comparison.compared()
    ends = {system_comparison.WORKING: paper(), system_comparison.FEASIBLE: feasible()}
    yield "population", system_comparison.sliding_trials
    for name, system in ends.items():
        yield f"maps.{name}", partial(gain_maps.fidelity_map, system)
    for name, system in compared.items():
        yield f"over_kp.{name}", partial(gain_maps.fidelity_over, system, gain_maps.KP)
        yield f"over_ki.{name}", partial(gain_maps.fidelity_over, system, gain_maps.KI, gain_maps.KIS)
        yield f"runs.{name}", partial(system_comparison.tracking_runs, system)
        yield f"noise.{name}", partial(sensor_noise.noise_sweep, system)
    for name, system in system_comparison.in_both_units(left_open()).items():
        yield f"variants.{name}", partial(gain_maps.fidelity_over, system, gain_maps.KP)
    for name, system in system_comparison.in_both_units(compared).items():
        if name not in compared:
            yield f"per_sample.{name}", partial(gain_maps.fidelity_over, system, gain_maps.KP)
    yield "steady", partial(sensor_noise.noise_gain, feasible())
    yield "rigs", rig_characterisation.all_rigs
    yield from bench_parts()
    yield "beyond", control_law_study.stored
    yield "arrivals", effect_arrivals.stored


def bench_parts() -> Iterator[Part]:
    """Yield the parts that run on the bench, in the same form."""
    finger = other_fingers.the_finger()
    system = paper_protocol.finger_system(finger)
    for name, overrides in paper_protocol.CONTROLLERS.items():
        yield f"tracked.{name}", partial(paper_protocol.tracking, system, overrides)
        yield f"stepped.{name}", partial(paper_protocol.stepping, system, overrides)
    yield f"stepped.{paper_protocol.WITH_KP}", partial(paper_protocol.stepping, system, paper_protocol.PROPORTIONAL)
    for name in other_fingers.LOOKUPS[1:]:
        table = {**paper_protocol.CONTROLLERS[paper_protocol.OPEN], **other_fingers.lookup(name, finger)}
        yield f"tracked.{name}", partial(paper_protocol.tracking, system, table)
    for name in (paper_protocol.PRINTED, paper_protocol.RETUNED_GAINS, paper_protocol.IDEAL):
        overrides = paper_protocol.CONTROLLERS[name]
        yield f"felt.{name}", partial(other_fingers.felt, finger, overrides)
        yield f"fluctuations.{name}", partial(other_fingers.fluctuations, finger, overrides)
    for name in (paper_protocol.RETUNED_GAINS, paper_protocol.IDEAL):
        stronger = other_fingers.stronger(paper_protocol.CONTROLLERS[name])
        yield f"stronger.{name}", partial(paper_protocol.stepping, system, stronger)
    for name in (paper_protocol.OPEN, paper_protocol.PRINTED, paper_protocol.RETUNED_GAINS):
        yield f"people.{name}", partial(other_fingers.population, name)
    yield "checked", gain_stability.gains_hold
