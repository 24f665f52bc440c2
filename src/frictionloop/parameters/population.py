"""A population of fingers that was measured: medians, spreads and correlations, as TOML."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np
from pydantic import Field

from frictionloop.parameters.block import Block, NotNegative, Number, Positive, Whole
from frictionloop.parameters.frozen_blocks import Description
from frictionloop.parameters.toml_reader import read_tree
from frictionloop.quantities import must_be
from frictionloop.quantities.counter_noise import covariance_root


class Spread(Block):
    """A value that differs from finger to finger, log-normally."""

    path: str
    """Dotted name in the System."""
    median: Positive
    """Median over fingers, in the unit that the name ends with."""
    spread: NotNegative
    """Standard deviation of its natural logarithm over fingers."""


class Population(Description):
    """What ``fl.fingers`` draws in place of what is assumed."""

    fingers: Annotated[Whole, Field(ge=1)] = 1
    """On how many fingers it was measured."""
    value: Annotated[tuple[Spread, ...], Field(min_length=1)]
    """The values that were measured; the others stay as assumed."""
    correlation: tuple[tuple[Number, ...], ...] = ()
    """Of the logarithms, a row for each value; none: independent."""

    def _check(self) -> None:
        names = [each.path for each in self.value]
        if len(set(names)) < len(names):
            raise ValueError(f"value: {', '.join(names)} must all differ")
        if self.correlation:
            matrix = self.matrix()
            if matrix.shape != (len(names), len(names)):
                raise must_be("correlation: shape", matrix.shape, f"{(len(names),) * 2}")
            even = np.allclose(matrix, matrix.T) and np.allclose(np.diag(matrix), 1.0)
            if not even or float(np.linalg.eigvalsh(matrix).min()) < -1e-6:
                raise ValueError("correlation: must be symmetric, 1 on its diagonal, positive semidefinite")

    def matrix(self) -> np.ndarray:
        """Return the correlation of the logarithms, shape (values, values)."""
        if not self.correlation:
            return np.eye(len(self.value))
        if len({len(row) for row in self.correlation}) > 1:
            return np.zeros((0, 0))
        return np.array(self.correlation, dtype=float)

    def root(self) -> np.ndarray:
        """Return R with R R^T = correlation, which turns independent normals into correlated ones."""
        return covariance_root(self.matrix())


def read_population(source: Population | Mapping[str, Any] | str | os.PathLike[str]) -> Population:
    """Return a population from itself, from a mapping, or from a TOML file."""
    if isinstance(source, Population):
        return source
    if isinstance(source, Mapping):
        return Population.from_tree(source, "population: ")
    return Population.from_tree(read_tree(source), f"{source}: ")
