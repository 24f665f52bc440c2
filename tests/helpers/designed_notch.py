"""What the synthesis of `notch_pi` finds for the contact of `bench()`, to three digits: it takes half a minute."""

from __future__ import annotations

DESIGNED_NOTCH = {
    "controller.kind": "notch_pi",
    "controller.kp": 6.36,
    "controller.ki": 52.1,
    "controller.notch_hz": 136.7,
    "controller.notch_depth": 0.00151,
    "controller.notch_width": 10.0,
    "controller.feedforward": True,
    "controller.overdrive": True,
}
