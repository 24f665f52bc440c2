"""Effects: from a picture, a recording or a formula to a force under the finger.

>>> import frictionloop as fl
>>> grating = fl.rendering.Grating(spacing_mm=2.0, amplitude_n=0.15)
>>> system = fl.bench().evolve(setpoint={"kind": "effect", "effect": grating})

What they are made of   Map  Wave  Trigger  sampled  Touch  Track
Patterns                Constant  Gradient  Edge  Grating  Chirp  Ridge  Detents  Texture  Dots  Viscous
Mixing                  a + b  a * b  a.max(b)  mask  at  rotate  scale  repeat  Directed  Relief
By name, in files       LIBRARY  find  read_effect  write_effect
From and to files       read_image  write_image  read_texture  read_wave  write_wave  fit_texture  read_hjif  write_hjif
                        read_envelope  text_map  rasterise  write
                        import_effect
Run them                EffectSource  Player  effects  check  preview  play  people  arrivals
"""

from __future__ import annotations

import importlib
from typing import Any

_HOME = {
    "preview": "Check Played Preview arrivals check people play preview",
    "rendering.composing": "At Directed Largest Mask Product Relief Repeat Rotate Scale Sum Trigger",
    "rendering.effect": "EFFECTS Effect Touch Track",
    "rendering.effect_toml": "find read_effect to_toml write_effect",
    "rendering.foreign_files": "ImportedEffect import_effect write",
    "rendering.hjif": "read_hjif write_hjif",
    "rendering.images": "Picture rasterise read_image text_map write_image",
    "rendering.library": "Effects LIBRARY effects",
    "rendering.player": "Player program_of",
    "rendering.program": "Program",
    "rendering.recorded": "Resynthesis fit_texture read_envelope read_texture read_wave write_wave",
    "rendering.shapes": "Chirp Constant Detents Dots Edge Gradient Grating Ridge Texture Viscous",
    "rendering.source": "EffectSource",
    "rendering.tables": "Map Sampled Wave sampled",
}
_ROOM_OF = {name: f"frictionloop.{room}" for room, names in _HOME.items() for name in names.split()}


def __getattr__(name: str) -> Any:
    """Import a name when it is first used; those that need the loop live above it."""
    if name not in _ROOM_OF:
        raise AttributeError(f"module 'frictionloop.rendering' has no attribute {name!r}")
    value = getattr(importlib.import_module(_ROOM_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    """Return the public names."""
    return sorted(_ROOM_OF)
