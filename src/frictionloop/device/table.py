"""The parameter table of a device: read, written into the copy that waits, put in force."""

from __future__ import annotations

import zlib
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from frictionloop.device.errors import DeviceError, Refused
from frictionloop.device.link import Link
from frictionloop.device.refusals import in_words
from frictionloop.firmware.words import from_words, to_words, word_of
from frictionloop.quantities.schema import Word, parameter_words, schema, table_hash, word_count

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
            raise DeviceError(f"table = {table.size} words: must be {word_count()}", "BAD-VALUE")
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
