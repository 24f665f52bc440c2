"""For how many people of a population a set-point can be rendered: the answer, and the table that it stands in."""

from __future__ import annotations

from typing import Any

import numpy as np

from frictionloop.cli import screen
from frictionloop.cli.population_reach import Reach
from frictionloop.cli.scores import between

LATER = "--duration-s 60 --score-from-s 40"
"""Flags of a run that is scored once contact upon contact has made a finger moist, as the assumed one is by then."""
LONG_S = 40.0
"""On the plate in a run from when on nobody is pointed to these flags (chosen)."""


def lines(reach: Reach, total: int) -> list[Any]:
    """Return the answer for ordinary use, and a table of who is able under a steady load and as it moves.

    Ordinary use is the strictest of the four: the load drifts and trembles, and fingers that lift are as moist as
    contact upon contact leaves them.
    """
    times = f"{reach.contacts} contacts of " if reach.contacts > 1 else ""
    rows = [
        ("of these fingers are able", "steady load", "load moves", ""),
        (f"in {times}{reach.contact_s:g} s on the plate", _count(reach.able), _count(reach.moving), ""),
    ]
    lifts = ""
    moist = "; they never lift: --motion.contact_s 10, say, counts them contact upon contact as well"
    if reach.in_the_end is not None and reach.moving_in_the_end is not None:
        whole = f" of {reach.whole_s:g} s" * (reach.whole_s > reach.contact_s)
        rows.append((f"after many more contacts{whole}", _count(reach.in_the_end), _count(reach.moving_in_the_end), ""))
        lifts = ", contact upon contact"
        moist = "; fingers get moister contact upon contact, a longer --motion.lifted_s dries them"
        if reach.contacts * reach.contact_s < LONG_S:
            moist += f". The errors above are those of this run, of fingers dry at first; later ones: {LATER}"
    low, high = _count(~reach.low), _count(~reach.high)
    return [
        screen.wrapped(
            f"{_count(reach.served)} of {total} fingers can be given the set-point, "
            f"{between(reach.low_n, reach.high_n)}, in ordinary use: as the load drifts and trembles, for 95 % of the "
            f"time{lifts}. Of all such fingers that makes {_share(reach.served, total)}, with 95 % confidence"
        ),
        screen.table(rows, whole=True),
        screen.wrapped(
            f"under a steady load in this run, {low} of {total} cannot get so low, {high} cannot get so high{moist}"
        ),
    ]


def _share(who: np.ndarray, total: int) -> str:
    """Return the interval of the share of all fingers of a population that a draw says (Wilson 1927)."""
    from scipy.stats import binomtest

    low, high = binomtest(int(np.sum(who)), total).proportion_ci(0.95, "wilson")
    return f"{100 * low:.0f} to {100 * high:.0f} %"


def _count(who: np.ndarray) -> str:
    return f"{int(np.sum(who))}"


def as_json(reach: Reach | None) -> dict[str, Any]:
    """Return for each finger whether it is able, by name; None where it is not known."""
    return {
        "asked_n": None if reach is None else [reach.low_n, reach.high_n],
        "capable": None if reach is None else reach.able,
        "capable_load_moves": None if reach is None else reach.moving,
        "served": None if reach is None else reach.served,
        "capable_in_the_end": None if reach is None else reach.in_the_end,
        "capable_in_the_end_load_moves": None if reach is None else reach.moving_in_the_end,
    }
