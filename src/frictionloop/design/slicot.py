"""A, B, C, D of a sampled system, and what SLICOT makes of it: balanced states, an H-infinity controller.

SLICOT (the library ctrlsys of the extra ``design``), Benner et al., Applied and Computational Control, Signals, and
Circuits 1, 1999: routines SB10AD (formulas of Glover and Doyle 1988), AB13DD (norm) and AB09AD (balanced truncation).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from frictionloop.quantities import Array, Complex, FrictionloopError
from frictionloop.quantities.optional_libraries import needed

ABOVE_LEAST = 1.005
"""Norm asked for over the least one: at the least one the controller's gain grows for nothing (assumed)."""
STEP = 1e-3
"""Width, as a share of the first norm, at which the bisection for the least norm ends."""
BISECTION, ONE_NORM = 1, 4
"""Jobs of SB10AD."""


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


def balanced(system: Quadruple, order: int | None = None) -> tuple[Quadruple, Array]:
    """Return a stable system (in w or s) in balanced states, the last ones left out beyond ``order``.

    The norm of the error is at most twice the sum of the singular values left out (Glover 1984; Enns 1984).

    Returns
    -------
    tuple
        The system, and all Hankel singular values, falling.
    """
    A, B, C, D = system
    sizes, choose = (len(A), B.shape[1], len(C), order or 0), "A" if order is None else "F"
    with one_thread():
        a, b, c, singular, kept, _, info = slicot().ab09ad("C", "B", "N", choose, *sizes, *_copies(A, B, C), 0.0)
    if info:
        raise FrictionloopError(f"unstable: not balanced (SLICOT {info})")
    return Quadruple(a[:kept, :kept], b[:kept], c[:, :kept], D), singular


def synthesise(plant: Quadruple) -> tuple[Quadruple, float]:
    """Return the controller u = K y with nearly the least H-infinity norm of z from w, within 1 %, and that norm.

    Parameters
    ----------
    plant
        Sampled, inputs [w, u] and outputs [z, y], with a weight on the command u and a noise in the reading y.

    Raises
    ------
    FrictionloopError
        No controller keeps any norm, as far as SLICOT finds.
    """
    moved = bilinear(plant)
    if min(np.abs(moved.D[:-1, -1]).max(), np.abs(moved.D[-1, :-1]).max()) < 1e-12:
        raise FrictionloopError("H-infinity needs command weight and noise")
    # One thread: the matrices are small, and more of them take 2 to 30 times as long.
    with one_thread():
        _, first = _keeping(moved, ONE_NORM, 1e6)
        _, least = _keeping(moved, BISECTION, (1 + STEP) * first, STEP * first)
        controller, norm = _keeping(moved, ONE_NORM, ABOVE_LEAST * least)
    return bilinear(controller, back=True), norm


def _keeping(plant: Quadruple, job: int, norm: float, step: float = 0.0) -> tuple[Quadruple, float]:
    """Return what SB10AD finds for a plant in w, with the norm that its loop has.

    That norm is computed anew: close to the least one, SB10AD takes Riccati equations for solved that are not.
    """
    sizes = len(plant.A), plant.B.shape[1], len(plant.C), 1, 1
    *found, _, _, info = slicot().sb10ad(job, *sizes, *_copies(*plant), norm, step, 0.0)
    _check(info)
    A, B, C, D = _copies(*found[4:])
    loop = (len(A), B.shape[1], len(C), np.array([0.0, 1.0]), A, np.eye(len(A), order="F"), B, C, D)
    (peak, scale), _, info = slicot().ab13dd("C", "I", "N", "D", *loop, 1e-7)
    _check(info)
    n = len(plant.A)
    shapes = (n, n), (n, 1), (1, n), (1, 1)
    parts = (np.reshape(part, shape, order="F") for part, shape in zip(found[:4], shapes, strict=True))
    return Quadruple(*parts), float(peak / scale)


def _copies(*matrices: Array) -> list[Array]:
    """Return matrices as SLICOT takes them, which writes into what it is given."""
    return [np.array(each, order="F") for each in matrices]


def _check(info: int) -> None:
    if info:
        raise FrictionloopError(f"H-infinity does not converge (SLICOT {info})")


def slicot() -> Any:
    """Return SLICOT, which is imported where it is used."""
    return needed("ctrlsys", "ctrlsys", "design")


def one_thread() -> Any:
    """Return what keeps linear algebra on one thread."""
    return needed("threadpoolctl", "threadpoolctl", "design").threadpool_limits(1)
