"""Numbers of the last seconds, as the page shows them: error, R2, contrast, saturation."""

from __future__ import annotations

import math

import numpy as np

from frictionloop.live.live_engines import CHANNELS
from frictionloop.physics.reach import Reach
from frictionloop.rendering.effect import TURNS_MM_S

WINDOW_S = 2.0
"""How far back they look (assumed: four strokes of 20 mm at 40 mm/s)."""
LEAST_S = 0.2
"""Time on the plate below which nothing is said."""
TURNED_MM = 2.0
"""Way before and after a turn or a landing: 2F/k of 1 N over the 1000 N/m of the bench's skin, as metrics leave out."""
OVER_S = 0.004
"""Over how long the way is taken that tells the speed (assumed)."""
_ROW = {name: number for number, name in enumerate(CHANNELS)}


def numbers_of(rows: np.ndarray, rate_hz: float, touches_n: float) -> dict[str, float | None]:
    """Return rms error (N), R2 against identity, contrast delivered and share of saturated ticks.

    Each but the last is told of the open and of the closed loop. Contrast is `slope_of` the force over that asked for:
    1 delivers all of it. Ticks count while the finger slides, but for `TURNED_MM` on both sides of a turn: the skin
    swings over meanwhile. A number that does not exist is None: R2 and contrast where the force asked for does not
    change. ``beyond`` is the share of the wish that is out of the finger's reach. ``swings`` is the share of ticks at
    the limit that is visited less, of most and of least vibration: a loop that rings is at both.

    Parameters
    ----------
    rows : array, shape (channels, ticks)
        `CHANNELS` of the session.
    rate_hz : float
        Ticks per second.
    touches_n : float
        Least load that counts as touch, N.
    """
    from frictionloop.preview.pattern_measures import slope_of  # only here: it loads slowly (`studio.background`)

    sliding = slides(rows[_ROW["x_mm"]].astype(float), rows[_ROW["load_n"]], rate_hz, touches_n)
    if sliding.sum() < LEAST_S * rate_hz:
        return {}
    asked = rows[_ROW["asked_n"]].astype(float)
    beyond = Reach(rows[_ROW["floor_n"]], rows[_ROW["limit_n"]]).beyond(asked)
    told: dict[str, float | None] = {
        "saturated": float(np.mean(rows[_ROW["saturated"], sliding])),
        "beyond": float(np.mean(beyond[sliding])),
        "swings": _at_both_limits(rows[:, sliding]),
    }
    for name in ("open", "closed"):
        force = _force(rows, name)
        counted = sliding & np.isfinite(force - asked)
        if counted.sum() < LEAST_S * rate_hz:
            continue
        rms = math.sqrt(float(np.mean((force - asked)[counted] ** 2)))
        slope, spread = slope_of(asked, force, counted, rate_hz)[0], float(np.std(asked[counted]))
        told |= {
            f"{name}_error_n": rms,
            f"{name}_r2": 1.0 - (rms / spread) ** 2 if math.isfinite(slope) else None,
            f"{name}_contrast": slope if math.isfinite(slope) else None,
        }
    return told


def _force(rows: np.ndarray, name: str) -> np.ndarray:
    """Return the force of a loop, N: of a device that measures it alone the measured one, while that loop runs."""
    force = rows[_ROW[f"{name}_n"]].astype(float)
    runs = np.isfinite(rows[_ROW[f"{name}_um"]])
    return np.where(np.isfinite(force), force, np.where(runs, rows[_ROW["measured_n"]], np.nan))


def _at_both_limits(rows: np.ndarray) -> float:
    """Return the share of ticks at the limit of most or of least vibration, whichever is less."""
    limited, strong = rows[_ROW["saturated"]] > 0, rows[_ROW["closed_um"]]
    high = strong > 0.5 * np.max(strong, initial=0.0, where=np.isfinite(strong))
    return float(min(np.mean(limited & high), np.mean(limited & ~high)))


def slides(x_mm: np.ndarray, load_n: np.ndarray, rate_hz: float, touches_n: float) -> np.ndarray:
    """Return in which ticks the finger slides, further than `TURNED_MM` from a turn, a landing or a lift.

    The next turn is known only when it has come: the newest ticks count until then.

    Parameters
    ----------
    x_mm, load_n : array, shape (ticks,)
        Place and load of the finger.
    rate_hz : float
        Ticks per second.
    touches_n : float
        Least load that counts as touch, N.
    """
    if x_mm.size < 2:
        return np.zeros(x_mm.size, bool)
    # A sensor tells its place in steps of 10 um, which a finger of 40 mm/s takes in two ticks of 5 kHz.
    ahead = np.arange(x_mm.size) + max(round(OVER_S * rate_hz / 2), 1)
    span = np.minimum(ahead, x_mm.size - 1), np.maximum(2 * np.arange(x_mm.size) - ahead, 0)
    speed_mm_s = (x_mm[span[0]] - x_mm[span[1]]) / (span[0] - span[1]) * rate_hz
    moves = (load_n >= touches_n) & (np.abs(speed_mm_s) > TURNS_MM_S)
    ticks = np.arange(x_mm.size)
    # A finger at rest still leans where it went last; one in the air leans nowhere.
    told = moves | (load_n < touches_n)
    last = np.maximum.accumulate(np.where(told, ticks, 0))
    way = np.where(moves, np.sign(speed_mm_s), 0.0)[last]
    begins = np.concatenate([[0], 1 + np.flatnonzero(np.diff(way)), [x_mm.size]])
    stroke = np.searchsorted(begins, ticks, side="right")
    far = np.abs(x_mm - x_mm[begins[stroke - 1]]) >= TURNED_MM
    ends = begins[stroke]
    far &= (ends == x_mm.size) | (np.abs(x_mm - x_mm[np.minimum(ends, x_mm.size - 1)]) >= TURNED_MM)
    return np.asarray(moves & far)
