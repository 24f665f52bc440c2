"""What `design_controller(bench(), "notch_pi")` finds, to three digits: its design takes half a minute."""

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
