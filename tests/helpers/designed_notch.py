"""What the synthesis of `notch_pi` finds for the contact of `bench()`, to three digits: it takes half a minute."""

from __future__ import annotations

DESIGNED_NOTCH = {
    "controller.kind": "notch_pi",
    "controller.kp": 7.12,
    "controller.ki": 64.3,
    "controller.notch_hz": 132.4,
    "controller.notch_depth": 0.00541,
    "controller.notch_width": 10.0,
    "controller.feedforward": True,
    "controller.overdrive": True,
}
