"""What of an effect will not arrive, and why: beyond reach, steeper than the skin follows, too weak to be felt."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from frictionloop.loop.companion_runs import weighted
from frictionloop.parameters import Strokes, System
from frictionloop.physics.reach import Reach
from frictionloop.preview.effect_preview import Preview, preview
from frictionloop.preview.pattern_measures import FELT_S
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.studio.connections import why_of
from frictionloop.studio.effect_pictures import HEIGHT_MM, depends_on_y, force_over
from frictionloop.studio.parameter_panels import effect_name

BEYOND, STEEP, WEAK = 1, 2, 4
"""Reasons, one bit each."""
SLACK_N = 5e-3
"""By how much a force may miss the band and still count as within (assumed: a tenth of what is felt as a step)."""
FINE = 10
"""Places of a stretch at which its slope is looked at."""
ROW_MM = 1.0
"""Distance of the lines that are looked at on a plate on which y matters (assumed)."""
RATE_HZ = 2500.0
"""Samples a second of a stroke whose pattern is felt: five times the fastest that touch knows."""
AROUND_MM = 4.0
"""Where the wish changes by less than the slack over this way, nothing is there to be felt (assumed)."""
SECONDS, MARGIN_MM, LEAST_MM = 4.0, 15.0, 40.0
"""The stroke that is tried: what the finger crosses in 4 s, within the plate, at least 40 mm (assumed)."""


def previewed(system: System, speed_mm_s: float, load_n: float) -> dict[str, Any]:
    """Return the message on what of a System's effect will not arrive, with what it is ``of``."""
    told: dict[str, Any] = {"type": "reach", "of": (system, speed_mm_s, load_n), "why": "", "reasons": []}
    try:
        shown = stroked(system, speed_mm_s, load_n)
        assert isinstance(shown.setpoint, EffectSource)
        return told | reasons_of(preview(effect_name(shown) or shown.setpoint.effect, shown))
    except Exception as error:  # what looks ahead must not take the session with it, whatever it died of
        return told | {"why": why_of(error)}


def stroked(system: System, speed_mm_s: float, load_n: float) -> System:
    """Return the System with the stroke that is tried."""
    if not isinstance(system.setpoint, EffectSource) or not isinstance(system.motion, Strokes):
        raise FrictionloopError("setpoint.kind: must be effect")
    room = system.touch.load.length_mm - MARGIN_MM
    stroke = max(min(room, SECONDS * speed_mm_s), LEAST_MM)
    reversal = min(system.motion.reversal_s, 0.5 * stroke / speed_mm_s)
    values = {"speed_mm_s": speed_mm_s, "stroke_mm": stroke, "reversal_s": reversal, "load_n": load_n}
    return system.evolve({f"motion.{name}": value for name, value in values.items()})


def reasons_of(seen: Preview) -> dict[str, Any]:
    """Return the reasons over the plate, rows over x, the lowest first, and the share of the places for each reason.

    Where y does not matter there is one row, else one for each `ROW_MM`. What the finger reaches and what arrives of
    the contrast is that of the stroke that was tried.
    """
    source, place = seen.system.setpoint, seen.place_mm
    assert isinstance(source, EffectSource)
    rows_mm, step_mm = lines_mm(source), float(place[1] - place[0])
    force = force_over(source, place, rows_mm)
    known = np.isfinite(seen.low_n) & np.isfinite(seen.high_n)
    beyond = known & Reach(seen.low_n, seen.high_n).beyond(force, SLACK_N)
    fine, along, slope = steepest(source, place, rows_mm)
    steep = slope > seen.skin_n_mm
    around = round(AROUND_MM / step_mm)
    varies = maximum_filter1d(force, around) - minimum_filter1d(force, around) > SLACK_N
    contrast = seen.closed_loop.contrast if math.isfinite(seen.closed_loop.contrast) else 1.0
    weak = (contrast * _felt(fine, along, seen.speed_mm_s, place) < 1.0) & varies
    told = {
        "from_mm": float(place[0]),
        "step_mm": step_mm,
        "reasons": (BEYOND * beyond + STEEP * steep + WEAK * weak).tolist(),
    }
    told |= {"bottom_mm": float(rows_mm[0]), "row_mm": ROW_MM}
    shares = {name: float(np.mean(where)) for name, where in (("beyond", beyond), ("steep", steep), ("weak", weak))}
    return told | {"shares": shares, "arrives": f"{seen.rows()[0][1]}: {' '.join(seen.arriving)}"}


def steepest(source: EffectSource, place_mm: np.ndarray, rows_mm: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return places between evenly spaced ones, the force along them, N, and the largest slope around each, N/mm."""
    step_mm = float(place_mm[1] - place_mm[0])
    fine = np.linspace(place_mm[0] - 0.5 * step_mm, place_mm[-1] + 0.5 * step_mm, FINE * place_mm.size + 1)
    along = force_over(source, fine, rows_mm)
    slope = np.abs(np.diff(along, axis=1)) / (fine[1] - fine[0])
    return fine, along, slope.reshape(len(rows_mm), place_mm.size, FINE).max(axis=2)


def lines_mm(source: EffectSource) -> np.ndarray:
    """Return the heights that are looked at, mm: the line of the stroke alone where another one asks for the same."""
    rows = np.arange(0.5 * (ROW_MM - HEIGHT_MM), 0.5 * HEIGHT_MM, ROW_MM)
    return rows if any(depends_on_y(source, each) for each in rows) else np.array([source.track.y_mm])


def _felt(fine_mm: np.ndarray, along_n: np.ndarray, speed_mm_s: float, place_mm: np.ndarray) -> np.ndarray:
    """Return what is felt of forces along x at a speed, in thresholds of touch: rms over 50 ms and both ways."""
    count = round((fine_mm[-1] - fine_mm[0]) / speed_mm_s * RATE_HZ)
    path = np.linspace(fine_mm[0], fine_mm[-1], count)
    force = np.array([np.interp(path, fine_mm, row) for row in along_n])
    force -= force.mean(axis=1, keepdims=True)
    both, counts = np.stack((force, force[:, ::-1])), np.ones(count)  # copied: a row is filtered as it lies there
    ways = np.array([[weighted(row, counts, RATE_HZ) for row in way] for way in both]) ** 2
    power = uniform_filter1d(0.5 * (ways[0] + ways[1][:, ::-1]), round(FELT_S * RATE_HZ))
    return np.asarray(np.sqrt(np.maximum(power, 0.0))[:, np.searchsorted(path, place_mm)])
