"""Write an effect as MPEG haptics (hjif); how places and forces are told is said in `rendering.hjif`."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from frictionloop.quantities import FrictionloopError, replacing
from frictionloop.rendering.effect import Effect
from frictionloop.rendering.hjif import MODALITY, PITCH_MM
from frictionloop.rendering.images import rasterise
from frictionloop.rendering.shapes import Constant, Grating
from frictionloop.rendering.tables import Map

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
        raise FrictionloopError(f"effect.kind = {effect.kind!r}: must be map of one row, grating or constant")
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
