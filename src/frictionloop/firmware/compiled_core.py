"""The controller as the firmware runs it: what of it it has, its parameter words, and the C core on this machine."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from frictionloop.control.law import Law
from frictionloop.control.laws import NUMBERED, law_of
from frictionloop.control.limit_observer import LimitObserverController
from frictionloop.control.lookup import lookup_table, overdrive_gains
from frictionloop.firmware.compiler import FLAGS, shared_library
from frictionloop.firmware.quantised import Gain, Quantised, pi_gains, to_gain, to_places, to_q28
from frictionloop.firmware.quantised_filtered import filtered_gains, filtered_state_places
from frictionloop.firmware.quantised_limit import LIMIT_PLACES, limit_observer_quantised
from frictionloop.firmware.words import filled
from frictionloop.parameters import (
    Board,
    FilteredPiController,
    LoadCells,
    LookupController,
    Model,
    NotchPiController,
    PiController,
    PositionSensor,
    System,
    Timing,
    Touch,
)
from frictionloop.parameters.controller import FeedForward
from frictionloop.parameters.represented import Represented
from frictionloop.quantities import must_be
from frictionloop.quantities.extra import needed
from frictionloop.quantities.schema import BITS, firmware_folder, parameter_words
from frictionloop.quantities.trees import flat

FIRMWARE = Represented(
    "the firmware's form of the law",
    {
        # Delay, jitter and lost ticks are the board's own: a simulation keeps them.
        Timing: "rate_hz delay_s jitter_s lost_ticks open_until_s form model",
        PiController: "kind kp ki",
        LookupController: "kind overdrive",
        FeedForward: "kp ki feedforward overdrive",
        FilteredPiController: "kind sections",
        NotchPiController: "kind kp ki notch_hz notch_depth notch_width",
        LimitObserverController: "kind slip_length_um susceptibility_margin bandwidth_hz spring_noise",
        Model: "nominal_n susceptibility_per_um2 max_amplitude_um plate_hz resonance_hz resonance_q sensor_hz "
        "table_um2",
        Touch: "position load",
        PositionSensor: "tracking_hz",
        LoadCells: "touch_n touch_share mean_s least_speed_mm_s speed_share developed_mm turn_mm",
        Board: "force_axes force_zero_counts force_n_per_count across_n_per_count load_zero_counts load_n_per_count "
        "position_m_per_count ceiling_um ramp_s force_limit_n hum_share",
    },
    # Its table has 257 entries whatever is given; noise, range and length are those of the sensors that it reads.
    {
        Model: "table_size gain_spread",
        PositionSensor: "noise_um resolution_um fastest_mm_s",
        LoadCells: "noise_n length_mm",
    },
)


def check_known(system: System, *blocks: str) -> None:
    """Refuse a field of a System's blocks that no word of the firmware has."""
    FIRMWARE.check({name: getattr(system, name) for name in blocks})


FORMS: dict[str, Quantised] = {
    "pi": Quantised(pi_gains, lambda c: (28,)),
    "lookup": Quantised(lambda c: (), lambda c: (28,)),
    "filtered_pi": Quantised(filtered_gains, filtered_state_places),
    "limit_observer": Quantised(limit_observer_quantised, lambda c: LIMIT_PLACES),
}
"""Laws that the firmware has, by the kind of `LAWS`."""
CELLS = 256
"""Of the firmware's lookup table, whatever ``model.table_size`` is."""


def quantised_gains(controller: Any) -> list[Gain]:
    """Return the gains of a controller's law as its C step takes them, each (mantissa, shift)."""
    return list(_form(law_of(controller)).gains(controller))


def state_places(controller: Any) -> tuple[int, ...]:
    """Return the binary places of each state of a controller's law in the firmware."""
    return _form(law_of(controller)).places(controller)


def quantised_start(controller: Any) -> list[int]:
    """Return the law's state at t = 0 as whole numbers, each in its own binary places."""
    law, places = law_of(controller), state_places(controller)
    start = flat(law.start_for(controller))
    return [to_places(value, places[i], f"{law.kind}: state {i}") for i, value in enumerate(start)]


def controller_words(system: System) -> dict[str, np.ndarray]:
    """Return the words that a System's controller alone decides, by name: law, lookup and overdrive."""
    check_known(system, "controller")
    controller = system.controller
    low_n = to_q28(controller.model.floor_n, "g(controller.model.max_amplitude_um)")
    high_n = to_q28(controller.model.nominal_n, "controller.model.nominal_n")
    decay, inverse, _ = overdrive_gains(controller)
    overdriven = to_gain(inverse, "1/(1 - decay)")
    return {
        "law.number": _words([1 + NUMBERED.index(law_of(controller))]),
        "law.gains": _words(np.ravel(quantised_gains(controller)), parameter_words()["law.gains"].words),
        "law.start": _words(quantised_start(controller), parameter_words()["law.start"].words),
        "law.low_n": _words([low_n]),
        "law.high_n": _words([high_n]),
        **_lookup_words(controller.model),
        "overdrive.decay": _words([to_q28(decay, "decay")]),
        "overdrive.inverse": _words(overdriven),
    }


def host_words(system: System) -> np.ndarray:
    """Return a parameter table for the host library: the controller's words, the ceiling its model's; 0 elsewhere."""
    ceiling = to_q28(system.controller.model.max_amplitude_um, "controller.model.max_amplitude_um")
    return filled(controller_words(system) | {"drive.ceiling_um": _words([ceiling])})


def host_sources() -> tuple[list[Path], list[Path]]:
    """Return the C files of the host library, and the folders of their headers."""
    folders = [firmware_folder() / "core", firmware_folder() / "boards" / "host"]
    return [source for folder in folders for source in sorted(folder.glob("*.c"))], folders


def declarations() -> str:
    """Return what the headers of the host library declare, for cffi; a parameter table is the address of its words."""
    core, host = host_sources()[1]
    lines = [line for header in (core / "fl_app.h", host / "fl_host.h") for line in header.read_text().splitlines()]
    return "\n".join(["typedef void fl_parameters;", *(line for line in lines if not line.startswith("#"))])


@cache
def host_library(
    flags: tuple[str, ...] = FLAGS, command: tuple[str, ...] | None = None, built: Path | None = None
) -> tuple[Any, Any]:
    """Return (ffi, library): the firmware without a board on this machine, compiled at the first call.

    Parameters
    ----------
    flags, command
        As `shared_library` takes them; the same bits come from all.
    built
        A library that was built otherwise, in the place of all that.
    """
    ffi = needed("cffi", "cffi", "firmware").FFI()
    ffi.cdef(declarations())
    sources, folders = host_sources()
    return ffi, ffi.dlopen(str(built or shared_library("core", sources, folders, flags, command)))


def core_address() -> int:
    """Return the address in this process of what the simulator calls for ``controller.form = "firmware"``."""
    ffi, library = host_library()
    return int(ffi.cast("intptr_t", ffi.addressof(library, "fl_host_simulated")))


def core_context(system: System) -> np.ndarray:
    """Return what the core keeps of a System's controller at t = 0, int32: see firmware/boards/host/simulated.c."""
    start = _words(quantised_start(system.controller), parameter_words()["law.start"].words)
    closing = [0, -1 if system.controller.open_until_s else 0]
    return np.concatenate([host_words(system), start, _words(closing)])


def _lookup_words(model: Model) -> dict[str, np.ndarray]:
    """Return a^2 = ln(f0/u)/tau at 257 forces from g(a_max) to f0, and cells a newton.

    Interpolating the square linearly errs by at most h^2/(8 u) in force, h the spacing: 14 uN with the values of the
    paper, and more the lower g(a_max).
    """
    table = model.model_copy(update={"table_size": CELLS + 1})
    places, name = BITS[parameter_words()["lookup.squares_um2"].format], "controller.model.max_amplitude_um^2"
    squares = [to_places(max(float(square), 0.0), places, name) for square in lookup_table(table)]
    cells = to_gain(CELLS / (model.nominal_n - model.floor_n), "256 / (f0 - g(a_max))")
    return {"lookup.squares_um2": _words(squares), "lookup.cells_per_n": _words(cells)}


def _form(law: Law) -> Quantised:
    if law.kind not in FORMS:
        raise must_be("controller.kind", law.kind, f"one of {', '.join(FORMS)} on a board")
    return FORMS[law.kind]


def _words(numbers: Any, size: int = 0) -> np.ndarray:
    """Return whole numbers as int32, filled with 0 to a size."""
    return np.pad(np.asarray(numbers, dtype=np.int32), (0, max(size - len(numbers), 0)))
