"""Equation (2) over frequency: exact for the sampled loop, and as continuous-time readings of the printed text."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from frictionloop.design.elements import Elements
from frictionloop.design.sampled import SampledPlant
from frictionloop.design.state_space import Array, Complex
from frictionloop.parameters import Controller
from frictionloop.quantities import FrictionloopError

Reading = Literal["sampled", "held", "lag", "printed"]
"""How time is treated: "sampled", exact at the sampling instants; the others read equation (2) in continuous time
with G(s) times "held" exp(-s delay) (1 - exp(-s Ts)) / (s Ts), "lag" exp(-s (delay + Ts/2)), or "printed" 1."""

LONG_NAMES = {
    "G": "loop gain G = C P S",
    "S": "sensitivity 1/(1 + G)",
    "T": "complementary sensitivity G/(1 + G)",
    "f_a_from_f_r": "friction force from set-point",
    "f_a_from_d": "friction force from disturbance",
    "f_a_from_n": "friction force from sensor noise",
    "u_from_f_r": "force command from set-point",
    "u_from_n": "force command from sensor noise",
}
"""The responses by name; S is the sensitivity here, not the sensor."""


def checked_frequency(frequency_hz: Array, nyquist_hz: float) -> Array:
    """Return the frequencies (Hz), refusing those not above 0 or above the Nyquist frequency."""
    inside = (frequency_hz > 0) & (frequency_hz <= nyquist_hz * (1 + 1e-12))
    if not np.all(inside):
        worst = frequency_hz[~inside].flat[0]
        raise FrictionloopError(f"frequency_hz = {worst:g} Hz: must be above 0 and at most {nyquist_hz:g}")
    return frequency_hz


def checked_reading(reading: str) -> None:
    """Refuse a reading that is not one of `Reading`."""
    if reading not in get_args(Reading):
        raise FrictionloopError(f"reading = {reading!r}: accepted are {', '.join(map(repr, get_args(Reading)))}")


def sampled_responses(plant: SampledPlant, controller: Controller, frequency_hz: Array) -> dict[str, Complex]:
    """Return the responses of `LONG_NAMES` from samples to samples, z = exp(j 2 pi f Ts).

    C(z) = kp + ki Ts / (z - 1); G = C (f_m from u); the disturbance passes the sensor between the samples too, so
    f_a_from_d is not quite S, nor f_a_from_n quite -T.
    """
    response = plant.response(frequency_hz)
    (f_a_u, f_a_d, f_a_n), (f_m_u, f_m_d, f_m_n) = response[:, 0].T, response[:, 1].T
    C = controller.kp + controller.ki * plant.period_s / np.expm1(2j * np.pi * frequency_hz * plant.period_s)
    G = C * f_m_u
    S = 1 / (1 + G)
    return {
        "G": G,
        "S": S,
        "T": G * S,
        "f_a_from_f_r": f_a_u * C * S,
        "f_a_from_d": f_a_d - f_a_u * C * f_m_d * S,
        "f_a_from_n": f_a_n - f_a_u * C * f_m_n * S,
        "u_from_f_r": C * S,
        "u_from_n": -C * f_m_n * S,
    }


def continuous_responses(loop: Elements, period_s: float, frequency_hz: Array, reading: Reading) -> dict[str, Complex]:
    """Return the responses of `LONG_NAMES` at s = j 2 pi f, equation (2), with sampling as ``reading`` says."""
    controller, plate, sensor = (block.response(frequency_hz) for block in (loop.controller, loop.plate, loop.sensor))
    electronics = loop.stages[-1].response(frequency_hz)
    C = controller * _hold(np.asarray(2j * np.pi * frequency_hz), period_s, loop.controller.delay_s, reading)
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
    }


def _hold(s: Complex, period_s: float, delay_s: float, reading: Reading) -> Complex:
    """Return what sampling adds to C(s), which has the delay in it already."""
    if reading == "held":
        return np.asarray(-np.expm1(-s * period_s) / (s * period_s))
    return np.asarray(np.exp(-s * period_s / 2) if reading == "lag" else np.exp(s * delay_s))
