"""The parameter table of a device: read, written into the copy that waits, put in force, its controller by name."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.control.laws import NUMBERED
from frictionloop.device.errors import DeviceError, Refused
from frictionloop.device.link import Link
from frictionloop.firmware.built_in import KINDS
from frictionloop.firmware.compiled_core import controller_words
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.firmware.quantised import pi_gains
from frictionloop.firmware.words import accepted, from_words, shown, to_words, word_at, word_of
from frictionloop.parameters import Model, PiController, System, bench
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.schema import Word, parameter_words, schema, table_hash, word_count

PROTOCOL = schema()["protocol"]
LONGEST_RAMP = PROTOCOL["ramp_ms"] * PROTOCOL["tick_hz"] / 1000
"""Ticks from the ceiling to 0 at most."""
RELATIONS: dict[str, Callable[[dict[str, Any]], str]] = {
    "law.high_n": lambda value: f"above law.low_n = {value['law.low_n']:g} N",
    "drive.largest_um": lambda value: "above 0 um",
    "drive.ceiling_um": lambda value: (
        f"at most drive.largest_um = {value['drive.largest_um']:g} um, at the image's share"
    ),
    "drive.ramp_um": lambda value: (
        f"at least {value['drive.ceiling_um'] / LONGEST_RAMP:.4g} um, ramp {PROTOCOL['ramp_ms']} ms"
    ),
    "lookup.squares_um2": lambda value: "none above the one before",
}
"""What the firmware asks of a parameter beside its range (firmware/core/app_parameters.c, fl_check_table)."""


def in_words(asked: str, refused: Refused, table: np.ndarray, laws: Sequence[str]) -> Refused:
    """Return a refusal of `set` or `commit` that names the parameter, its value and what would be accepted.

    `laws` are those that the device has.

    A refusal that has no ``index``, that of the word that is wrong in the table, is returned as it is.
    """
    if refused.index is None or refused.index >= len(table) or refused.reason != "out_of_range":
        return refused
    word = word_at(refused.index)
    values = np.atleast_1d(from_words(word, table[word.first : word.first + word.words]))
    entry = (refused.index - word.first) * word.count // word.words
    number, name = float(values[entry]), f"{word.name}[{entry}]" if word.count > 1 else word.name
    said = f"{asked}: refused, {name} = {shown(word, number)}"
    must = _law(number, laws) if word.name == "law.number" else _limit(word, number, table)
    return Refused(f"{said}: must be {must}", refused.reason, refused.index)


def _law(number: float, laws: Sequence[str]) -> str:
    """Return which laws the device has, and how it gets another that the firmware has."""
    has = ", ".join(f"{1 + KINDS.index(kind)} {kind}" for kind in laws)
    other = KINDS[int(number) - 1] if 0 < number <= len(KINDS) else None
    return f"one of {has}" + (f"; firmware build --laws {other}" if other else "")


def _limit(word: Word, number: float, table: np.ndarray) -> str:
    """Return what is accepted: the range where that is broken, else how it goes with the others."""
    inside = (word.low is None or word.low <= number) and (word.high is None or number <= word.high)
    if not inside or word.name not in RELATIONS:
        return accepted(word)
    words = parameter_words().values()
    values = {other.name: from_words(other, table[other.first : other.first + other.words]) for other in words}
    return RELATIONS[word.name](values)


WORDS_A_FRAME = schema()["protocol"]["words_a_frame"]


class Parameters(Mapping[str, Any]):
    """The parameters in force by name, in their units; `set` and `commit` change them."""

    def __init__(self, link: Link, hash_of_device: int, laws: Sequence[str]) -> None:
        self._link, self._hash, self._laws = link, hash_of_device, laws
        self._waiting: np.ndarray | None = None
        """What the device's waiting copy holds as far as we wrote it, and else what is in force."""

    def __getitem__(self, name: str) -> float | np.ndarray:
        """Return the value in force, read from the device."""
        word = word_of(name)
        return from_words(word, self._read(word.first, word.words))

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
        """Return all words in force, int32, read from the device."""
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
        self._waiting = table.astype(np.int32)
        for at in range(0, len(table), WORDS_A_FRAME):
            self._write(at, table[at : at + WORDS_A_FRAME])
            yield

    def commit(self) -> None:
        """Put what waits in force; the device checks it as a whole before."""
        waiting = self._mirror()
        check = zlib.crc32(waiting.astype("<i4").tobytes())
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
            raise in_words("commit", refused, waiting, self._laws) from None
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
        return np.concatenate(parts).astype(np.int32)

    def _write(self, first: int, words: np.ndarray) -> None:
        self._same_table()
        for at in range(0, len(words), WORDS_A_FRAME):
            try:
                self._link.ask("set", first=first + at, values=words[at : at + WORDS_A_FRAME])
            except Refused as refused:
                raise in_words("set", refused, self._mirror(), self._laws) from None

    def _same_table(self) -> None:
        if self._hash != table_hash():
            raise DeviceError(f"layout {self._hash:08x}: must be {table_hash():08x}; flash this version", "NO-DEVICE")


TOLD = "controller.kp", "controller.ki"
"""Names that a device tells where nobody knows its System."""
DIGITS = 8
"""Of a gain that is read back: the device holds 30 bits."""
ELSE = "give the system, or upload() it"


def told_controller(parameters: Parameters, rate_hz: float) -> PiController:
    """Return the PI controller that a parameter table holds."""
    number = int(parameters["law.number"])
    law = NUMBERED[number - 1].kind if 0 < number <= len(NUMBERED) else "none"
    if law != "pi":
        raise must_be("law", law, f"pi; {ELSE}")
    kp, ki_dt = np.asarray(parameters["law.gains"])[:2]
    kp, ki = (float(f"{gain:.{DIGITS}g}") for gain in (kp, ki_dt * rate_hz))
    return PiController(kp=kp, ki=ki, rate_hz=rate_hz, model=Model(nominal_n=parameters["law.high_n"]))


def tuned_words(base: System | PiController, values: dict[str, Any]) -> dict[str, np.ndarray]:
    """Return the words by name of a controller with other values, of a System or as a device tells it."""
    if isinstance(base, System):
        tuned = base.evolve(values)
        firmware_words(tuned)  # also refuses what of the controller is not the firmware's, such as a rate
        return controller_words(tuned)
    for name in values:
        if name not in TOLD:
            raise FrictionloopError(f"{name}: accepted {', '.join(TOLD)}; {ELSE}", "NOT-CHECKED")
    controller: Any = bench().model_copy(update={"controller": base}).evolve(values).controller
    words = np.zeros(word_of("law.gains").words, np.int32)
    own = np.ravel(pi_gains(controller))
    words[: own.size] = own
    return {"law.gains": words}
