"""The loop for small signals, equation (2): its responses, at one operating point or over a band of them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal, get_args

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.loop_elements import Elements, elements
from frictionloop.analysis.margins import Margins, gain_factor, margins, search_grid, sensitivity_peak
from frictionloop.analysis.operating_point import force_band, reach_at
from frictionloop.analysis.sampled_plant import SampledPlant, sample
from frictionloop.analysis.state_space import StateSpace, close
from frictionloop.control.pi import is_pi, linearise_pi
from frictionloop.findings import Condition
from frictionloop.parameters import (
    FingerFriction,
    PiController,
    Skin,
    Strokes,
    SuspendedSensor,
    System,
    check_system,
)
from frictionloop.quantities import Array, Complex, FrictionloopError, must_be

Reading = Literal["sampled", "held", "lag", "printed"]
"""How time is treated: "sampled", exact at the sampling instants; the others read equation (2) in continuous time
with G(s) times "held" exp(-s delay) (1 - exp(-s Ts)) / (s Ts), "lag" exp(-s (delay + Ts/2)), or "printed" 1, for
PI only."""

LONG_NAMES = {
    "G": "loop gain G = C P S",
    "S": "sensitivity 1/(1 + G)",
    "T": "complementary sensitivity G/(1 + G)",
    "f_a_from_f_r": "friction force from set-point",
    "f_a_from_d": "friction force from disturbance",
    "f_a_from_n": "friction force from sensor noise",
    "u_from_f_r": "force command from set-point",
    "u_from_n": "force command from sensor noise",
    "f_a_from_q": "friction force from reading error",
    "u_from_q": "force command from reading error",
}
"""The responses by name; S is the sensitivity here, not the sensor."""


def sampled_responses(plant: SampledPlant, law: StateSpace, frequency_hz: Array) -> dict[str, Complex]:
    """Return the responses of `LONG_NAMES` from samples to samples, z = exp(j 2 pi f Ts).

    The law has two inputs: u = C_r f_r - C_y f_m, and c behind the overdrive likewise; PI has C_r = C_y. G = C_y
    (f_m from c). The disturbance passes the sensor between the samples too, so f_a_from_d is not quite S, nor
    f_a_from_n quite -T.
    """
    response, said = plant.response(frequency_hz), law.response(frequency_hz)
    (f_a_c, f_a_d, f_a_n), (f_m_c, f_m_d, f_m_n) = response[:, 0].T, response[:, 1].T
    (u_r, u_m), (c_r, c_m) = said[:, 0].T, said[:, 1].T
    G = -c_m * f_m_c
    S = 1 / (1 + G)
    return {
        "G": G,
        "S": S,
        "T": G * S,
        "f_a_from_f_r": f_a_c * c_r * S,
        "f_a_from_d": f_a_d + f_a_c * c_m * f_m_d * S,
        "f_a_from_n": f_a_n + f_a_c * c_m * f_m_n * S,
        "u_from_f_r": u_r + u_m * f_m_c * c_r * S,
        "u_from_n": u_m * f_m_n * S,
        "f_a_from_q": f_a_c * c_m * S,
        "u_from_q": u_m * S,
    }


def continuous_responses(loop: Elements, period_s: float, frequency_hz: Array, reading: Reading) -> dict[str, Complex]:
    """Return the responses of `LONG_NAMES` at s = j 2 pi f, equation (2), with sampling as ``reading`` says."""
    if loop.controller is None:
        raise FrictionloopError(f'reading = {reading!r}: needs controller.kind = "pi"')
    controller, plate, sensor = (block.response(frequency_hz) for block in (loop.controller, loop.plate, loop.sensor))
    electronics = loop.stages[-1].response(frequency_hz)
    C = controller * _hold(np.asarray(2j * np.pi * frequency_hz), period_s, loop.delay_s, reading)
    G = C * plate * sensor
    S = 1 / (1 + G)
    return {
        "G": G,
        "S": S,
        "T": G * S,
        "f_a_from_f_r": C * plate * S,
        "f_a_from_d": S,
        "f_a_from_n": -C * plate * electronics * S,
        "u_from_f_r": C * S,
        "u_from_n": -C * electronics * S,
        "f_a_from_q": -C * plate * S,
        "u_from_q": -C * S,
    }


def _hold(s: Complex, period_s: float, delay_s: float, reading: Reading) -> Complex:
    """Return what sampling adds to C(s), which has the delay in it already."""
    if reading == "held":
        return np.asarray(-np.expm1(-s * period_s) / (s * period_s))
    return np.asarray(np.exp(-s * period_s / 2) if reading == "lag" else np.exp(s * delay_s))


LOW = 1e-9
"""Share of the Nyquist frequency that counts as low: below every crossover of a loop with integral action."""


@dataclass(frozen=True, eq=False)
class LinearLoop:
    """The closed loop of a System for small signals around one operating point."""

    system: System
    """The loop it was made from."""
    elements: Elements
    """C(s), P(s), S(s) and the operating point."""
    plant: SampledPlant
    """Plate and sensor as the sampled controller sees them."""
    known_law: StateSpace | None = None
    """The law at this operating point where it is known already; None: it is found when it is asked for."""

    @property
    def nyquist_hz(self) -> float:
        """Half the control rate, the highest frequency of every response."""
        return self.system.controller.rate_hz / 2

    def frequency_response(self, frequency_hz: ArrayLike, reading: Reading = "sampled") -> xr.Dataset:
        """Return G, S = 1/(1+G), T = G/(1+G) and the three transfer functions of equation (2).

        f_a = d / (1 + G) + f_r C P / (1 + G) - n G / (1 + G)   (2)

        Parameters
        ----------
        frequency_hz
            Frequencies in Hz, shape (frequencies,), above 0 and up to half the control rate.
        reading
            "sampled" is the loop as it runs: zero-order hold, delay and law exact, d linear between samples, n
            held over its period, responses from samples to samples. "held", "lag" and "printed" are equation (2) in
            continuous time with the hold exact, as half a period of delay, and (delay too) left out; they are for PI.

        Returns
        -------
        xarray.Dataset
            Complex ``G``, ``S``, ``T``, ``f_a_from_f_r``, ``f_a_from_d``, ``f_a_from_n``, ``u_from_f_r``,
            ``u_from_n``, ``f_a_from_q`` and ``u_from_q`` (N/N) over ``frequency`` (Hz). Noise n enters before the
            electronics' pole, behind any springs; q is an error of the reading itself. G, S and T are those of the
            feedback: a law may treat the set-point otherwise.

        Raises
        ------
        FrictionloopError
            A frequency outside the range, an unknown reading or one for PI, or a law without a linear analysis.
        """
        frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
        variables = {
            name: ("frequency", value, {"units": "N/N", "long_name": LONG_NAMES[name]})
            for name, value in self.responses(frequency, reading).items()
        }
        coordinates = {"frequency": ("frequency", frequency, {"units": "Hz"})}
        about = {"reading": reading, "amplitude_um": self.elements.amplitude_um, "force_n": self.elements.force_n}
        return xr.Dataset(variables, coordinates, about)

    def responses(self, frequency_hz: ArrayLike, reading: Reading = "sampled") -> dict[str, Complex]:
        """Return the variables of `frequency_response` as plain arrays by name, for the same arguments."""
        if reading not in get_args(Reading):
            raise FrictionloopError(f"reading = {reading!r}: accepted are {', '.join(map(repr, get_args(Reading)))}")
        frequency = np.atleast_1d(np.asarray(frequency_hz, dtype=float))
        inside = (frequency > 0) & (frequency <= self.nyquist_hz * (1 + 1e-12))
        if not np.all(inside):
            raise must_be("frequency_hz", frequency[~inside].flat[0], f"above 0 and at most {self.nyquist_hz:g}", "Hz")
        if reading == "sampled":
            return sampled_responses(self.plant, self.law, frequency)
        return continuous_responses(self.elements, self.plant.period_s, frequency, reading)

    @cached_property
    def law(self) -> StateSpace:
        """The control law, inputs f_r, f_m, outputs u, c (`law_space`); raises where it has no linear analysis."""
        return self.known_law or law_space(self.system, self.elements, self.plant)

    @cached_property
    def _closed(self) -> StateSpace:
        return close(self.plant.state_space(), self.law)

    def state_space(self, inputs: tuple[str, ...] = ("f_r", "d", "n")) -> StateSpace:
        """Return the closed loop at the sampling instants, outputs f_a, f_m, u (all N).

        Parameters
        ----------
        inputs
            Which of set-point f_r, disturbance d, sensor noise n and error of the reading q go in, in this order.
        """
        return self._closed.driven_by(inputs)

    def poles(self) -> Complex:
        """Return the closed loop's poles in the z plane, shape (states,)."""
        return self._closed.poles()

    def is_stable(self) -> bool:
        """Return whether the sampled closed loop is stable."""
        return self._closed.is_stable()

    def margins(self) -> Margins:
        """Return how far the sampled loop is from instability (`Margins`)."""
        return margins(self._gain, self._margin_grid(), self.nyquist_hz, self.is_stable())

    def sensitivity_peak(self) -> float:
        """Return Ms alone, infinite if the loop is unstable: `margins` finds the same, and takes longer."""
        return sensitivity_peak(self._gain, self._margin_grid(), self.nyquist_hz) if self.is_stable() else math.inf

    def gain_factor(self, peak: float) -> float:
        """Return the factor on G up to which Ms stays within a peak, with every smaller one (`margins.gain_factor`)."""
        return gain_factor(self._gain, self._margin_grid(), self.nyquist_hz, peak)

    def _gain(self, frequency_hz: ArrayLike) -> Complex:
        return self.responses(frequency_hz)["G"]

    def _margin_grid(self) -> Array:
        # An integral's |G| f is constant at low frequencies, and no crossover lies lower than there.
        low_hz = LOW * self.nyquist_hz
        gain = float(np.abs(self._gain(low_hz)[0]))
        return self.search_grid(0.1 * low_hz * gain if gain > 1 else self.nyquist_hz)

    def search_grid(self, lowest_hz: float = math.inf) -> Array:
        """Return frequencies in Hz, from ``lowest_hz`` or lower to `nyquist_hz`, between which responses do little."""
        around = resonances([self])
        return search_grid(self.nyquist_hz, self.plant.whole_periods, min(lowest_hz, self.nyquist_hz), around)

    def with_gains(self, kp: float, ki: float) -> LinearLoop:
        """Return the same loop at the same operating point with other PI gains, kp in N/N and ki in 1/s."""
        check_pi(self.system)
        system = self.system.evolve({"controller.kp": kp, "controller.ki": ki})
        return LinearLoop(system, replace(self.elements, controller=linearise_pi(check_pi(system))), self.plant)


def resonances(loops: Sequence[LinearLoop]) -> list[tuple[float, float]]:
    """Return each resonance of the sensors of loops and half its width, Hz."""
    sensors = {loop.system.sensor for loop in loops}
    return [(s.resonance_hz, s.resonance_hz / (2.0 * s.q)) for s in sensors if isinstance(s, SuspendedSensor)]


def check_pi(system: System) -> PiController:
    """Return the controller of a System, refusing one that has no kp and ki."""
    controller = system.controller
    if not is_pi(controller):
        raise FrictionloopError(f'controller.kind = "{controller.kind}": must be "pi" here')
    return controller


def linearise(
    system: System, amplitude_um: float | None = None, *, force_n: float | None = None, occluded: float = 0.0
) -> LinearLoop:
    """Return the loop for small signals around an operating point, equation (2).

    Parameters
    ----------
    system
        The loop, with any control law. A finger that strokes is taken to slide steadily, at the strokes' speed and mean
        load; commands that come late by chance, lost ticks and pulses are left out. The law is linearised
        when it is asked for: one that has no linear analysis still has a plant.
    amplitude_um, force_n
        Operating point, as a vibration amplitude (um, 0 to a_max) or as a friction force g(a) (N, g(a_max) to f0);
        one or neither. Without either it is the mean of set-point less disturbance for a finger that strokes, and for
        the loop of Section 2, whose signals may be out of reach, the middle of the reachable forces.
    occluded
        How far occlusion under a `FingerFriction` has come: 0 just landed, 1 after long contact.

    Raises
    ------
    FrictionloopError
        Both are given, the point cannot be reached, the finger is too slow or too light for the controller to act or
        sticks at that speed, or a field that is not at its default is not in the linear analysis (`LINEAR`).
    """
    loop = elements(system, amplitude_um, force_n, occluded)
    return LinearLoop(system, loop, sample(loop, 1.0 / system.controller.rate_hz))


def condition_of(system: System) -> Condition:
    """Return at which slip length, speed and load a loop is linearised."""
    finger, motion = system.finger, system.motion
    found = Condition(slip_length_um=finger.slip_length_um if isinstance(finger, Skin) else None)
    return replace(found, speed_mm_s=motion.speed_mm_s, load_n=motion.load_n) if isinstance(motion, Strokes) else found


def operating_band(
    system: System, forces_n: Sequence[float] | None = None, occluded: Sequence[float] = (0.0,)
) -> list[LinearLoop]:
    """Return the loop at every force of a band, for every state of the finger.

    Parameters
    ----------
    system
        The loop.
    forces_n
        Friction forces g(a), N; by default the lowest, the mean and the highest of set-point less disturbance. One out
        of reach counts as the nearest that can be reached, where the loop then stays.
    occluded
        States of occlusion, 0 (just landed, where ``friction.nominal_n`` holds) to 1 (after long contact); without a
        `FingerFriction` they are all alike.

    Raises
    ------
    FrictionloopError
        No force or no state, or one that is not a number or out of range.
    """
    check_system(system)
    forces = np.asarray(force_band(system) if forces_n is None else forces_n, dtype=float)
    states = tuple(occluded) if isinstance(system.friction, FingerFriction) else (0.0,)
    if not (forces.size and states and np.all(np.isfinite(forces))):
        raise FrictionloopError(f"forces_n = {forces.tolist()} N, occluded = {list(states)}: needs numbers")
    points = {(float(force), w) for w in states for force in reach_at(system, w).nearest(forces)}
    return [linearise(system, force_n=force, occluded=w) for force, w in sorted(points)]
