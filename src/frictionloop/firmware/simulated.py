"""The C core as the simulator calls it: ``controller.form = "firmware"``."""

from __future__ import annotations

import numpy as np

from frictionloop.firmware.compiled import host_library, host_words, quantised_start
from frictionloop.parameters import System
from frictionloop.quantities.schema import parameter_words


def core_address() -> int:
    """Return the address of ``fl_host_simulated`` in this process.

    Raises
    ------
    FrictionloopError
        When the core cannot be built here.
    """
    ffi, library = host_library()
    return int(ffi.cast("intptr_t", ffi.addressof(library, "fl_host_simulated")))


def core_context(system: System) -> np.ndarray:
    """Return what the core keeps of a System's controller at t = 0, int32: see firmware/boards/host/simulated.c."""
    start = np.zeros(parameter_words()["law.start"].count, np.int32)
    numbers = quantised_start(system.controller)
    start[: len(numbers)] = numbers
    return np.concatenate([host_words(system), start, [0, -1 if system.controller.open_until_s else 0]]).astype(
        np.int32
    )
