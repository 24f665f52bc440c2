"""Plate and sensor as the sampled controller sees them: exact at the sampling instants, for any delay."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import expm

from frictionloop.analysis.loop_elements import Elements
from frictionloop.analysis.state_space import StateSpace
from frictionloop.quantities import Array, Complex, FrictionloopError, Lti

INPUTS = ("u", "d", "n")
OUTPUTS = ("f_a", "f_m")
LONGEST_DELAY = 1000
"""Most periods of delay that fit into a state space, which keeps one state for each."""


@dataclass(frozen=True, eq=False)
class SampledPlant:
    """x[k+1] = transition x[k] + old u[k-m-1] + new u[k-m] + drive [d, n][k], [f_a, f_m] = output x + through [d, n].

    The force command u is held, and applied ``delay_s`` = (m + rest) Ts after its sample; the disturbance d is
    linear between samples; the noise n is held over its period.
    """

    transition: Array
    old: Array
    new: Array
    drive: Array
    output: Array
    through: Array
    whole_periods: int
    period_s: float

    @property
    def delay_states(self) -> int:
        """Return how many commands are under way at once, each a state of `state_space`."""
        return self.whole_periods + bool(np.any(self.old))

    def response(self, frequency_hz: ArrayLike) -> Complex:
        """Return [f_a, f_m] from [u, d, n] at z = exp(j 2 pi f Ts), shape (frequencies, 2, 3), f in Hz."""
        z = np.exp(2j * np.pi * self.period_s * np.atleast_1d(np.asarray(frequency_hz, dtype=float)))
        command = (self.new + self.old / z[:, None]) * z[:, None] ** -self.whole_periods
        rest = np.broadcast_to(self.drive, (z.size, *self.drive.shape))
        driven = np.concatenate([command[:, :, None], rest], axis=2)
        inner = z[:, None, None] * np.eye(len(self.transition)) - self.transition
        through = np.hstack([np.zeros((len(OUTPUTS), 1)), self.through])
        return np.asarray(self.output @ np.linalg.solve(inner, driven) + through)

    def numerators(self) -> tuple[Array, Array]:
        """Return the numerators of f_a and f_m from u, coefficients of 1, z^-1, ..., the delay among them.

        They stand over one denominator, the characteristic polynomial of ``transition``.
        """
        rows = []
        for output in self.output:
            new, old = (_numerator(self.transition, b, output) for b in (self.new, self.old))
            # An entry of old, if there is any, came a period before.
            rows.append(np.concatenate([np.zeros(self.whole_periods), np.append(new, 0.0) + np.append(0.0, old)]))
        return rows[0], rows[1]

    def state_space(self) -> StateSpace:
        """Return the plant with the commands under way, u[k-1], u[k-2], ..., as further states."""
        late = self.delay_states
        if late > LONGEST_DELAY:
            raise FrictionloopError(
                f"controller.delay_s = {late * self.period_s:g} s: {late} periods, at most {LONGEST_DELAY}"
            )
        size = len(self.transition)
        # Column 0 is u[k], column i is u[k-i].
        commands = np.zeros((size, late + 1))
        commands[:, self.whole_periods] = self.new
        if np.any(self.old):
            commands[:, self.whole_periods + 1] = self.old
        chain = np.eye(late, late + 1)
        transition = np.block([[self.transition, commands[:, 1:]], [np.zeros((late, size)), chain[:, 1:]]])
        drive = np.block([[commands[:, :1], self.drive], [chain[:, :1], np.zeros((late, 2))]])
        output = np.hstack([self.output, np.zeros((len(OUTPUTS), late))])
        through = np.hstack([np.zeros((len(OUTPUTS), 1)), self.through])
        return StateSpace(transition, drive, output, through, self.period_s, INPUTS, OUTPUTS)


def sample(loop: Elements, period_s: float) -> SampledPlant:
    """Return plate and sensor of ``loop`` at the sampling instants, exactly (matrix exponentials).

    The disturbance's first-order hold would need d[k+1] at t_k; the usual change of state x[k] - ramp d[k] removes
    it (Franklin, Powell, Workman, Digital Control of Dynamic Systems, ch. 6: triangle-hold equivalent).
    """
    matrix, drive, output = _continuous(loop, period_s)
    delay_s = loop.delay_s
    whole = math.floor(delay_s / period_s + 1e-9)  # as the simulator rounds: a whole delay stays whole
    rest = delay_s / period_s - whole
    rest = rest if rest > 1e-9 else 0.0
    transition, held, ramp = _hold(matrix, drive, 1.0)
    onwards, late, early = transition, held, np.zeros_like(held)
    if rest:
        onwards, late, _ = _hold(matrix, drive, 1.0 - rest)
        _, early, _ = _hold(matrix, drive, rest)
    u, d, n = range(3)
    linear = transition @ ramp[:, d] + held[:, d] - ramp[:, d]
    return SampledPlant(
        transition=transition,
        old=onwards @ early[:, u],
        new=late[:, u],
        drive=np.column_stack([linear, held[:, n]]),
        output=output,
        through=np.column_stack([output @ ramp[:, d] + np.array([1.0, 0.0]), np.zeros(2)]),
        whole_periods=whole,
        period_s=period_s,
    )


def _continuous(loop: Elements, period_s: float) -> tuple[Array, Array, Array]:
    """Return A, B, C of dx/dt = A x + B [u, d, n], [f_a - d, f_m] = C x, t in periods: each block drives the next.

    u enters the plate, d the first stage of the sensor, n its last.
    """
    blocks = [_block(block, period_s) for block in (loop.plate, *loop.stages)]
    ends = np.cumsum([0, *(len(a) for a, _, _ in blocks)])
    matrix, drive, output = np.zeros((ends[-1], ends[-1])), np.zeros((ends[-1], 3)), np.zeros((2, ends[-1]))
    for k, (a, b, c) in enumerate(blocks):
        here = slice(ends[k], ends[k + 1])
        matrix[here, here] = a
        if k > 0:
            matrix[here, ends[k - 1] : ends[k]] = b @ blocks[k - 1][2]
        drive[here] = b * [k == 0, k == 1, k == len(blocks) - 1]
        output[:, here] = c * np.array([[k == 0], [k == len(blocks) - 1]])
    return matrix, drive, output


def _block(lti: Lti, period_s: float) -> tuple[Array, Array, Array]:
    """Return A, B, C of a strictly proper block, time in periods and states the size of its output.

    Companion matrices in seconds mix sizes as far apart as powers of 2 pi 1000, which costs digits later.
    """
    num, den = (np.asarray(p) / period_s ** np.arange(len(p))[::-1] for p in (lti.num, lti.den))
    matrix, drive, output = _companion(num, den)
    size = np.max(np.abs(output))
    return matrix, drive * size, output / size


def _companion(num: Array, den: Array) -> tuple[Array, Array, Array]:
    """Return A, b, c of num(s) / den(s), a strictly proper fraction, in controller canonical form."""
    order = den.size - 1
    late = np.concatenate([np.zeros(order + 1 - num.size), num]) / den[0]
    matrix = np.vstack([-den[1:] / den[0], np.eye(order - 1, order)])
    return matrix, np.eye(order, 1), (late[1:] - late[0] * den[1:] / den[0])[None]


def _numerator(matrix: Array, drive: Array, output: Array) -> Array:
    """Return the numerator of c (z - A)^-1 b, highest power first: det(z - A + b c) - det(z - A)."""
    return np.asarray(np.poly(matrix - np.outer(drive, output)) - np.poly(matrix))


def _hold(matrix: Array, drive: Array, span: float) -> tuple[Array, Array, Array]:
    """Return exp(A T), the response to inputs held for T periods, and to inputs rising from 0 to 1 over T."""
    size, inputs = drive.shape
    padded = np.zeros((size + 2 * inputs, size + 2 * inputs))
    padded[:size, :size] = matrix * span
    padded[:size, size : size + inputs] = drive * span
    padded[size : size + inputs, size + inputs :] = np.eye(inputs)
    stepped = expm(padded)[:size]
    return stepped[:, :size], stepped[:, size : size + inputs], stepped[:, size + inputs :]
