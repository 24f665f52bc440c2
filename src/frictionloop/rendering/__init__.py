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

from frictionloop.quantities.optional_libraries import lazily

HOMES = {
    ".preview": "Check Played Preview arrivals check people play preview",
    "effect_composition": "At Directed Largest Mask Product Relief Repeat Rotate Scale Sum Trigger",
    "effect": "EFFECTS Effect Touch Track",
    "effect_toml": "find read_effect to_toml write_effect",
    "foreign_files": "ImportedEffect import_effect write",
    "hjif": "read_hjif write_hjif",
    "images": "Picture rasterise read_image text_map write_image",
    "library": "Effects LIBRARY effects",
    "effect_player": "Player program_of",
    "effect_program": "Program",
    "effects_from_recordings": "Resynthesis fit_texture read_envelope read_texture read_wave write_wave",
    "shapes": "Chirp Constant Detents Dots Edge Gradient Grating Ridge Texture Viscous",
    "effect_setpoint": "EffectSource",
    "force_tables": "Map Sampled Wave sampled",
}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
