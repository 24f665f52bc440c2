"""The controller as the firmware runs it: its parameter words from a System, and the C core on this machine."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.control.law import Law
from frictionloop.control.laws import NUMBERED, law_of
from frictionloop.control.lookup import lookup_table
from frictionloop.control.overdrive import overdrive_gains
from frictionloop.firmware.compiler import FLAGS, shared_library
from frictionloop.firmware.known import check_known
from frictionloop.firmware.quantised import Gain, Quantised, pi_gains, to_gain, to_places, to_q28
from frictionloop.firmware.quantised_filtered import filtered_gains, filtered_state_places
from frictionloop.firmware.quantised_observer import (
    OBSERVER_PLACES,
    SUPER_TWISTING_PLACES,
    disturbance_observer_quantised,
    super_twisting_quantised,
)
from frictionloop.firmware.quantised_tracker import TRACKER_PLACES, tracker_quantised
from frictionloop.parameters import Model, System
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.extra import needed
from frictionloop.quantities.schema import BITS, firmware_folder, parameter_words, word_count
from frictionloop.quantities.trees import flat

FORMS: dict[str, Quantised] = {
    "pi": Quantised(pi_gains, lambda c: (28,)),
    "lookup": Quantised(lambda c: (), lambda c: (28,)),
    "filtered_pi": Quantised(filtered_gains, filtered_state_places),
    "observer": Quantised(disturbance_observer_quantised, lambda c: OBSERVER_PLACES),
    "super_twisting": Quantised(super_twisting_quantised, lambda c: SUPER_TWISTING_PLACES),
    "tracker": Quantised(tracker_quantised, lambda c: TRACKER_PLACES),
}
"""Laws that the firmware has, by the kind of `LAWS`."""
CELLS = 256
"""Of the firmware's lookup table, whatever ``model.table_size`` is."""

_DECLARATIONS = """
int32_t fl_host_states(uint32_t);
int32_t fl_host_places(uint32_t, uint32_t);
int32_t fl_host_tick(const int32_t *, int32_t *, int32_t *, const int32_t *, int32_t);
void fl_host_run(const int32_t *, size_t, int32_t *, int32_t *, const int32_t *, const int32_t *, int32_t *);
void fl_host_steps(const int32_t *, size_t, int32_t *, const int32_t *, const int32_t *, int32_t *);
void fl_host_lookup(const int32_t *, size_t, const int32_t *, int32_t *);
void fl_host_overdrive(const int32_t *, size_t, int32_t *, const int32_t *, int32_t *);
void fl_host_simulated(int32_t *, double *);
void fl_host_roots(size_t, const uint64_t *, uint32_t *);
"""  # of firmware/boards/host/fl_host.h


def quantised_gains(controller: Any) -> list[Gain]:
    """Return the gains of a controller's law as its C step takes them, each (mantissa, shift).

    Raises
    ------
    FrictionloopError
        When the firmware has no such law, or a gain does not fit it.
    """
    return list(_form(law_of(controller)).gains(controller))


def state_places(controller: Any) -> tuple[int, ...]:
    """Return the binary places of each state of a controller's law in the firmware."""
    return _form(law_of(controller)).places(controller)


def quantised_start(controller: Any) -> list[int]:
    """Return the law's state at t = 0 as whole numbers, each in its own binary places.

    What two words hold is 0 then (firmware/quantised_tracker).
    """
    law, places = law_of(controller), state_places(controller)
    start = flat(law.start_for(controller))
    words = [to_places(value, places[i], f"state {i} of {law.kind} at t = 0") for i, value in enumerate(start)]
    return words + [0] * (len(places) - len(words))


def law_words(controller: Any) -> dict[str, np.ndarray]:
    """Return the words ``law.*`` of the parameter table by name, int32."""
    words = parameter_words()
    gains, start = words["law.gains"], words["law.start"]
    return {
        "law.number": _array([1 + NUMBERED.index(law_of(controller))], 1),
        "law.gains": _array([number for gain in quantised_gains(controller) for number in gain], gains.words),
        "law.start": _array(quantised_start(controller), start.words),
        "law.low_n": _array([to_q28(controller.model.floor_n, "g(controller.model.max_amplitude_um)")], 1),
        "law.high_n": _array([to_q28(controller.model.nominal_n, "controller.model.nominal_n")], 1),
    }


def lookup_words(model: Model) -> dict[str, np.ndarray]:
    """Return the words ``lookup.*``: a^2 = ln(f0/u)/tau at 257 forces from g(a_max) to f0, and cells a newton.

    Interpolating the square linearly errs by at most h^2/(8 u) in force, h the spacing: 14 uN with the values of the
    paper, and more the lower g(a_max).
    """
    table = model.model_copy(update={"table_size": CELLS + 1})
    places, name = BITS[parameter_words()["lookup.squares_um2"].format], "controller.model.max_amplitude_um^2"
    squares = [to_places(max(float(square), 0.0), places, name) for square in lookup_table(table)]
    cells = to_gain(CELLS / (model.nominal_n - model.floor_n), "256 / (f0 - g(a_max))")
    return {"lookup.squares_um2": _array(squares, CELLS + 1), "lookup.cells_per_n": _array(cells, 2)}


def overdrive_words(controller: Any) -> dict[str, np.ndarray]:
    """Return the words ``overdrive.*``."""
    decay, inverse, _ = overdrive_gains(controller)
    gain = to_gain(inverse, "1/(1 - decay of the believed plate)")
    return {"overdrive.decay": _array([to_q28(decay, "decay")], 1), "overdrive.inverse": _array(gain, 2)}


def controller_words(system: System) -> dict[str, np.ndarray]:
    """Return all words that a System's controller alone decides: law, lookup and overdrive."""
    check_known(system, "controller")
    controller = system.controller
    return law_words(controller) | lookup_words(controller.model) | overdrive_words(controller)


def host_words(system: System) -> np.ndarray:
    """Return a parameter table for the host library: the controller's words, the ceiling its model's; 0 elsewhere."""
    ceiling = to_q28(system.controller.model.max_amplitude_um, "controller.model.max_amplitude_um")
    table = np.zeros(word_count(), dtype=np.int32)
    for name, values in (controller_words(system) | {"drive.ceiling_um": _array([ceiling], 1)}).items():
        word = parameter_words()[name]
        table[word.first : word.first + word.words] = values
    return table


@cache
def host_library(flags: tuple[str, ...] = FLAGS, command: tuple[str, ...] | None = None) -> tuple[Any, Any]:
    """Return (ffi, library): the C core on this machine, compiled at the first call.

    Parameters
    ----------
    flags, command
        As `shared_library` takes them; the same bits come from all.

    Raises
    ------
    FrictionloopError
        Without cffi or a C compiler, or when the core does not compile.
    """
    ffi = needed("cffi", "cffi", "firmware").FFI()
    ffi.cdef(_DECLARATIONS)
    sources, folders = host_sources()
    return ffi, ffi.dlopen(str(shared_library("core", sources, folders, flags, command)))


def host_sources() -> tuple[list[Path], list[Path]]:
    """Return the C files of the host library, and the folders of their headers."""
    folders = [firmware_folder() / "core", firmware_folder() / "boards" / "host"]
    return [source for folder in folders for source in sorted(folder.glob("*.c"))], folders


def _form(law: Law) -> Quantised:
    if law.kind not in FORMS:
        raise FrictionloopError(f'controller.kind = "{law.kind}": the firmware has {", ".join(FORMS)}')
    return FORMS[law.kind]


def _array(numbers: Any, size: int) -> np.ndarray:
    """Return the numbers as int32, filled with 0 to a size."""
    array = np.zeros(size, dtype=np.int32)
    array[: len(numbers)] = numbers
    return array
