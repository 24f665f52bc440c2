"""MPEG haptics, ISO/IEC 23090-31, as JSON (hjif) with the modality Friction: an effect over place, in and out.

Positions are ways: integers times 10^``unit_exponent`` m. An amplitude of 1 is the gain of its channel times
10^``perception_unit_exponent`` N, and channels add, each by its mixing coefficient. Files of the reference software
have these names; that a friction's positions are ways is our reading of "spatial" modalities.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from frictionloop.quantities import FrictionloopError, must_be, replacing
from frictionloop.quantities.whole_files import json_of
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.force_tables import MOST_CELLS, Map
from frictionloop.rendering.images import rasterise
from frictionloop.rendering.shapes import Constant, Grating

MODALITY = "Friction"
TRANSIENT_MM = 0.5
"""Way of a transient, which the format leaves to the renderer (assumed)."""
PITCH_MM = 0.05
"""Distance from value to value of what is read (assumed)."""

READ = {
    "file": "version profile level date description timescale avatars perceptions",
    "perception": "id perception_modality description avatar_id unit_exponent perception_unit_exponent effect_library "
    "channels",
    "channel": "id description gain mixing_coefficient bands",
    "band": "band_type curve_type lower_frequency_limit upper_frequency_limit effects",
    "effect": "id effect_type position phase base_signal keyframes",
    "keyframe": "relative_position amplitude_modulation frequency_modulation",
}
"""What is read, or says nothing about a force, at each level of a file; whatever else has a value is listed as left."""
SIGNALS = ("Sine", "Square", "Triangle")


class Haptics(NamedTuple):
    """What a file gave, and what of it could not be carried over."""

    effect: Effect
    left: tuple[str, ...]


def read_hjif(path: str | os.PathLike[str]) -> Haptics:
    """Return the friction of an hjif file as an effect: its bands sampled, added, as one map.

    Parameters
    ----------
    path : path
        The file.

    Raises
    ------
    FrictionloopError
        For a file that is none, has no perception of friction, or uses what is not known.
    """
    tree = json_of(path)
    try:
        left: list[str] = []
        _unread("file", tree, left)
        found = [each for each in tree["perceptions"] if each["perception_modality"] == MODALITY]
        left += [
            f"perception of {each['perception_modality']}"
            for each in tree["perceptions"]
            if each["perception_modality"] != MODALITY
        ]
        if not found:
            raise FrictionloopError(
                f'{path}: has no perception of modality "{MODALITY}"; found: {", ".join(left) or "none"}'
            )
        pieces: list[tuple[float, np.ndarray]] = []
        for perception in found:
            pieces += _pieces(perception, left)
    except FrictionloopError:
        raise
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        raise FrictionloopError(f"{path}: is no hjif file ({type(error).__name__}: {error})") from None
    if not pieces:
        raise FrictionloopError(f"{path}: carries nothing over; left: {', '.join(left)}")
    start = min(first for first, _ in pieces)
    ends = [round((first - start) / PITCH_MM) + force.size for first, force in pieces]
    if max(ends) > MOST_CELLS:
        raise FrictionloopError(f"{path}: is {max(ends) * PITCH_MM:g} mm long; at most {MOST_CELLS * PITCH_MM:g} mm")
    values = np.zeros(max(*ends, 2))
    for (_, force), end in zip(pieces, ends, strict=True):
        values[end - force.size : end] += force
    return Haptics(Map(values_n=values.tolist(), pitch_mm=PITCH_MM, start_mm=start), tuple(dict.fromkeys(left)))


def _pieces(perception: Any, left: list[str]) -> Iterator[tuple[float, np.ndarray]]:
    """Yield where each effect of a perception begins, in mm, and its forces, `PITCH_MM` apart."""
    _unread("perception", perception, left)
    unit_mm = 1e3 * 10.0 ** perception.get("unit_exponent", -3)
    unit_n = 10.0 ** perception.get("perception_unit_exponent", 0)
    library = {each["id"]: each for each in perception.get("effect_library", ())}
    for channel in perception["channels"]:
        _unread("channel", channel, left)
        gain = float(channel["gain"]) * float(channel["mixing_coefficient"]) * unit_n
        for band in channel["bands"]:
            kind = band["band_type"]
            if kind not in ("Curve", "VectorialWave", "Transient"):
                left.append(f"{kind} band")
                continue
            _unread("band", band, left)
            for given in band["effects"]:
                effect = {**library.get(given.get("id"), {}), **given} if given["effect_type"] == "Reference" else given
                if given["effect_type"] not in ("Basis", "Reference") or not effect.get("keyframes"):
                    left.append(f"{given['effect_type']} effect")
                    continue
                _unread("effect", effect, left)
                for frame in effect["keyframes"]:
                    _unread("keyframe", frame, left)
                if kind == "VectorialWave" and (signal := effect.get("base_signal", "Sine")) not in SIGNALS:
                    left.append(f"{signal} signal")
                    continue
                if kind == "Curve" and band.get("curve_type", "Linear") != "Linear":
                    left.append(f"{band['curve_type']} curve (read as linear)")
                start_mm = float(effect["position"]) * unit_mm
                yield start_mm, gain * _sampled(kind, effect, unit_mm)


def _unread(level: str, given: Any, left: list[str]) -> None:
    """List what a level has and this module does not know."""
    known = READ[level].split()
    left += [f"{level}.{name}" for name, value in given.items() if name not in known and value not in EMPTY]


EMPTY: tuple[Any, ...] = (0, "", None, [], {})


def _sampled(kind: str, effect: Any, unit_mm: float) -> np.ndarray:
    frames = sorted(effect["keyframes"], key=lambda each: float(each.get("relative_position", 0)))
    at = [float(each.get("relative_position", 0)) * unit_mm for each in frames]
    levels = _points(frames, at, "amplitude_modulation")
    if kind == "Transient":
        force = np.zeros(round((max(at) + TRANSIENT_MM) / PITCH_MM) + 1)
        for place, level in levels:
            first, count = round(place / PITCH_MM), round(TRANSIENT_MM / PITCH_MM)
            force[first : first + count + 1] += level * np.sin(np.pi * np.arange(count + 1) / count)
        return force
    x = PITCH_MM * np.arange(round(max(at) / PITCH_MM) + 1)
    envelope = np.interp(x, *levels.T) if levels.size else np.ones(x.size)
    if kind == "Curve":
        return np.asarray(envelope)
    waves = _points(frames, at, "frequency_modulation")
    if not waves.size:
        raise ValueError("a vectorial wave needs a frequency_modulation")
    per_mm = 1e-3 * np.interp(x, *waves.T)
    turns = np.concatenate([[0.0], np.cumsum(0.5 * (per_mm[1:] + per_mm[:-1]) * PITCH_MM)])
    phase = float(effect.get("phase", 0.0)) / (2 * np.pi)
    turns = turns + phase - np.floor(turns + phase)
    shape = effect.get("base_signal", "Sine")
    if shape == "Sine":
        return np.asarray(envelope * np.sin(2 * np.pi * turns))
    if shape == "Square":
        return np.asarray(envelope * np.where(turns < 0.5, 1.0, -1.0))
    return np.asarray(envelope * (1.0 - 4.0 * np.abs(np.mod(turns + 0.25, 1.0) - 0.5)))


def _points(frames: Any, at: list[float], name: str) -> np.ndarray:
    """Return the places, in mm, and the values of one modulation of keyframes, shape (points, 2)."""
    return np.array([(place, float(frame[name])) for place, frame in zip(at, frames, strict=True) if name in frame])


UNIT_EXPONENT = -6
"""Positions are written in um."""


def write_hjif(effect: Effect, path: str | os.PathLike[str], length_mm: float = 100.0) -> tuple[str, ...]:
    """Write an effect of one dimension as hjif: a grating as a vectorial wave on a level, others as a curve.

    A frequency is a whole number per metre there: a grating whose spacing is not a metre over one becomes a curve.

    Parameters
    ----------
    effect : Effect
        A map of one row, a grating or a constant; ``rasterise`` makes a map of others.
    path : path
        The file.
    length_mm : float
        Length of what has no end.

    Returns
    -------
    tuple of str
        What could not be carried over, a line each.

    Raises
    ------
    FrictionloopError
        For another effect, or a file that cannot be written.
    """
    step = 1e-3  # mm per unit of position
    left = [f"no end: {length_mm:g} mm of it"] if effect.period_mm is not None else []
    if isinstance(effect, Map) and effect.beyond == "repeat":
        left = ["the map's repeats"]
    if isinstance(effect, Map) and effect.between == "nearest":
        left += ["steps of the map (read as linear)"]
    if isinstance(effect, Grating) and abs(1e3 / effect.spacing_mm - round(1e3 / effect.spacing_mm)) > 1e-6:
        effect = rasterise(effect, length_mm, 0.0, PITCH_MM)
    if isinstance(effect, Map) and len(effect.values_n) == 1:
        values = np.array(effect.values_n[0])
        gain = float(np.abs(values).max()) or 1.0
        place = np.round(np.arange(values.size) * effect.pitch_mm / step).astype(int).tolist()
        curve = _band("Curve", round(effect.start_mm / step), place, (values / gain).tolist())
        channels = [_channel(0, gain, curve)]
    elif isinstance(effect, Constant | Grating):
        level = effect.level_n if isinstance(effect, Constant) else effect.offset_n
        ends, start = [0, round(length_mm / step)], round(-0.5 * length_mm / step)
        channels = [_channel(0, abs(level) or 1.0, _band("Curve", start, ends, [float(np.sign(level))] * 2))]
        if isinstance(effect, Grating):
            per_m = round(1e3 / effect.spacing_mm)
            wave = _band("VectorialWave", start, ends, [1.0, 1.0], per_m, effect)
            channels.append(_channel(1, effect.amplitude_n, wave))
    else:
        raise must_be("effect.kind", effect.kind, "map of one row, grating or constant")
    perception = {
        "id": 0, "avatar_id": 0, "description": "friction over place", "perception_modality": MODALITY,
        "unit_exponent": UNIT_EXPONENT, "perception_unit_exponent": 0, "effect_library": [], "channels": channels,
    }  # fmt: skip
    tree = {
        "version": "2023", "profile": "Main", "level": 1, "date": "", "description": "frictionloop", "timescale": 1000,
        "avatars": [{"id": 0, "lod": 0, "type": "Vibration"}], "perceptions": [perception], "syncs": [],
    }  # fmt: skip
    with replacing(path) as beside:
        beside.write_text(json.dumps(tree, indent=1), encoding="utf-8")
    return tuple(left)


def _channel(number: int, gain: float, band: dict[str, Any]) -> dict[str, Any]:
    head = {"id": number, "description": "", "gain": gain, "mixing_coefficient": 1.0, "body_part_mask": 0}
    return {**head, "bands": [band]}


def _band(
    kind: str, start: int, places: list[int], levels: list[float], per_m: int = 0, grating: Grating | None = None
) -> dict[str, Any]:
    frames: list[dict[str, Any]] = [
        {"relative_position": place, "amplitude_modulation": level} for place, level in zip(places, levels, strict=True)
    ]
    for frame in frames if per_m else ():
        frame["frequency_modulation"] = per_m
    base, phase = "Sine", 0.0
    if grating is not None:
        base = grating.shape.capitalize()
        phase = float(2 * np.pi * np.mod(1e-3 * start / grating.spacing_mm, 1.0))
    basis = {"effect_type": "Basis", "position": start, "phase": phase, "base_signal": base, "keyframes": frames}
    more = {"curve_type": "Linear"} if kind == "Curve" else {}
    return {"band_type": kind, **more, "lower_frequency_limit": 0, "upper_frequency_limit": 1000, "effects": [basis]}
