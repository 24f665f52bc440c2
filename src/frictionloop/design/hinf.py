"""From a System to a controller of higher order: mixed-sensitivity H-infinity against the noise of friction.

Weights are identified, not chosen: the residual counts as the spectrum of friction noise and tremor (noise_model). What
is left to choose, how much performance, is the most that holds on every plant of a grid: each contact with each error
of the resonance.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from frictionloop.analysis.linear import condition_of, linearise
from frictionloop.analysis.sampled_plant import SampledPlant
from frictionloop.design.friction_noise import STATES, NoiseModel, identify_noise
from frictionloop.design.grid_corners import broken, corners
from frictionloop.design.operating_grid import OperatingGrid
from frictionloop.design.plant_set import Plants, lead, overdrive_decay, shifted
from frictionloop.design.requirements import NOT_HELD, Designed, Requirements, feedforward, unheld
from frictionloop.design.second_order_sections import Cascade, factorise
from frictionloop.design.slicot import Quadruple, balanced, bilinear, slicot, synthesise
from frictionloop.findings import Finding
from frictionloop.parameters import LowpassSensor, Skin, System
from frictionloop.parameters.controller import FILTERS
from frictionloop.quantities import Complex, FrictionloopError

MOST_STATES = 120
"""Most states of the generalised plant: a synthesis then takes 7 s of one thread (measured), a dozen times a search."""


@dataclass(frozen=True)
class Weights:
    """How much each signal of the generalised plant counts.

    The contact is believed so fast that little lead is spent on it, at any slip length. Chosen by a search on
    simulated fingers (studies/pages/beliefs.md).
    """

    performance: float = 680.0
    """Factor on the shaping filter: where the norm is 1, S lets through a residual of 1/performance N/rtHz."""
    floor: float = 0.444
    """Weight on S where there is no disturbance: where the norm is 1, its inverse is the largest |S|."""
    resonance: float = 8.6e-5
    """Share r by which the resonance may be off (complex, so far smaller than the real share that is held)."""
    split: float = 0.0077
    """How the weight of the resonance is shared: w_res times it, z_res over it."""
    effort: float = 0.296
    """Weight on K S: its inverse bounds the controller's gain where S is 1."""
    entry: float = 0.05
    """Size of w_in."""
    noise: float = 0.0149
    """Size of w_n."""
    integral_hz: float = 6.6
    """Corner wi / (2 pi) of the PI behind K."""
    resonance_bias: float = -0.07
    """Share by which the believed resonance lies off the bench's: below is harmless, above is not."""
    contact_faster: float = 3.0
    """Factor by which the believed pole of the contact lies above the bench's."""


def weighted_plant(plant: SampledPlant, shaping: Quadruple, weights: Weights) -> Quadruple:
    """Return the generalised plant, sampled, of a loop (u, d, n to f_a, f_m) under weights; the filter is in s.

    Inputs  w_res, w_in, w_d, w_n, u     Outputs  z_res, z_e, z_u, y
        w_res    force on the suspension that a resonance off its value brings about: loop closed by -delta z_res
        w_in     force command of another's making, before the integrator
        w_d      friction force of another's making, from all frequencies alike
        w_n      sensor noise
        z_res    2 r (f_m - f_a): what the springs do with a resonance off by r
        z_e      residual f_a, weighted as the disturbance's spectrum: a multiple of the shaping filter, plus a floor
        z_u      force command
    y = -f_m, and the synthesised K acts before 1 + wi Ts/(z - 1): kp = 1 and ki = wi of the PI behind it are then
    known beforehand, and no integrator has to come out of an optimisation.
    """
    space, half_s = plant.state_space(), plant.period_s / 2
    in_w = shaping._replace(A=shaping.A * half_s, B=shaping.B * half_s)  # Tustin's rule, s = (2/Ts) w
    weight = bilinear(balanced(in_w)[0], back=True)
    sizes = np.array([[weights.split, weights.entry, 1.0, weights.noise, 1.0]])
    x, i, e = (np.zeros((1, len(each))) for each in (space.A, [1.0], weight.A))  # nothing of a state
    u, d, f_a, f_m = space.B[:, :1], space.B[:, 1:2], space.C[:1], space.C[1:]
    # The disturbance passes to f_a at once; what pushes the suspension alone does not.
    a_w = np.array([[space.D[0, 1] - 1.0, 0.0, space.D[0, 1], 0.0, 0.0]]) * sizes
    m_w = np.array([[space.D[1, 1], 0.0, space.D[1, 1], 1.0, 0.0]]) * sizes
    x_w, command = np.hstack([d, u, d, 0 * d, u]) * sizes, np.array([[0.0, 1.0, 0.0, 0.0, 1.0]]) * sizes
    through, swing = weights.performance * weight.D + weights.floor, 2 * weights.resonance / weights.split
    A = np.block([[space.A, u, x.T @ e], [x, i + 1.0, e], [weight.B @ f_a, e.T, weight.A]])
    B = np.vstack([x_w, 2 * math.pi * weights.integral_hz * plant.period_s * command, weight.B @ a_w])
    C = np.block(
        [
            [swing * (f_m - f_a), i, e],
            [through * f_a, i, weights.performance * weight.C],
            [x, i + weights.effort, e],
            [-f_m, i, e],
        ]
    )
    return Quadruple(A, B, C, np.vstack([swing * (m_w - a_w), through * a_w, weights.effort * command, -m_w]))


def check_order(plant: SampledPlant, delay_s: float, shaping_states: int = STATES) -> None:
    """Refuse a delay, a state for each of its control periods, that takes the generalised plant above `MOST_STATES`."""
    late = plant.delay_states
    others = len(plant.transition) + 1 + shaping_states  # 1: the integrator
    if others + late > MOST_STATES:
        raise FrictionloopError(
            f"controller.delay_s = {delay_s:g} s: at most {(MOST_STATES - others) * plant.period_s:g} s"
        )


GAINS = (0.65, 2.0)
"""Factors on the loop gain at which it has to be stable with every error of the resonance.

A finger's is F tau/(u tau_model) behind the lookup; at 0.6 N it is 1.05 to 1.86 from the first to the last decile of
the capable among ``fingers(100, 3)`` on the bench.
"""
COMMAND_NOISE_N = 0.03
"""Largest rms of the command that sensor noise causes: beyond it the command strays into the clamp (assumed)."""
ORDER = 2 * FILTERS
"""Most states of the sections."""
PERFORMANCE = (10.0, 5000.0)
"""Range of `Weights.performance` in which the most that holds is looked for, 1/N."""
SEARCHES = 12
"""Halvings of that range's logarithm: to 0.2 %."""
TIGHTER = (1.0, 0.8, 0.6, 0.45, 0.3)
"""Shares of Ms - 1 that are tried where a synthesis does not see every corner."""


@dataclass(frozen=True, eq=False)
class Synthesised:
    """A synthesised controller."""

    cascade: Cascade
    """Sections and PI, as the law ``filtered_pi`` runs them."""
    order: int
    """States, the integrator included."""
    full_order: int
    """States before reduction."""
    performance: float
    """Of the weights, as found."""

    @property
    def overrides(self) -> dict[str, object]:
        """The controller as overrides for ``System.evolve``, with overdrive and feed-forward of the set-point."""
        return self.cascade.overrides | {"controller.feedforward": True, "controller.overdrive": True}


def design_hinf(system: System, noise: NoiseModel | None = None, wanted: Requirements | None = None) -> Synthesised:
    """Return the H-infinity controller with the most performance that holds over a grid of plants.

        min over K of the norm of [z_res, z_e, z_u] from [w_res, w_in, w_d, w_n]   (weighted_plant)

    Parameters
    ----------
    system
        The bench.
    noise
        Disturbance; None identifies it from plain strokes at the operating point.
    wanted
        What must hold, at the bench's own gain. None: `Requirements` as it is.

    Raises
    ------
    FrictionloopError
        Nothing holds, not even with the least performance: the line says what the limit is. A synthesis that does not
        converge, coefficients that Q31 cannot hold, or a delay of more control periods than it takes (`check_order`).
    """
    return _search(system, noise, (wanted or Requirements()).limits)


def synthesised(system: System, wanted: Requirements) -> Designed:
    """Return the controller of the least tightened limits that holds at every corner, not only on the grid."""
    forward, notes = feedforward(system)
    # Identifying the noise already takes seconds.
    slicot()
    check_order(linearise(system).plant, system.controller.delay_s)
    noise = identify_noise(system)
    first: FrictionloopError | None = None
    for share in TIGHTER:
        try:
            found = _search(system, noise, wanted.scaled(share))
        except FrictionloopError as error:
            first = first or error
            continue
        overrides = {**found.overrides, "controller.feedforward": forward}
        at = corners(system.evolve(overrides), wanted.grid())
        worst = broken(at)
        if worst is None:
            order = Finding("ORDER-REDUCED", value=found.order, limit=found.full_order)
            return Designed(overrides, (*notes, order), tuple(at))
        first = first or unheld("hinf", wanted, worst)
    assert first is not None
    raise first


def _search(system: System, noise: NoiseModel | None, limits: Mapping[float, float]) -> Synthesised:
    """Return the controller with the most performance that holds, by bisection."""
    believed = linearise(_believed(system, Weights())).plant
    check_order(believed, system.controller.delay_s, *((len(noise.shaping.A),) if noise else ()))
    shaping, decay = (noise or identify_noise(system)).shaping, overdrive_decay(system)
    ends = [linearise(each) for each in OperatingGrid(None).systems(system)]  # of the slip length of a skin
    cases = sorted(shifted(ends, limits), key=lambda case: abs(case[1]))  # the bench as described first
    plants = Plants.of([loop for loop, _, _ in cases], overdrive=True)

    def attempt(performance: float) -> Synthesised:
        now = Weights(performance=performance)
        try:
            K, _ = synthesise(weighted_plant(believed, shaping, now))
            small = _reduced(_lagged(K, decay), ORDER)
            cascade = factorise(small, 1.0, 2 * math.pi * now.integral_hz, believed.period_s)
        except FrictionloopError as error:  # an unstable controller or none: too much was asked
            periods = system.controller.delay_s * system.controller.rate_hz
            raise FrictionloopError(f"law hinf: none found, delay {periods:.3g} periods: {error}", NOT_HELD) from None
        check(cascade.response(plants.frequency_hz))
        return Synthesised(cascade, len(small.A) + 1, len(K.A) + 1, performance)

    def check(law: Complex) -> None:
        over = plants.peaks(law) / [limit for _, _, limit in cases]
        loop, off, limit = cases[int(np.argmax(over))]
        if not np.max(over) <= 1.0:
            raise FrictionloopError(
                f"law hinf: Ms {limit * np.max(over):.3g}, {limit:.3g} asked, resonance {off:+.0%}, "
                f"{condition_of(loop.system)}",
                NOT_HELD,
            )
        if not all(plants.stable(factor * law).all() for factor in GAINS):
            raise FrictionloopError(f"law hinf: unstable at {GAINS[0]:g} or {GAINS[1]:g} x gain", NOT_HELD)
        command_n = _command_noise_n(system, plants, law)
        if not command_n <= COMMAND_NOISE_N:
            raise FrictionloopError(
                f"law hinf: command noise {command_n:.3g} N, most {COMMAND_NOISE_N:g} N",
                NOT_HELD,
            )

    low, high = (math.log(p) for p in PERFORMANCE)
    best = attempt(PERFORMANCE[0])
    for _ in range(SEARCHES):
        middle = (low + high) / 2
        try:
            low, best = middle, attempt(math.exp(middle))
        except FrictionloopError:
            high = middle
    return best


def _command_noise_n(system: System, plants: Plants, law: Complex) -> float:
    """Return the rms of the command behind overdrive that sensor noise causes on the first of the plants, N."""
    sensor, f = system.sensor, plants.frequency_hz
    if isinstance(sensor, LowpassSensor):
        density = sensor.noise_rms_n / math.sqrt(plants.rate_hz / 2)
    else:
        density = math.hypot(sensor.noise_density_n_rthz, sensor.step_n / math.sqrt(6.0 * plants.rate_hz))
    command = law * lead(overdrive_decay(system), f, 1.0 / plants.rate_hz) / plants.returned(law)[0]
    return density * math.sqrt(float(np.trapezoid(np.abs(command) ** 2, f)))


def _believed(system: System, weights: Weights) -> System:
    """Return the bench as the synthesis is to see it."""
    changes: dict[str, float] = {}
    if not isinstance(system.sensor, LowpassSensor):
        changes["sensor.resonance_hz"] = system.sensor.resonance_hz * (1 + weights.resonance_bias)
    if isinstance(system.finger, Skin):
        changes["finger.slip_length_um"] = system.finger.slip_length_um / weights.contact_faster
    return system.evolve(changes)


def _lagged(controller: Quadruple, decay: float) -> Quadruple:
    """Return the controller in front of overdrive that does what one without it does: the lag 1/lead behind it."""
    (A, B, C, D), p, left = controller, np.array([[decay]]), 1.0 - decay
    behind = np.block([[A, np.zeros((len(A), 1))], [C, p]])
    return Quadruple(behind, np.vstack([B, D]), left * np.hstack([C, p]), left * D)


def _reduced(controller: Quadruple, order: int) -> Quadruple:
    """Return a stable controller with at most so many states, by balanced truncation in w."""
    if len(controller.A) <= order or np.abs(np.linalg.eigvals(controller.A)).max() >= 1:
        return controller
    return bilinear(balanced(bilinear(controller), order)[0], back=True)
