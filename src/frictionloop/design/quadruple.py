"""A, B, C, D as a plain tuple, and what is done with it: to and from z, in series, balanced and truncated."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from threadpoolctl import threadpool_limits

from frictionloop.analysis.state_space import Array, Complex
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.quantities.extra import needed


class Quadruple(NamedTuple):
    """A, B, C, D of a linear system, shapes (n, n), (n, inputs), (outputs, n), (outputs, inputs)."""

    A: Array
    B: Array
    C: Array
    D: Array

    def at(self, z: ArrayLike) -> Complex:
        """Return C (z - A)^-1 B + D, shape (points, outputs, inputs), at complex numbers z (or s)."""
        points = np.atleast_1d(np.asarray(z, dtype=complex))
        inner = points[:, None, None] * np.eye(len(self.A)) - self.A
        return np.asarray(
            self.C @ np.linalg.solve(inner, np.broadcast_to(self.B, (points.size, *self.B.shape))) + self.D
        )


def bilinear(system: Quadruple, back: bool = False) -> Quadruple:
    """Return the system in w, z = (1 + w)/(1 - w), of a system in z; ``back`` is the other way.

    Stability and every norm over frequency stay. A pole at z = -1 (or w = 1) raises ``numpy.linalg.LinAlgError``.
    """
    A, B, C, D = system
    eye, sign = np.eye(len(A)), -1.0 if back else 1.0
    inner, root = np.linalg.inv(eye + sign * A), np.sqrt(2.0)
    moved = (eye + A) @ inner if back else (A - eye) @ inner
    return Quadruple(moved, root * inner @ B, root * C @ inner, D - sign * C @ inner @ B)


def series(blocks: Sequence[Quadruple]) -> Quadruple:
    """Return the systems one after the other, the first one driven first."""
    A, B, C, D = blocks[0]
    for a, b, c, d in blocks[1:]:
        A, B = np.block([[A, np.zeros((len(A), len(a)))], [b @ C, a]]), np.vstack([B, b @ D])
        C, D = np.hstack([d @ C, c]), d @ D
    return Quadruple(A, B, C, D)


def realised(filter_: Lti, period_s: float) -> Quadruple:
    """Return a stable filter without delay sampled by Tustin's rule, its states of equal size (balanced).

    Section after section, each in the time of its own poles: the companion form of the whole loses every digit when
    poles lie three decades apart.
    """
    from scipy.signal import tf2zpk, zpk2sos

    sections = zpk2sos(*tf2zpk(filter_.num, filter_.den), pairing="minimal", analog=True)
    blocks = [_section(row[:3], row[3:]) for row in sections]
    whole = series(blocks)
    # s = (2/Ts) w
    half = period_s / 2
    return bilinear(balanced(Quadruple(whole.A * half, whole.B * half, whole.C, whole.D))[0], back=True)


def _section(num: Array, den: Array) -> Quadruple:
    """Return one section in controllable form, of second order or, where the first coefficients are 0, of first."""
    if den[0] == 0:
        gain, rate, lead = num[2] / den[2], den[2] / den[1], num[1] / den[1]
        return Quadruple(*(np.array([[x]]) for x in (-rate, rate, gain - lead, lead)))
    rate = np.sqrt(abs(den[2] / den[0]))
    b, a = num / den[0] / rate ** np.arange(3), den / den[0] / rate ** np.arange(3)
    A, B = np.array([[0.0, rate], [-a[2] * rate, -a[1] * rate]]), np.array([[0.0], [rate]])
    return Quadruple(A, B, np.array([[b[2] - a[2] * b[0], b[1] - a[1] * b[0]]]), np.array([[b[0]]]))


def balanced(system: Quadruple, order: int | None = None) -> tuple[Quadruple, Array]:
    """Return a stable system (in w or s) in balanced states, the last ones left out beyond ``order``.

    SLICOT's AB09AD, the square-root method. The norm of the error is at most twice the sum of the singular values left
    out (Glover 1984; Enns 1984).

    Returns
    -------
    tuple
        The system, and all Hankel singular values, falling.
    """
    A, B, C, D = system
    sizes, choose = (len(A), B.shape[1], len(C), order or 0), "A" if order is None else "F"
    with threadpool_limits(1):
        a, b, c, singular, kept, _, info = slicot().ab09ad(
            "C", "B", "N", choose, *sizes, *map(np.asfortranarray, (A, B, C)), 0.0
        )
    if info:
        raise FrictionloopError(f"a system that is not stable cannot be balanced: SLICOT ends with {info}")
    return Quadruple(a[:kept, :kept], b[:kept], c[:, :kept], D), singular


def slicot() -> Any:
    """Return SLICOT, which is imported where it is used."""
    return needed("ctrlsys", "ctrlsys", "design")
