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
    Preset("Recommended law", "PI with notch and feed-forward.", LAW),
    Preset("Paper's gains", "The printed gains: it rings.", {
        "controller.kind": "pi", "controller.kp": 10.0, "controller.ki": 2.0}),
    Preset("Gains that hold", "PI retuned for this bench.", {
        "controller.kind": "pi", **RETUNED}),
    Preset("Usual finger", "0.95 N, as the controller believes.", {
        "friction.nominal_n": 0.95}),
    Preset("Sticky finger", "1.3 N, the controller believes 0.95.", {
        "friction.nominal_n": 1.3}),
    Preset("Slippery finger", "0.35 N, little for most wishes.", {
        "friction.nominal_n": 0.35}),
    Preset("Weak plate", "Half of the paper's amplitude.", {
        "plate.max_amplitude_um": 1.2}),
    Preset("Full plate", "2.5 um, as the paper's plate.", {
        "plate.max_amplitude_um": 2.5}),
)  # fmt: skip
BY_NAME = {each.name: each for each in PRESETS}
