"""Equation (2) over frequency: exact for any sampled law, for PI also as continuous-time readings of the text."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np

from frictionloop.analysis.elements import Elements
from frictionloop.analysis.sampled import SampledPlant
from frictionloop.analysis.state_space import Array, Complex, StateSpace
from frictionloop.quantities import FrictionloopError, must_be

Reading = Literal["sampled", "held", "lag", "printed"]
"""How time is treated: "sampled", exact at the sampling instants; the others read equation (2) in continuous time
with G(s) times "held" exp(-s delay) (1 - exp(-s Ts)) / (s Ts), "lag" exp(-s (delay + Ts/2)), or "printed" 1, for
PI only."""

LONG_NAMES = {
    "G": "loop gain G = C P S, C from measured force to command",
    "S": "sensitivity 1/(1 + G)",
    "T": "complementary sensitivity G/(1 + G)",
    "f_a_from_f_r": "friction force from set-point",
    "f_a_from_d": "friction force from disturbance",
    "f_a_from_n": "friction force from sensor noise",
    "u_from_f_r": "force command from set-point",
    "u_from_n": "force command from sensor noise",
    "f_a_from_q": "friction force from an error of the reading",
    "u_from_q": "force command from an error of the reading",
}
"""The responses by name; S is the sensitivity here, not the sensor."""


def checked_frequency(frequency_hz: Array, nyquist_hz: float) -> Array:
    """Return the frequencies (Hz), refusing those not above 0 or above the Nyquist frequency."""
    inside = (frequency_hz > 0) & (frequency_hz <= nyquist_hz * (1 + 1e-12))
    if not np.all(inside):
        worst = frequency_hz[~inside].flat[0]
        raise must_be("frequency_hz", worst, f"above 0 and at most {nyquist_hz:g}", "Hz")
    return frequency_hz


def checked_reading(reading: str) -> None:
    """Refuse a reading that is not one of `Reading`."""
    if reading not in get_args(Reading):
        raise FrictionloopError(f"reading = {reading!r}: accepted are {', '.join(map(repr, get_args(Reading)))}")


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
        raise FrictionloopError(f'reading = {reading!r}: is for controller.kind = "pi"; other laws have "sampled"')
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
