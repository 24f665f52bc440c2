"""Loops and fingers by name, one press each; what a preset does not name stays as it is."""

from __future__ import annotations

from typing import Any, NamedTuple

from frictionloop.parameters.presets import RETUNED


class Preset(NamedTuple):
    """What a button puts in force."""

    name: str
    told: str
    values: dict[str, Any]


LAW = {"controller.kind": "notch_pi", "controller.feedforward": True}
PRESETS = (
    Preset("Recommended law", "A PI controller with a notch at the suspension and the wish fed forward.", LAW),
    Preset("Paper's gains", "The PI controller of the paper, kp 10 and ki 2: on this bench it rings.", {
        "controller.kind": "pi", "controller.kp": 10.0, "controller.ki": 2.0}),
    Preset("Gains that hold", "The same PI controller with gains retuned for this bench.", {
        "controller.kind": "pi", **RETUNED}),
    Preset("Usual finger", "A finger whose friction is what the controller believes: 0.95 N.", {
        "friction.nominal_n": 0.95}),
    Preset("Sticky finger", "A finger with more friction than the controller believes: 1.3 N.", {
        "friction.nominal_n": 1.3}),
    Preset("Slippery finger", "A finger with too little friction for most wishes: 0.35 N.", {
        "friction.nominal_n": 0.35}),
    Preset("Weak plate", "A plate that vibrates by no more than half of what the paper's does.", {
        "plate.max_amplitude_um": 1.2}),
    Preset("Full plate", "A plate that vibrates by up to 2.5 um, as the paper's does.", {
        "plate.max_amplitude_um": 2.5}),
)  # fmt: skip
BY_NAME = {each.name: each for each in PRESETS}
