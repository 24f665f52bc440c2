"""Envelopes of vibration effects as waves of force: ``.haptic`` (Meta, Lofelt) and AHAP (Apple)."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.tables import MOST_CELLS, Wave

TRANSIENT_S = 0.01
"""Duration of a transient, which AHAP leaves to the actuator (assumed)."""


class Carried(NamedTuple):
    """What a file gave, and what of it could not be carried over."""

    wave: Wave
    left: tuple[str, ...]


def read_envelope(path: str | os.PathLike[str], full_n: float, rate_hz: float = 1000.0) -> Carried:
    """Return the envelope of amplitude of a vibration effect as a wave of force.

    Parameters
    ----------
    path : path
        ``.haptic`` or ``.ahap``.
    full_n : float
        Force that the full amplitude stands for, N.
    rate_hz : float
        Values per second of the wave.

    Raises
    ------
    FrictionloopError
        For a file that cannot be read, or that has no envelope.
    """
    tree = read_json(path)
    kind = Path(path).suffix.lower()
    if kind not in (".haptic", ".ahap"):
        raise FrictionloopError(f"{path}: format {kind!r} is unknown; accepted: .haptic .ahap")
    try:
        times, levels, left = (_of_haptic if kind == ".haptic" else _of_ahap)(tree)
    except (KeyError, TypeError, ValueError, IndexError) as error:
        raise FrictionloopError(f"{path}: is no {kind} file ({type(error).__name__}: {error})") from None
    if len(times) < 2 or times[-1] <= 0:
        raise FrictionloopError(f"{path}: has no envelope")
    count = int(np.ceil(times[-1] * rate_hz)) + 1
    if count > MOST_CELLS:
        raise FrictionloopError(f"{path}: lasts {times[-1]:g} s; at most {MOST_CELLS / rate_hz:g} s at {rate_hz:g} Hz")
    values = full_n * np.interp(np.arange(max(count, 2)) / rate_hz, times, levels)
    return Carried(Wave(values_n=values.tolist(), rate_hz=rate_hz), tuple(left))


def read_json(path: str | os.PathLike[str]) -> Any:
    """Return what a JSON file holds."""
    try:
        return json.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise FrictionloopError(f"{path}: cannot be read ({getattr(error, 'strerror', None) or error})") from None
    except (json.JSONDecodeError, RecursionError) as error:
        raise FrictionloopError(f"{path}: is not JSON ({error})") from None


def _of_haptic(tree: Any) -> tuple[list[float], list[float], list[str]]:
    envelopes = tree["signals"]["continuous"]["envelopes"]
    points = envelopes["amplitude"]
    left = ["frequency envelope"] if envelopes.get("frequency") else []
    left += ["emphasis"] if any("emphasis" in point for point in points) else []
    return [float(each["time"]) for each in points], [float(each["amplitude"]) for each in points], left


def _of_ahap(tree: Any) -> tuple[list[float], list[float], list[str]]:
    pieces: list[tuple[float, float, float]] = []
    left: set[str] = set()
    curves: list[tuple[float, float]] = []
    for entry in tree["Pattern"]:
        if "ParameterCurve" in entry:
            curve = entry["ParameterCurve"]
            if curve["ParameterID"] != "HapticIntensityControl":
                left.add(curve["ParameterID"])
                continue
            start = float(curve["Time"])
            curves += [
                (start + float(p["Time"]), float(p["ParameterValue"])) for p in curve["ParameterCurveControlPoints"]
            ]
            continue
        event = entry.get("Event")
        if event is None or event["EventType"] not in ("HapticTransient", "HapticContinuous"):
            left.add(next(iter(entry)) if event is None else event["EventType"])
            continue
        given = {each["ParameterID"]: float(each["ParameterValue"]) for each in event.get("EventParameters", ())}
        left |= given.keys() - {"HapticIntensity"}
        start = float(event["Time"])
        lasts = float(event["EventDuration"]) if event["EventType"] == "HapticContinuous" else TRANSIENT_S
        pieces.append((start, start + lasts, given.get("HapticIntensity", 1.0)))
    edges = sorted({0.0, *(edge for piece in pieces for edge in piece[:2])})
    times = [each for edge in edges for each in (edge, edge + 1e-6)]
    times = sorted({*times, *(time for time, _ in curves)})
    levels = [max((level for start, stop, level in pieces if start < time <= stop), default=0.0) for time in times]
    if curves:
        known, factors = zip(*sorted(curves), strict=True)
        levels = [level * float(np.interp(time, known, factors)) for time, level in zip(times, levels, strict=True)]
    return times, levels, sorted(left)
