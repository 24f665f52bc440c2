"""Names that a person gives out of those there are: the line that says which is wrong."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence

from frictionloop.quantities.units import FrictionloopError


def check_known(option: str, names: Iterable[str], there: Iterable[str]) -> None:
    """Refuse a name that is none of those there are, with near ones."""
    known = list(there)
    for name in names:
        if name not in known:
            near = difflib.get_close_matches(name, known, n=3, cutoff=0.4)
            hint = f"; did you mean {' or '.join(near)}?" if near else ";"
            raise FrictionloopError(f"{option}: {name!r} is unknown{hint} accepted: {', '.join(known)}")


def check_each_once(option: str, what: str, names: Sequence[str]) -> None:
    """Refuse no name at all, or one given twice; ``what`` they name is in the line."""
    if not names or len(set(names)) < len(names):
        raise FrictionloopError(f"{option} = {','.join(names)!r}: must name at least one {what}, none of them twice")
