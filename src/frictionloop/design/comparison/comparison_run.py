"""The comparison: every entrant under every condition, and plain strokes of the same fingers, kept cell by cell."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import numpy as np
import xarray as xr

from frictionloop.analysis.operating_point import law_at
from frictionloop.design.comparison import trial_protocol
from frictionloop.design.comparison.comparison_store import Cell, Store, check_new
from frictionloop.design.comparison.trial_protocol import DESIGN_S, DESIGNED, Condition, Entrant, Overrides, entrants
from frictionloop.loop.parallel_runs import worker_count
from frictionloop.loop.progress import progress_bar
from frictionloop.loop.record import provenance
from frictionloop.loop.registered_blocks import outside_digest
from frictionloop.loop.sweep import sweep
from frictionloop.loop.sweep_checkpoint import CLOCK, Timely, computing
from frictionloop.loop.sweep_points import fingerprint, points_of, structures_of
from frictionloop.parameters import Constant, FingerFriction, System
from frictionloop.physics.fingers import Fingers
from frictionloop.physics.friction import is_gaussian
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.class_help import Brief

CORRECTIONS = 2
Sweep = Callable[[System, Fingers, Sequence[str]], xr.Dataset]
"""Runs a population on a system for some metrics, dim ``finger`` alone."""


def plain_strokes(system: System, people: Fingers, level_n: float, occluded: float, run: Sweep) -> xr.Dataset:
    """Return ``perceptual_index``, ``mean_force`` and ``scored_periods`` of plain strokes over ``finger``.

    Each slides at the constant amplitude that gives the level on average, commanded through the open loop, u = f_r =
    f0 e^(-tau a^2) of the controller's model. From the mean of one sweep the next amplitude follows; the third sweep is
    the result. Its residual is f_a less its own mean: a constant disturbance takes the set-point's place. A finger that
    no amplitude brings to the level slides at the nearest.

    Parameters
    ----------
    system
        The bench at one speed, with one contact.
    people
        Fingers as overrides.
    level_n
        Mean force wanted, N.
    occluded
        Occlusion in the middle of a run, 0 to 1, for the first guess.
    run
        What sweeps.
    """
    model = system.controller.model
    most = min(system.plate.max_amplitude_um, model.max_amplitude_um) ** 2
    bench = system.evolve({"controller.kind": "lookup", "setpoint": Constant(), "disturbance": Constant()})
    laws = [law_at(bench.evolve(each), occluded) for each in people]
    tau = np.array([law.susceptibility_per_um2 for law in laws if is_gaussian(law)])
    if tau.size < len(laws):
        raise must_be("friction.kind", system.friction.kind, '"finger"')
    square = np.clip(np.log([law.nominal_n / level_n for law in laws]) / tau, 0.0, most)
    mean = np.zeros(len(people))
    for _ in range(CORRECTIONS):
        mean = run(bench, _commanded(people, model, square, np.zeros(len(people))), ["mean_force"])["mean_force"].values
        # A finger that is never scored has no mean; it keeps its amplitude.
        better = np.clip(square + np.nan_to_num(np.log(mean / level_n)) / tau, 0.0, most)
        mean = mean * np.exp(tau * (square - better))
        square = better
    found = run(bench, _commanded(people, model, square, mean), ["perceptual_index", "mean_force", "scored_periods"])
    return found.assign(mean_force=found["mean_force"] - _offsets(model, square, mean))


def _commanded(people: Fingers, model: Any, square: np.ndarray, mean: np.ndarray) -> Fingers:
    """Return the fingers under amplitudes sqrt(square) in um, the residual counted from ``mean`` in N, 0 is off."""
    command = _command(model, square)
    offsets = np.nan_to_num(_offsets(model, square, mean))
    signals = zip(people, command.tolist(), offsets.tolist(), strict=True)
    return Fingers({**each, "setpoint.offset_n": u, "disturbance.offset_n": d} for each, u, d in signals)


def _command(model: Any, square: np.ndarray) -> np.ndarray:
    return np.asarray(model.nominal_n * np.exp(-model.susceptibility_per_um2 * square))


def _offsets(model: Any, square: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Return d with f_a + d - f_r = f_a - mean; none where no mean is given."""
    return np.where(mean > 0.0, _command(model, square) - mean, 0.0)


def occluded_at(system: System, time_s: float) -> float:
    """Return w = 1 - e^(-t/T), how far occlusion has come so long after landing; 0 where nothing is occluded."""
    friction = system.friction
    return -math.expm1(-time_s / friction.occlusion_s) if isinstance(friction, FingerFriction) else 0.0


CELL_S, RUN_S, MARGINS_S = 0.1, 3e-4, 0.4
"""Time of a cell, of a second of a finger in it, and of a law's margins at one place, in s (measured once)."""
PLAIN = "plain"
"""Name in the file of the strokes without control that the perceptual index is compared with."""


class ComparisonInterrupted(KeyboardInterrupt, metaclass=Brief):
    """Ctrl-C during a comparison; ``done`` of ``total`` cells are kept if it has a file."""

    def __init__(self, done: int, total: int) -> None:
        super().__init__("comparison interrupted")
        self.done, self.total = done, total


@dataclass(frozen=True, eq=False)
class LawRuns:
    """What was run, before it is scored (`comparison.scores`)."""

    system: System
    """The bench."""
    laws: Mapping[str, Overrides]
    """Entrants and their parameters on it."""
    people: Fingers
    seed: int
    speeds_mm_s: tuple[float, ...]
    duration_s: float
    start_s: float
    cells: xr.Dataset
    """Metrics of the kernel over law, speed, contact, task and finger; law ``plain`` is sliding without control."""
    left_out: Mapping[str, str] = field(default_factory=dict)
    """Why a law does not compete that cannot run on this bench, where all were asked for."""

    @property
    def middle_s(self) -> float:
        """Middle of the scored part of a run."""
        return (self.start_s + self.duration_s) / 2.0


def run_laws(
    system: System,
    laws: Iterable[str] | Mapping[str, Entrant] | None = None,
    count: int = 1000,
    seed: int = trial_protocol.EVALUATION_SEED,
    speeds_mm_s: Sequence[float] = trial_protocol.SPEEDS_MM_S,
    *,
    path: str | os.PathLike[str] | None = None,
    resume: bool = False,
    n_jobs: int | None = None,
    progress: bool | None = None,
    duration_s: float = trial_protocol.DURATION_S,
    start_s: float = trial_protocol.START_S,
    clock: Callable[[], float] = CLOCK,
    begin: Callable[[int, float], Any] = lambda cells, about_s: None,
) -> LawRuns:
    """Run control laws through the protocol (`comparison.protocol`) on a population they were not tuned on.

    Parameters
    ----------
    system : System
        The bench: what the device is and how fast the controller runs. Its own law, set-point, finger and strokes are
        replaced.
    laws : iterable of str or mapping, optional
        Entrants by name; or entrants of one's own, from a bench to overrides, by name. All that can run on this bench
        if not given.
    count, seed : int
        The fingers, as of `fingers`; any seed but `trial_protocol.TUNING_SEED`.
    speeds_mm_s : sequence of float
        Speeds of the strokes.
    path : path, optional
        HDF5 file that keeps every cell that is done, also on Ctrl-C: saved every few seconds.
    resume : bool
        Go on with ``path``: cells that are there and decided by the same things are not run again.
    n_jobs, progress
        As for `sweep`.
    duration_s, start_s : float
        Duration of a run and the part of it that is not scored, in s.
    clock : callable
        Seconds, by which ``path`` is saved.
    begin : callable
        Called when all is checked with the number of cells that no file has, and the s that they and margins take.

    Raises
    ------
    FrictionloopError
        For an unknown law, the tuning seed, a speed or a time out of range, a system without a finger, a file that is
        there already, keeps something else or cannot be written, and for a law that is named but cannot run on this
        bench: all before any law is designed. For one that is named and whose synthesis fails: then.
    ComparisonInterrupted
        On Ctrl-C.
    """
    fields = entrants(laws)
    people = trial_protocol.population(system, count, seed)
    speeds = trial_protocol.speeds_of(system, speeds_mm_s)
    trial_protocol.check_times(duration_s, start_s)
    trial = _Trial(system, people, seed, duration_s, start_s, n_jobs)
    for at in _conditions(system, speeds):
        trial.check(at)
    attrs = provenance(system, fingers=count, seed=seed, duration_s=float(duration_s), start_s=float(start_s))
    store = Store(path, attrs)
    if resume:
        store.resume()
    else:
        check_new(path)
    wanted = _cells(system, fields, speeds)
    left_to_run = [name for name, at in wanted if (name, at) not in store.cells]
    margins_s = MARGINS_S * len(fields) * len(speeds) * len(trial_protocol.lengths_of(system))
    begin(len(left_to_run), margins_s + about_s(left_to_run, count * duration_s / worker_count(n_jobs)))
    # Some are designed here, which takes up to a minute: whatever can be refused has been.
    try:
        given, left_out = _laws(system, fields, store, spare=laws is None, progress=progress)
        wanted = _cells(system, given, speeds)
        digests = {(name, at): trial.digest(given.get(name), at) for name, at in wanted}
        left = [key for key in wanted if not store.has(*key, digests[key])]
        store.keep()
        save = Timely(store.keep, clock)
        with progress_bar("compare", len(left), progress) as bar:
            try:
                for name, at in left:
                    bar.doing(f"{name}, {at.speed_mm_s:g} mm/s, {at.slip_length_um:g} um, {at.task}")
                    store.cells[name, at] = Cell(trial.run(given.get(name), at), digests[name, at])
                    save()
                    bar()
            finally:
                store.keep()
    except KeyboardInterrupt:
        raise ComparisonInterrupted(sum(key in store.cells for key in wanted), len(wanted)) from None
    return LawRuns(system, given, people, seed, speeds, duration_s, start_s, store.dataset(), left_out)


def about_s(laws: Sequence[str], fingers_s: float) -> float:
    """Return how long cells of these laws take, in s, each of so many seconds of fingers."""
    return (CELL_S + RUN_S * fingers_s) * len(laws) + sum(DESIGN_S[law] for law in DESIGN_S if law in laws)


def _laws(
    system: System, fields: Mapping[str, Entrant], store: Store, spare: bool, progress: bool | None
) -> tuple[dict[str, Overrides], dict[str, str]]:
    """Return what each law is given, and why those are left out that cannot run here; unless spared they raise."""
    given: dict[str, Overrides] = {}
    left_out: dict[str, str] = {}
    with progress_bar("designing", len(fields), progress) as bar:
        for name in sorted(fields, key=lambda each: each in DESIGNED):
            bar.doing(name)
            find = partial(fields[name], system)
            try:
                given[name] = store.design(name, system, find) if fields[name] is DESIGNED.get(name) else dict(find())
                system.evolve(given[name])
            except FrictionloopError as error:
                if not spare:
                    raise
                given.pop(name, None)
                left_out[name] = str(error)
            bar()
    return {name: given[name] for name in fields if name in given}, left_out


def _cells(system: System, laws: Iterable[str], speeds: Iterable[float]) -> list[tuple[str, Condition]]:
    found = [(name, at) for at in _conditions(system, speeds) for name in (PLAIN, *laws)]
    return [(name, at) for name, at in found if name != PLAIN or at.task in trial_protocol.SINES]


def _conditions(system: System, speeds: Iterable[float]) -> list[Condition]:
    lengths = trial_protocol.lengths_of(system)
    return [Condition(v, z, task) for v in speeds for z in lengths for task in trial_protocol.TASKS]


@dataclass(frozen=True)
class _Trial:
    """What all cells share."""

    system: System
    people: Fingers
    seed: int
    duration_s: float
    start_s: float
    n_jobs: int | None

    def bench(self, law: Overrides | None, at: Condition) -> System:
        return self.system.evolve({**trial_protocol.overrides_of(at, self.duration_s), **(law or {})})

    def check(self, at: Condition) -> None:
        """Refuse a condition that no law could run under, without one."""
        one = points_of(self.people[:1], [trial_protocol.noise_seed(self.seed, at.task)])
        bench = self.bench({"controller.kind": "lookup"}, at)
        structures_of(bench, one, range(1), self.duration_s, self.start_s, trial_protocol.metrics_of(at.task))

    def digest(self, law: Overrides | None, at: Condition) -> str:
        points = points_of(self.people, [trial_protocol.noise_seed(self.seed, at.task)])
        # Plain strokes run under no law, whatever that of the bench is.
        bench = self.bench(law or {"controller.kind": "lookup"}, at)
        kept = [PLAIN] if law is None else trial_protocol.metrics_of(at.task)
        key = fingerprint(bench, points, self.duration_s, self.start_s, kept, outside_digest())
        return f"{key} {computing()}"

    def run(self, law: Overrides | None, at: Condition) -> dict[str, Any]:
        bench, swept = self.bench(law, at), partial(self.swept, at)
        if law is None:
            level_n = trial_protocol.LEVELS_N[trial_protocol.SINES.index(at.task)]
            occluded = occluded_at(bench, (self.start_s + self.duration_s) / 2.0)
            found = plain_strokes(bench, self.people, level_n, occluded, swept)
        else:
            found = swept(bench, self.people, trial_protocol.metrics_of(at.task))
        return {str(name): values.values for name, values in found.data_vars.items()}

    def swept(self, at: Condition, system: System, people: Fingers, metrics: Sequence[str]) -> xr.Dataset:
        seeds = [trial_protocol.noise_seed(self.seed, at.task)]
        options: dict[str, Any] = {"score_from_s": self.start_s, "n_jobs": self.n_jobs, "progress": False}
        return sweep(system, people, self.duration_s, seeds, metrics, **options).isel(seed=0, drop=True)
