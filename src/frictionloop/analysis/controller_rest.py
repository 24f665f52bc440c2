"""Where a control law rests in the loop: its state, and the set-point that holds an operating point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numba.core.errors import NumbaError
from numpy.typing import ArrayLike

from frictionloop.analysis.loop_elements import Elements
from frictionloop.analysis.operating_point import mean_disturbance_n
from frictionloop.analysis.sampled_plant import SampledPlant
from frictionloop.control.law import Law
from frictionloop.control.laws import law_of
from frictionloop.control.lookup import lookup_table
from frictionloop.parameters import Model, Strokes, System
from frictionloop.quantities import Array, FrictionloopError, flat_tuples
from frictionloop.quantities.outside_errors import complaint
from frictionloop.sensing.measurement import Measurement

OPEN_N = 1e3
"""A clamp, +- N, that does not act: a law at its own does not show where it would go."""
INSIDE = 1e-3
"""Share of the clamp by which an operating point at its edge is looked at from inside."""
SETTLE_S, GAINS = 4.0, (1.0, 0.1)
"""How long the loop runs where the search fails, and the factors on the plant: less gain calms what rings."""
RESTS = 1e-10
"""A state rests that changes by less, over 1 + its value."""
LOOK_TICKS = 500
"""Ticks of that run between two looks at whether it is over."""
ROUNDS = 60
"""Steps of the search at most, each of which costs a run of the law per unknown."""
FINEST = dict.fromkeys(("ftol", "xtol", "gtol"), 1e-15)
"""Of the search: it ends where rounding does."""


@dataclass(frozen=True, eq=False)
class LawStep:
    """(x, f_r, f_m) -> (x', u) of a law under a finger that slides steadily."""

    law: Law
    gains: Any
    speed_m_s: float
    load_n: float
    period_s: float

    def __call__(self, point: Array) -> Array:
        """Return x' and u."""
        return self.run(point)[0]

    def run(self, point: Array) -> tuple[Array, bool]:
        """Return x' and u, and whether the law says that it is saturated."""
        measured = Measurement(float(point[-1]), 0.0, self.speed_m_s, self.load_n, 1.0)
        after, u, saturated = self.tick(point[:-2].tolist(), measured, float(point[-2]))
        return np.append(after, u), saturated

    def opened(self) -> LawStep:
        """Return the step with its clamp taken away."""
        return replace(self, gains=self.gains._replace(low=-OPEN_N, high=OPEN_N))

    def tick(self, state: Sequence[float], measured: Measurement, setpoint_n: float) -> tuple[list[float], float, bool]:
        """Return all states a tick later, u, and whether the law says that it is saturated."""
        before = flat_tuples.shaped(self.law.state, state)
        try:
            after, (u, saturated) = self.law.step(before, measured, setpoint_n, self.gains, self.period_s)
        except NumbaError as error:
            raise FrictionloopError(f"{self.law.kind}: {complaint(error)}") from None
        return [float(each) for each in flat_tuples.flat(after)], u, bool(saturated)


@dataclass(frozen=True, eq=False)
class Rest:
    """A law at rest."""

    kind: str
    step: LawStep
    point: Array
    """States, set-point and measured force."""


def sizes(values: Array) -> Array:
    """Return the scale on which numbers of a law vary: their own, at least 0.01 (forces are around 0.5 N)."""
    return np.maximum(np.abs(values), 1e-2)


def rest_of(system: System, loop: Elements, plant: SampledPlant) -> Rest:
    """Return where the law of a System rests at an operating point.

    The measured force is that of the operating point, u the command that the lookup turns into its amplitude; states
    and set-point follow from x' = x (Levenberg and Marquardt: what no equation holds stays where it starts). A law with
    integral action rests at f_r = f_m, the lookup at f_r = u. Where the search fails from the law's start the closed
    loop is run first.

    Raises
    ------
    FrictionloopError
        No rest is found, or the law is saturated at it.
    """
    controller, model = system.controller, system.controller.model
    law, motion = law_of(controller), system.motion
    start = np.array(flat_tuples.flat(law.start_for(controller)), dtype=float)
    speed, load = (1e-3 * motion.speed_mm_s, motion.load_n) if isinstance(motion, Strokes) else (0.0, 0.0)
    step = LawStep(law, law.gains_for(controller), speed, load, plant.period_s)
    wanted = _command_n(model, loop.amplitude_um)
    measured = loop.force_n + mean_disturbance_n(system)
    first = np.append(start, [measured, measured])
    what, saturated = f'controller.kind = "{controller.kind}"', False
    for begin in _beginnings(step, first, wanted, plant):
        point = _settled(step, begin, wanted)
        if point is None:
            continue
        saturated = step.run(point)[1]
        if not saturated:
            return Rest(controller.kind, step, point)
    if saturated:
        raise FrictionloopError(f"{what}: saturated at {loop.force_n:.3g} N, no linear analysis")
    raise FrictionloopError(f"{what}: no rest at {loop.force_n:.3g} N, no linear analysis")


def _beginnings(step: LawStep, first: Array, wanted: float, plant: SampledPlant) -> Any:
    """Yield points near which the rest may be: without a clamp from the start, then after a run of the loop."""
    opened = _settled(step.opened(), first, wanted)
    if opened is not None:
        yield opened
    yield first
    for gain in GAINS:
        yield _after_a_run(step, first, wanted, plant, gain)


def _settled(step: LawStep, begin: Array, wanted: float) -> Array | None:
    """Return the point with x' = x and u as wanted, the measured force kept; None where the search gets nowhere."""
    rows = np.append(sizes(begin[:-2]), 1.0)

    def left(unknown: Array) -> Array:
        return (step(np.append(unknown, begin[-1])) - np.append(unknown[:-1], wanted)) / rows

    def rests(unknown: Array, residual: Array) -> bool:
        return bool(np.all(np.abs(residual * rows) <= RESTS * (1.0 + np.abs(np.append(unknown[:-1], wanted)))))

    from scipy.optimize import least_squares  # what a PI does not need, and takes long to load

    at_first = left(begin[:-1])
    if not np.all(np.isfinite(at_first)):
        return None
    if rests(begin[:-1], at_first):  # as where a search without a clamp ended inside it
        return begin
    with np.errstate(over="ignore", invalid="ignore"):  # a trial that overflows is no nearer
        found = least_squares(
            left, begin[:-1], "2-point", method="lm", x_scale=sizes(begin[:-1]), max_nfev=ROUNDS * begin.size, **FINEST
        )
    return np.append(found.x, begin[-1]) if rests(found.x, found.fun) else None


def _after_a_run(step: LawStep, first: Array, wanted: float, plant: SampledPlant, gain: float) -> Array:
    """Return where the law is after a run against the linear plant, its gain times a factor; at rest it ends early."""
    space, point = plant.state_space(), first.copy()
    state, f_m, drive = np.zeros(len(space.A)), gain * space.C[1], space.B[:, 0]
    before = first[:-2].tolist()
    # Tens of thousands of ticks: the step is called on plain numbers, without what `run` does to arrays.
    for k in range(round(SETTLE_S / plant.period_s)):
        measured = Measurement(float(first[-1] + f_m @ state), 0.0, step.speed_m_s, step.load_n, 1.0)
        reached, u, _ = step.tick(before, measured, float(first[-2]))
        moved = space.A @ state + drive * (u - wanted)
        if not all(map(math.isfinite, (*reached, u))):
            return first
        settled = k % LOOK_TICKS == 0 and _rests(before, reached) and _rests(state, moved)
        before, state = reached, moved
        if settled:
            break
    point[:-2] = before
    point[-1] = first[-1]
    return point


def _rests(before: ArrayLike, after: ArrayLike) -> bool:
    """Tell whether a state changes by less than what counts as rest."""
    return bool(np.all(np.abs(np.subtract(after, before)) <= RESTS * (1.0 + np.abs(before))))


def _command_n(model: Model, amplitude_um: float) -> float:
    """Return the force command that the controller's lookup turns into an amplitude, off the edges of the clamp."""
    if model.table_size == 0:
        command = model.nominal_n * float(np.exp(-model.susceptibility_per_um2 * amplitude_um**2))
    else:
        forces = np.linspace(model.floor_n, model.nominal_n, model.table_size)
        command = float(np.interp(-(amplitude_um**2), -lookup_table(model), forces))
    edge = INSIDE * (model.nominal_n - model.floor_n)
    return float(np.clip(command, model.floor_n + edge, model.nominal_n - edge))
