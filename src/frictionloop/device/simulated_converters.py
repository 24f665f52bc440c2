"""Newtons and metres of a simulated bench as the counts that its board's converters would give."""

from __future__ import annotations

from frictionloop.device.host_board import Sample
from frictionloop.firmware.parameter_words import n_per_count
from frictionloop.parameters import System
from frictionloop.sensing.measurement import Measurement

ENDS = -(2**15), 2**15 - 1
"""Of a converter: 16 bit."""


class Converters:
    """The wiring that ``system.board`` describes, the other way round: what the firmware makes of it is what was there.

    Parameters
    ----------
    system : System
        The bench. The force comes on the first channel, and on the second none.
    """

    def __init__(self, system: System) -> None:
        board = self._board = system.board
        self._force_n = n_per_count(system)
        self._scales = board.position_m_per_count, board.load_n_per_count

    def sample(self, measured: Measurement) -> Sample:
        """Return the counts of a tick, at an end of the converter where a reading does not fit."""
        along, across = self._board.force_zero_counts
        position, load = self._scales
        return Sample(
            _counts(measured.force, self._force_n, along),
            across,
            _counts(measured.position, position, 0),
            _counts(measured.load, load, self._board.load_zero_counts),
        )


def _counts(value: float, unit: float, zero: int) -> int:
    return min(max(zero + round(value / unit), ENDS[0]), ENDS[1]) if unit else zero
