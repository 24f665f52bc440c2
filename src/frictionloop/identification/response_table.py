"""A frequency response that is given as a table: of a stepped sine, or as another program computed it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from frictionloop.identification.frequency_response import FrequencyResponse
from frictionloop.identification.opened import Opened
from frictionloop.quantities import FrictionloopError

Array = NDArray[np.float64]
UNKNOWN_SHARE = 0.01
"""Share of its size that a value of a table is taken to be off by where no coherence stands beside it (assumed)."""
LEAST = 8
"""Frequencies that a table must have."""
_NAMES = "frequency with response (complex), with real and imaginary, or with magnitude and, if it is known, phase_deg"


def response_table(file: Opened) -> FrequencyResponse:
    """Return the response that a file lists over frequency.

    Parameters
    ----------
    file : Opened
        Channels ``frequency`` in Hz, and ``response`` (complex), ``real`` and ``imaginary``, or ``magnitude`` and
        ``phase_deg`` or ``phase_rad``; a ``coherence`` is used if it is there. A magnitude in dB is 20 log10 of it.
        Rows of one frequency are averaged, and their order does not matter. Without a phase the response is real and
        its fit goes by magnitude.

    Raises
    ------
    FrictionloopError
        For columns that are missing, fewer than eight frequencies, or values that are no numbers.
    """
    columns = {name: np.asarray(line.samples[:]) for name, line in file.picked.items()}
    if "frequency" not in columns:
        raise FrictionloopError(f"{file.where}: no channel is called 'frequency'; accepted: {_NAMES}")
    sizes = {name: values.size for name, values in columns.items()}
    if len(set(sizes.values())) > 1:
        raise FrictionloopError(f"{file.where}: columns have unequal lengths: {sizes}; accepted: equal ones")
    hertz = np.asarray(columns["frequency"], dtype=float)
    values = _complex(file, columns)
    coherence = np.asarray(columns.get("coherence", np.full(hertz.size, np.nan)), dtype=float)
    fine = np.isfinite(hertz) & np.isfinite(values) & (hertz > 0)
    steps, place = np.unique(hertz[fine], return_inverse=True)
    if steps.size < LEAST:
        raise FrictionloopError(f"{file.where}: holds {steps.size} frequencies: must hold at least {LEAST}")
    count = np.bincount(place)
    total = np.bincount(place, values[fine].real) + 1j * np.bincount(place, values[fine].imag)
    mean = (total / count).astype(complex)
    shared = np.bincount(place, np.nan_to_num(coherence[fine], nan=1 / (1 + 2 * UNKNOWN_SHARE**2))) / count
    shared = np.clip(shared, 1e-6, 1.0)
    # No rate is told: the highest frequency stands for half of one.
    told = file.picked["magnitude" if "magnitude" in columns else "frequency"].unit
    return FrequencyResponse(
        steps, mean, shared, np.sqrt((1 - shared) / (2 * shared)), np.ones_like(steps), int(count.max()),
        2 * float(steps[-1]), told if "magnitude" in columns and told else "1",
    )  # fmt: skip


def has_phase(found: FrequencyResponse) -> bool:
    """Return whether a response is more than its magnitude."""
    return bool(np.any(np.abs(found.response.imag) > 0))


def _complex(file: Opened, columns: dict[str, NDArray[np.generic]]) -> NDArray[np.complex128]:
    if "response" in columns:
        return columns["response"].astype(complex)
    if "real" in columns and "imaginary" in columns:
        return np.asarray(columns["real"], dtype=float) + 1j * np.asarray(columns["imaginary"], dtype=float)
    if "magnitude" not in columns:
        there = ", ".join(columns)
        raise FrictionloopError(f"{file.where}: channels {there} are no response; accepted: {_NAMES}")
    size = np.asarray(columns["magnitude"], dtype=float)
    if _in_db(file):
        size = 10 ** (size / 20)
    if np.nanmin(size) < 0:
        raise FrictionloopError(
            f"{file.where}: magnitude goes down to {np.nanmin(size):g}: must not be negative; is it in dB? then "
            'unit = "dB"'
        )
    turn = np.zeros_like(size)
    if "phase_deg" in columns:
        turn = np.deg2rad(np.asarray(columns["phase_deg"], dtype=float))
    elif "phase_rad" in columns:
        turn = np.asarray(columns["phase_rad"], dtype=float)
    scale = file.chart.channels["magnitude"].scale or 1.0
    return np.asarray(scale * size * np.exp(1j * turn))


def _in_db(file: Opened) -> bool:
    line = file.picked["magnitude"]
    said = file.chart.channels["magnitude"].unit or line.unit or line.name.rpartition(" ")[2]
    return said.strip("[]() ").lower() == "db"
