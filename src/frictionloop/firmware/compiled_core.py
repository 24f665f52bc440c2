"""The controller as the firmware runs it: what of it it has, its parameter words, and the C core on this machine."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from frictionloop.control.law import Law
from frictionloop.control.laws import LAWS, law_of
from frictionloop.control.lookup import LOOKUP_LAW, inverse_numbers, lookup_table, overdrive_gains
from frictionloop.firmware.host_compiler import FLAGS, shared_library
from frictionloop.firmware.image_law import LOOKUP, board_law
from frictionloop.firmware.parameter_files import to_words
from frictionloop.parameters import Board, LoadCells, Model, PositionSensor, System, Touch
from frictionloop.parameters.block import Represented
from frictionloop.quantities import must_be
from frictionloop.quantities.flat_tuples import flat
from frictionloop.quantities.optional_libraries import needed
from frictionloop.quantities.protocol_schema import firmware_folder, parameter_words, schema

FIRMWARE = Represented(
    "the firmware",
    {
        Touch: "position load",
        PositionSensor: "tracking_hz",
        LoadCells: "touch_n touch_share mean_s least_speed_mm_s speed_share developed_mm turn_mm",
        Board: "force_axes force_zero_counts force_n_per_count across_n_per_count load_zero_counts load_n_per_count "
        "position_m_per_count ceiling_um ramp_s force_limit_n hum_share",
    },
    # Noise, range and length are those of the sensors that it reads.
    {
        PositionSensor: "noise_um resolution_um fastest_mm_s",
        LoadCells: "noise_n length_mm",
    },
)


def check_known(system: System, *blocks: str) -> None:
    """Refuse a field of a System's blocks that no word of the firmware has."""
    FIRMWARE.check({name: getattr(system, name) for name in blocks})


def controller_words(system: System) -> dict[str, np.ndarray]:
    """Return the words that a System's controller alone decides, by name: law, lookup and overdrive."""
    controller, law = system.controller, law_of(system.controller)
    model, words = controller.model, parameter_words()
    decay, inverse, _ = overdrive_gains(controller)
    gains, start = flat(law.gains_for(controller))[:-2], flat(law.start_for(controller))
    own = LOOKUP if law is LOOKUP_LAW else board_law(law).hash
    values = {
        "law.hash": own,
        "law.gains": [*gains, *[0.0] * (words["law.gains"].count - len(gains))],
        "law.start": [*start, *[0.0] * (words["law.start"].count - len(start))],
        "law.low_n": model.floor_n,
        "law.high_n": model.nominal_n,
        **_lookup(model),
        "overdrive.decay": decay,
        "overdrive.inverse": inverse,
    }
    return {name: to_words(words[name], value) for name, value in values.items()}


def _lookup(model: Model) -> dict[str, Any]:
    """Return the values ``lookup.*``: the table of a model that has one, else what the inverse is calculated with."""
    entries, most = model.table_size, parameter_words()["lookup.squares_um2"].count
    if entries > most:
        raise must_be("controller.model.table_size", entries, f"at most {most} on a board")
    log2_nominal, um2_per_halving = inverse_numbers(model)
    squares = [*lookup_table(model)] if entries else []
    return {
        "lookup.entries": entries,
        "lookup.log2_nominal": log2_nominal,
        "lookup.um2_per_halving": um2_per_halving,
        "lookup.squares_um2": [*np.maximum(squares, 0.0), *[0.0] * (most - len(squares))],
        "lookup.cells_per_n": (entries - 1) / (model.nominal_n - model.floor_n) if entries else 0.0,
    }


def host_sources() -> tuple[list[Path], list[Path]]:
    """Return the C files of the host library, and the folders of their headers."""
    folders = [firmware_folder() / "core", firmware_folder() / "boards" / "host"]
    return [source for folder in folders for source in sorted(folder.glob("*.c"))], folders


def declarations() -> str:
    """Return what the headers of the host library declare, for cffi; a parameter table is the address of its words."""
    core, host = host_sources()[1]
    lines = [line for header in (core / "fl_app.h", host / "fl_host.h") for line in header.read_text().splitlines()]
    plain = [line for line in lines if not line.startswith(("#", "_Static_assert"))]
    return "\n".join(["typedef void fl_parameters;", *plain])


def law_of_table(words: np.ndarray) -> Law:
    """Return the law that a parameter table is for: the lookup, or the one whose C has its hash."""
    number = int(words[parameter_words()["law.hash"].first])
    laws = (law for law in LAWS.values() if law is not LOOKUP_LAW)
    return next((law for law in laws if number and board_law(law).hash == number), LOOKUP_LAW)


@cache
def host_library(
    law: Law,
    rate_hz: float,
    flags: tuple[str, ...] = FLAGS,
    command: tuple[str, ...] | None = None,
    built: Path | None = None,
) -> tuple[Any, Any]:
    """Return (ffi, library): the firmware with a law, without a board, on this machine; compiled at the first call.

    Parameters
    ----------
    law
        Beside the lookup.
    rate_hz
        Of the ticks.
    flags, command
        As `shared_library` takes them; the same bits come from all.
    built
        A library that was built otherwise, in the place of all that.
    """
    ffi = needed("cffi", "cffi", "firmware").FFI()
    ffi.cdef(declarations())
    if built is not None:
        return ffi, ffi.dlopen(str(built))
    sources, folders = host_sources()
    with TemporaryDirectory() as folder:
        own = board_law(law).write(Path(folder))
        ticks = f"-DFL_TICK_HZ={tick_hz(rate_hz)}"
        return ffi, ffi.dlopen(str(shared_library("core", [*sources, own], folders, (*flags, ticks), command)))


def tick_hz(rate_hz: float) -> int:
    """Return the rate of the ticks of an image; raise FrictionloopError for one that no board has."""
    rates = schema()["rates"]["hz"]
    if rate_hz not in rates:
        accepted = f"{rates[0]} to {rates[-1]}, whole us a tick, on a board"
        raise must_be("controller.rate_hz", rate_hz, accepted, "Hz", "BOARD-RATE")
    return int(rate_hz)
