"""Which control laws an image has: the others' code is left out of it."""

from __future__ import annotations

from collections.abc import Sequence

from frictionloop.control.laws import LAWS, NUMBERED
from frictionloop.quantities import must_be
from frictionloop.quantities.schema import parameter_words

KINDS = tuple(law.kind for law in NUMBERED)
"""Of the laws that the firmware has, the first with number 1; a notch PI is a filtered PI."""


def law_bits(laws: Sequence[str] | None, table: Sequence[int]) -> int:
    """Return laws as a number whose bit k says that the law of number k is built in.

    Parameters
    ----------
    laws
        Kinds of controller; None for all.
    table
        The words in force at reset.

    Raises
    ------
    FrictionloopError
        For a kind that the firmware has not, and when the table's law is not among them.
    """
    if laws is None:
        return _bits(KINDS)
    own = table[parameter_words()["law.number"].first]
    accepted = [kind for kind, law in LAWS.items() if law.kind in KINDS]
    for kind in laws:
        if kind not in accepted:
            raise must_be("laws", kind, ", ".join(accepted), code="UNKNOWN-NAME")
    bits = _bits([LAWS[kind].kind for kind in laws])
    if not bits >> own & 1:
        name = KINDS[own - 1] if 0 < own <= len(KINDS) else f"number {own}"
        raise must_be("laws", ", ".join(laws), f"with {name}, which runs")
    return bits


def law_names(bits: int) -> tuple[str, ...]:
    """Return the kinds of the laws that a device tells that it has."""
    return tuple(kind for number, kind in enumerate(KINDS, 1) if bits >> number & 1)


def _bits(kinds: Sequence[str]) -> int:
    return sum(1 << 1 + KINDS.index(kind) for kind in set(kinds))
