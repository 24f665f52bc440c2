"""Engines for tests of what stands in front of them."""

from __future__ import annotations

import numpy as np

import frictionloop as fl
from frictionloop.live.live_engines import CHANNELS

GRATING = fl.bench().evolve({"setpoint": {"kind": "effect"}, "controller.kind": "limit_observer"})


class Echo:
    """An engine that tells its path, and can be made to fail."""

    source = "simulated"

    def __init__(self, fails_at: int | None = None) -> None:
        self.system, self.ticks, self.fails_at = GRATING, 0, fails_at

    @property
    def rate_hz(self):
        return self.system.controller.rate_hz

    def advance(self, path):
        self.ticks += len(path)
        if self.fails_at is not None and self.ticks >= self.fails_at:
            raise ValueError("the wheel came off")
        rows = np.zeros((len(CHANNELS), len(path)))
        rows[0], rows[1] = 1e3 * path[:, 0], path[:, 2]
        return rows

    def change(self, system):
        self.system = system
        return True
