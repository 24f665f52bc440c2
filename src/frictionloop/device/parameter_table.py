"""The parameter table of a device: read, written into the copy that waits, put in force, its controller by name."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np

from frictionloop.control.lookup import LOOKUP_LAW
from frictionloop.control.pi import PI_LAW
from frictionloop.device.errors import DeviceError, Refused
from frictionloop.device.link import Info, Link
from frictionloop.firmware.compiled_core import controller_words
from frictionloop.firmware.image_law import LOOKUP
from frictionloop.firmware.parameter_files import accepted, from_words, shown, to_words, word_at, word_of
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters import Model, PiController, System, bench
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.protocol_schema import Word, parameter_words, schema, table_hash, word_count

PROTOCOL = schema()["protocol"]
LONGEST_RAMP_S = PROTOCOL["ramp_ms"] / 1000
"""From the ceiling to 0 at most."""
RELATIONS: dict[str, Callable[[dict[str, Any], int], str]] = {
    "law.high_n": lambda value, _: f"above law.low_n = {value['law.low_n']:g} N",
    "drive.largest_um": lambda value, _: "above 0 um",
    "drive.ceiling_um": lambda value, _: (
        f"at most drive.largest_um = {value['drive.largest_um']:g} um, at the image's share"
    ),
    "drive.ramp_um": lambda value, tick_hz: (
        f"at least {value['drive.ceiling_um'] / (LONGEST_RAMP_S * tick_hz):.4g} um, ramp {PROTOCOL['ramp_ms']} ms"
    ),
    "lookup.entries": lambda value, _: "0, or at least 2",
    "lookup.squares_um2": lambda value, _: "none above the one before",
    "safety.hum_ticks": lambda value, tick_hz: f"at most {tick_hz // 100}",
}
"""What the firmware asks of a parameter beside its range (firmware/core/app_parameters.c, fl_check_table)."""


def in_words(asked: str, refused: Refused, table: np.ndarray, info: Info) -> Refused:
    """Return a refusal of `set` or `commit` that names the parameter, its value and what would be accepted.

    A refusal that has no ``index``, that of the word that is wrong in the table, is returned as it is.
    """
    if refused.index is None or refused.index >= len(table) or refused.reason != "out_of_range":
        return refused
    word = word_at(refused.index)
    entry = refused.index - word.first
    number, name = float(table[refused.index]), f"{word.name}[{entry}]" if word.count > 1 else word.name
    said = f"{asked}: refused, {name} = {shown(word, number)}"
    must = _law(info) if word.name == "law.hash" else _limit(word, number, table, info.tick_hz)
    return Refused(f"{said}: must be {must}", refused.reason, refused.index)


def _law(info: Info) -> str:
    """Return which laws the device has."""
    return f"{info.law_hash} ({info.law}) or {LOOKUP} (lookup); firmware build FILE has another"


def _limit(word: Word, number: float, table: np.ndarray, tick_hz: int) -> str:
    """Return what is accepted: the range where that is broken, else how it goes with the others."""
    if not word.low <= number <= word.high or word.name not in RELATIONS:
        return accepted(word)
    words = parameter_words().values()
    values = {other.name: from_words(other, table[other.first : other.first + other.count]) for other in words}
    return RELATIONS[word.name](values, tick_hz)


WORDS_A_FRAME = schema()["protocol"]["words_a_frame"]


class Parameters(Mapping[str, Any]):
    """The parameters in force by name, in their units; `set` and `commit` change them."""

    def __init__(self, link: Link, info: Info) -> None:
        self._link, self._info = link, info
        self._waiting: np.ndarray | None = None
        """What the device's waiting copy holds as far as we wrote it, and else what is in force."""

    def __getitem__(self, name: str) -> float | np.ndarray:
        """Return the value in force, read from the device."""
        word = word_of(name)
        return from_words(word, self._read(word.first, word.count))

    def __iter__(self) -> Iterator[str]:
        """Return the names."""
        return iter(parameter_words())

    def __len__(self) -> int:
        """Return how many there are."""
        return len(parameter_words())

    def about(self, name: str) -> Word:
        """Return unit, range and meaning of a parameter."""
        return word_of(name)

    def set(self, name: str, value: Any) -> None:
        """Write a parameter into the copy that waits.

        Parameters
        ----------
        name : str
            As in docs/protocol.md.
        value : float or array
            In the parameter's unit.

        Raises
        ------
        FrictionloopError
            For an unknown name, a wrong count, or a value out of range.
        """
        self.put(name, to_words(word_of(name), value))

    def put(self, name: str, words: np.ndarray) -> None:
        """Write the words of a parameter into the copy that waits."""
        first = word_of(name).first
        self._mirror()[first : first + len(words)] = words
        self._write(first, words)

    def words(self) -> np.ndarray:
        """Return all words in force, read from the device."""
        return self._read(0, word_count())

    def hold(self, table: np.ndarray) -> bool:
        """Return whether these words are in force."""
        return bool(np.array_equal(self.words(), table))

    def write(self, table: np.ndarray) -> None:
        """Write all words into the copy that waits."""
        for _ in self.writing(table):
            pass

    def writing(self, table: np.ndarray) -> Iterator[None]:
        """As `write`, with a pause after each frame, for who has to listen to the device meanwhile."""
        if table.shape != (word_count(),):
            raise must_be("table", table.size, str(word_count()), "words")
        self._waiting = table.astype(float)
        for at in range(0, len(table), WORDS_A_FRAME):
            self._write(at, table[at : at + WORDS_A_FRAME])
            yield

    def commit(self) -> None:
        """Put what waits in force; the device checks it as a whole before."""
        waiting = self._mirror()
        check = zlib.crc32(waiting.astype("<f8").tobytes())
        try:
            try:
                self._link.ask("commit", crc=check)
            except Refused as refused:
                if refused.reason != "wrong_crc":
                    raise
                # Somebody wrote there before us: what waits is not what is in force with our changes.
                self._write(0, waiting)
                self._link.ask("commit", crc=check)
        except Refused as refused:
            raise in_words("commit", refused, waiting, self._info) from None
        finally:
            self._waiting = None

    def _mirror(self) -> np.ndarray:
        if self._waiting is None:
            self._waiting = self.words()
        return self._waiting

    def _read(self, first: int, count: int) -> np.ndarray:
        self._same_table()
        parts = [
            self._link.ask("get", first=at, count=min(WORDS_A_FRAME, first + count - at))["values"]
            for at in range(first, first + count, WORDS_A_FRAME)
        ]
        return np.concatenate(parts).astype(float)

    def _write(self, first: int, words: np.ndarray) -> None:
        self._same_table()
        for at in range(0, len(words), WORDS_A_FRAME):
            try:
                self._link.ask("set", first=first + at, values=words[at : at + WORDS_A_FRAME])
            except Refused as refused:
                raise in_words("set", refused, self._mirror(), self._info) from None

    def _same_table(self) -> None:
        if (told := self._info.table_hash) != table_hash():
            raise DeviceError(f"layout {told:08x}: must be {table_hash():08x}; flash this version", "NO-DEVICE")


TOLD = "controller.kp", "controller.ki"
"""Names that a device tells where nobody knows its System."""
ELSE = "give the system, or upload() it"


def table_for(system: System, info: Info) -> np.ndarray:
    """Return the parameter table of a System for a device, whose ticks are those of its image."""
    if system.controller.rate_hz != info.tick_hz:
        raise must_be(
            "controller.rate_hz", system.controller.rate_hz, f"{info.tick_hz} on this board", "Hz", "BOARD-RATE"
        )
    return firmware_words(system)


def law_in_force(parameters: Parameters, info: Info) -> str:
    """Return the kind of the law that a parameter table runs."""
    return LOOKUP_LAW.kind if parameters["law.hash"] == LOOKUP else info.law


def told_controller(parameters: Parameters, info: Info) -> PiController:
    """Return the PI controller that a parameter table holds."""
    law = law_in_force(parameters, info)
    if law != PI_LAW.kind:
        raise must_be("law", law, f"pi; {ELSE}")
    kp, ki = map(float, np.asarray(parameters["law.gains"])[:2])
    return PiController(kp=kp, ki=ki, rate_hz=info.tick_hz, model=Model(nominal_n=parameters["law.high_n"]))


def tuned_words(base: System | PiController, values: dict[str, Any], info: Info) -> dict[str, np.ndarray]:
    """Return the words by name of a controller with other values, of a System or as a device tells it."""
    if isinstance(base, System):
        tuned = base.evolve(values)
        table_for(tuned, info)  # also refuses what is not the board's, such as a rate
        return controller_words(tuned)
    for name in values:
        if name not in TOLD:
            raise FrictionloopError(f"{name}: accepted {', '.join(TOLD)}; {ELSE}", "NOT-CHECKED")
    controller: Any = bench().model_copy(update={"controller": base}).evolve(values).controller
    words = np.zeros(word_of("law.gains").count)
    words[:2] = controller.kp, controller.ki
    return {"law.gains": words}
