"""How often hits are counted right, and the resonance behind them is found and its interval holds it.

``python -m studies.hammer_hits 200`` reads so many synthetic hammer files (tests/helpers/hammer_files, which knows
nothing of the package): 2 to 8 modes that beat, rebounds, small taps, 2 to 61 blows.
"""

from __future__ import annotations

import sys
from multiprocessing import Pool
from typing import Any

import numpy as np

from frictionloop.identification import modes, pick_hits
from frictionloop.identification.estimate import measured
from frictionloop.quantities import FrictionloopError
from studies.kept import keep
from tests.helpers.hammer_files import hammer_file

ASKED = (
    ("count right", ">= 98"),
    ("resonance within 0.2 %", ">= 95"),
    ("Q within 5 %", ">= 95"),
    ("resonance inside its interval, where there is one", "93 to 97"),
    ("Q inside its interval, where there is one", "93 to 97"),
)


def judged(seed: int) -> tuple[list[bool], list[Any]]:
    """Return which goals a file meets, and its row; a refusal has no interval and meets none but the count."""
    file = hammer_file(seed)
    recording = file.recording()
    count = len(pick_hits(recording).table)
    try:
        found = modes(recording, "strongest")
    except FrictionloopError:
        return [count == file.hits] + 4 * [False], [seed, file.hits, count, f"{file.hertz:.2f}", "refused"]
    k = found.chosen[0]
    values = [
        measured("", [each], [method], "")
        for each, method in (
            (found.modes[k].frequency, found.method_hz[k]),
            (found.modes[k].q, found.method_q[k]),
        )
    ]
    true, near = (file.hertz, file.q), (2e-3, 0.05)
    right = [abs(each.value / one - 1) < most for each, one, most in zip(values, true, near, strict=True)]
    inside = [each.interval().low < one < each.interval().high for each, one in zip(values, true, strict=True)]
    row: list[Any] = [seed, file.hits, count]
    for each, one in zip(values, true, strict=True):
        row += [f"{one:.6g}", f"{each.value:.6g}", f"{each.interval().high - each.value:.2g}"]
    return [count == file.hits, *right, *inside], row


def main(count: int = 200) -> None:
    """Write the table, and what each goal is met by."""
    with Pool(2) as pool:
        every = list(pool.imap(judged, range(count)))
    answered = [met for met, row in every if row[-1] != "refused"]
    shares = 100 * np.mean([met for met, _ in every], axis=0)
    shares[3:] = 100 * np.mean([met[3:] for met in answered], axis=0)
    keep(
        "hammer-hits",
        f"hammer_hits {count}",
        ("of every 100 files", "asked", "found"),
        [(name, asked, f"{share:.1f}") for (name, asked), share in zip(ASKED, shares, strict=True)],
    )
    for met, row in every:
        if not all(met):
            print(row, met)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
