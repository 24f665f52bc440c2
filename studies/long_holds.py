"""Does a limit observer ring in ten minutes without a lift? Beside itself begun anew, and beside the open loop.

``python -m studies.long_holds 30 600`` strokes 30 fingers for 600 s, with the same noise each time: held at 0.6 N; held
by a law that begins anew every `PIECE_S` (it has no history, the finger has); after 24 s of random steps in every
half-minute; and in open loop. It writes *results/long-holds.csv* and draws the loudest windows in
*runs/long-holds.png*. What rings has a line: the last columns are the share of 100 to 400 Hz within 10 Hz of the
strongest line there, the largest of the ten loudest windows.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import periodogram

from frictionloop.control.laws import law_of
from frictionloop.design.comparison import protocol
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import LANES, law_rows
from frictionloop.loop.kernel.traces import traces_of
from frictionloop.parameters import Steps, System, bench
from frictionloop.physics.fingers import fingers
from studies.conditions import LENGTHS_UM, limit_observer
from studies.histories import BAND_HZ, CONSTANT, FLOOR_N, FRESH_SEED, LEVEL_N, WINDOW_S, Ringing, draw, windows
from studies.kept import keep

PIECE_S, ROUND_S, STEPS_S, SETTLED_S = 10.0, 30.0, 24.0, 1.0
NEAR_HZ, PADDED = 10.0, 8
HEADS = [
    *("mm/s, um", "fingers", "held, over a law begun anew", "after steps, over held", "loudest, mN"),
    *("open loop there", "line, held", "line, open"),
]
PICTURE = Path(__file__).parent / "runs" / "long-holds.png"


def forces(system: System, people: Sequence[dict[str, Any]], duration_s: float, anew: bool = False) -> np.ndarray:
    """Return f_a of each finger, N; of a law that goes back to its start in every piece, if it begins anew."""
    systems = [system.evolve(each) for each in people]
    names, piece = traces_of(system), round(PIECE_S * system.controller.rate_hz)
    traces, found = np.empty((len(names), piece, LANES)), []
    tile, law = lower(systems, [1] * len(systems), traces=traces.reshape(-1)), law_of(system.controller)
    for start in range(0, round(duration_s * system.controller.rate_hz), piece):
        stop = start + piece
        if anew and start > 0:
            tile.slab.view(law_rows(law)[0])[:] = np.array(law.start_for(system.controller))[:, None]
        tile.shared.set(trace=traces.ctypes.data - 8 * LANES * start)  # rows are counted from t = 0
        tile.advance(start, stop, tile.setpoint(start, stop), tile.disturbance(start, stop), start)
        found.append(traces[names.index("f_a"), :, : len(people)].T.astype(np.float32))
    return np.concatenate(found, axis=1)


def steps(duration_s: float, seed: int = 7) -> Steps:
    """Return random steps, 20 to 500 ms apart, in the first `STEPS_S` of every `ROUND_S`, and the hold between."""
    draw, times, levels = np.random.default_rng(seed), [0.0], []
    for begin in np.arange(0.0, duration_s, ROUND_S).tolist():
        while times[-1] < begin + STEPS_S:
            levels.append(float(draw.uniform(0.35, 0.8)))
            times.append(round(times[-1] + float(np.exp(draw.uniform(np.log(0.02), np.log(0.5)))), 4))
        times[-1] = begin + STEPS_S
        levels.append(LEVEL_N)
        times.append(begin + ROUND_S)
    return Steps(times_s=tuple(times[:-1]), levels_n=tuple(levels))


def line(force: np.ndarray, rate_hz: float) -> float:
    """Return the share of `BAND_HZ` that is within `NEAR_HZ` of the strongest line: of white noise a tenth."""
    hz, power = periodogram(force, rate_hz, "hann", PADDED * force.size)
    inside = (hz >= BAND_HZ[0]) & (hz <= BAND_HZ[1])
    strongest = hz[inside][np.argmax(power[inside])]
    return float(power[inside & (abs(hz - strongest) <= NEAR_HZ)].sum() / power[inside].sum())


def rows(people: int, duration_s: float, shown: list[Ringing]) -> Iterator[list[Any]]:
    """Yield the rows of the table; ``shown`` gets the loudest windows, held and in open loop."""
    for speed, z in product((20.0, 80.0), LENGTHS_UM):
        stroke = {"motion.speed_mm_s": speed, "finger.slip_length_um": z, "motion.stroke_mm": 240.0}
        system = bench().evolve({**stroke, "setpoint": CONSTANT, **limit_observer(z)})
        drawn, rate = protocol.without_lengths(fingers(5 * people, FRESH_SEED)), system.controller.rate_hz
        able = [drawn[i] for i in protocol.able(system, drawn, speed).nonzero()[0][: min(people, LANES)]]
        held = forces(system, able, duration_s)
        stepped = forces(system.evolve({"setpoint": steps(duration_s)}), able, duration_s)
        quiet = loud(held, rate)
        # After a turn the skin slips some tenths of a second earlier or later: the window before counts as well.
        there = np.maximum(quiet, np.roll(quiet, 1, axis=1))
        after = loud(stepped, rate) / np.maximum(2.0 * there, FLOOR_N)
        times = np.arange(quiet.shape[1]) * WINDOW_S
        after = after[:, times % ROUND_S >= STEPS_S].max()
        over = quiet / np.maximum(2.0 * loud(forces(system, able, duration_s, anew=True), rate), FLOOR_N)
        over = over[:, times % PIECE_S >= SETTLED_S].max()
        free = forces(system.evolve({"controller.kind": "lookup"}), able, duration_s)
        worst = [divmod(int(k), quiet.shape[1]) for k in np.argsort(-quiet, axis=None)[:10]]
        here = [slice(k * round(WINDOW_S * rate), (k + 1) * round(WINDOW_S * rate)) for _, k in worst]
        pairs = [[each[i, part] for each in (held, free)] for (i, _), part in zip(worst, here, strict=True)]
        shown += [
            Ringing(float(quiet[i, k]), float(quiet[i, k]), 0, {**able[i], **stroke}, *pair)
            for (i, k), pair in zip(worst, pairs, strict=True)
        ]
        lines = [max(line(pair[which], rate) for pair in pairs) for which in (0, 1)]
        i, k = worst[0]
        levels = 1e3 * quiet[i, k], 1e3 * loud(free[i : i + 1], rate)[0, k]
        yield [
            f"{speed:g} mm/s, {z:g} um", len(able), f"{over:.2f}", f"{after:.2f}",
            *(f"{level:.0f}" for level in levels), *(f"{each:.2f}" for each in lines),
        ]  # fmt: skip


def loud(force: np.ndarray, rate_hz: float) -> np.ndarray:
    """Return the rms of each finger's windows, N."""
    return np.array([windows(each.astype(float), rate_hz) for each in force])


def main(people: int = 30, duration_s: int = 600) -> None:
    """Write the table, and draw the loudest ten of all."""
    shown: list[Ringing] = []
    keep("long-holds", f"long_holds {people} {duration_s}", HEADS, rows(people, duration_s, shown))
    draw(sorted(shown, key=lambda each: -each.rms_n)[:10], PICTURE, ("held", "open loop"))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
