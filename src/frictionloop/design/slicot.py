"""H-infinity and LQG controllers of a sampled plant, by SLICOT (the library ctrlsys of the extra ``design``).

SLICOT, Benner et al., Applied and Computational Control, Signals, and Circuits 1, 1999: routines SB10AD (formulas of
Glover and Doyle 1988), AB13DD (norm) and SB10ED (H2 in discrete time).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from threadpoolctl import threadpool_limits

from frictionloop.design.quadruple import Quadruple, bilinear, slicot
from frictionloop.quantities import FrictionloopError

ABOVE_LEAST = 1.005
"""Norm asked for over the least one: at the least one the controller's gain grows for nothing (assumed)."""
STEP = 1e-3
"""Width, as a share of the LQG controller's norm, at which the bisection for the least norm ends."""
BISECTION, ONE_NORM = 1, 4
"""Jobs of SB10AD."""


@dataclass(frozen=True, eq=False)
class Generalised:
    """A plant with inputs [w, u] and outputs [z, y]: the controller u = K y is to make z from w small."""

    system: Quadruple
    controls: int = 1
    """How many of the last inputs are u."""
    measurements: int = 1
    """How many of the last outputs are y."""

    @property
    def sizes(self) -> tuple[int, int, int, int, int]:
        """States, inputs, outputs, and how many of these are u and y."""
        return len(self.system.A), self.system.B.shape[1], len(self.system.C), self.controls, self.measurements


class Synthesis(NamedTuple):
    """A controller u = K y, and the norm it keeps."""

    controller: Quadruple
    gamma: float
    """Norm of z from w in the closed loop."""


def synthesise(plant: Generalised) -> Synthesis:
    """Return the sampled controller with nearly the least H-infinity norm of z from w, within 1 %.

    Parameters
    ----------
    plant
        Sampled, with a weight on every command and a noise in every reading.

    Raises
    ------
    FrictionloopError
        No controller keeps any norm, as far as SLICOT finds.
    """
    moved = Generalised(bilinear(plant.system), plant.controls, plant.measurements)
    _, inputs, outputs, controls, measurements = plant.sizes
    D, m, p = moved.system.D, inputs - controls, outputs - measurements
    if min(np.linalg.svd(D[:p, m:])[1].min(), np.linalg.svd(D[p:, :m])[1].min()) < 1e-12:
        raise FrictionloopError("the H-infinity synthesis needs a weight on every command and a noise in every reading")
    # One thread: the matrices are small, and more of them take 2 to 30 times as long.
    with threadpool_limits(1):
        first = _keeping(moved, ONE_NORM, 1e6)  # for a large norm the central controller is that of LQG
        least = _keeping(moved, BISECTION, (1 + STEP) * first.gamma, STEP * first.gamma)
        found = _keeping(moved, ONE_NORM, ABOVE_LEAST * least.gamma)
    return found._replace(controller=bilinear(found.controller, back=True))


def _keeping(plant: Generalised, job: int, norm: float, step: float = 0.0) -> Synthesis:
    """Return what SB10AD finds for a continuous plant, with the norm that its loop has.

    That norm is computed anew: close to the least one, SB10AD takes Riccati equations for solved that are not.
    """
    *found, _, _, info = slicot().sb10ad(job, *plant.sizes, *map(np.asfortranarray, plant.system), norm, step, 0.0)
    _check(info, "H-infinity")
    A, B, C, D = map(np.asfortranarray, found[4:])
    loop = (len(A), B.shape[1], len(C), np.array([0.0, 1.0]), A, np.eye(len(A), order="F"), B, C, D)
    (peak, scale), _, info = slicot().ab13dd("C", "I", "N", "D", *loop, 1e-7)
    _check(info, "H-infinity")
    return Synthesis(_controller(plant, found[:4]), float(peak / scale))


def lqg(plant: Generalised) -> Quadruple:
    """Return the sampled controller u = K y that minimises the sum of squares of z for white w, with no delay left out.

    The regulator acts on the estimate that contains the present measurement, so K has a direct path.

    Parameters
    ----------
    plant
        Sampled, with a weight on every command and noise in every measurement.

    Raises
    ------
    FrictionloopError
        One of the two Riccati equations has no stabilising solution.
    """
    A, B, C, D = plant.system
    n, m, p = len(A), B.shape[1] - plant.controls, C.shape[0] - plant.measurements
    if np.any(D[p:, m:]):
        raise FrictionloopError("LQG: the command must not reach the measurement within one period")
    # SB10ED takes no D11. Behind a direct path that cancels what of it u can reach and y can see, the rest does
    # not change the controller.
    direct = -np.linalg.pinv(D[:p, m:]) @ D[:p, :m] @ np.linalg.pinv(D[p:, :m])
    into, out = np.vstack([B[:, m:], D[:, m:]]) @ direct, np.hstack([C[p:], D[p:]])
    shifted = np.block([[A, B], [C, D]]) + into @ out
    shifted[n : n + p, n : n + m] = 0.0
    parts = (shifted[:n, :n], shifted[:n, n:], shifted[n:, :n], shifted[n:, n:])
    with threadpool_limits(1):
        *found, _, info = slicot().sb10ed(*plant.sizes, *map(np.asfortranarray, parts))
    _check(info, "LQG")
    K = _controller(plant, found)
    return K._replace(D=K.D + direct)


def _check(info: int, method: str) -> None:
    if info:
        raise FrictionloopError(f"the {method} synthesis does not converge: SLICOT ends with {info}")


def _controller(plant: Generalised, parts: list[Any]) -> Quadruple:
    n, u, y = len(plant.system.A), plant.controls, plant.measurements
    shapes: list[tuple[int, int]] = [(n, n), (n, y), (u, n), (u, y)]
    A, B, C, D = (
        np.asarray(part, dtype=float).reshape(shape, order="F") for part, shape in zip(parts, shapes, strict=True)
    )
    return Quadruple(A, B, C, D)
