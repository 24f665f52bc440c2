"""Second-order sections of a `filtered_pi`: two that are free, four that are held below their poles."""

from __future__ import annotations

import numpy as np


def section(zeros, poles, gain=1.0):
    return (*(gain * np.poly(zeros)).tolist(), *np.poly(poles)[1:].tolist())


FREE = (section([0.98 + 0.17j, 0.98 - 0.17j], [0.3, 0.2]), section([0.5, 0.2], [0.6, -0.4]))
HELD = (
    section([0.99 + 0.01j, 0.99 - 0.01j], [0.9978 + 0.0127j, 0.9978 - 0.0127j], 0.5),
    section([0.9991, 0.98], [0.9994, 0.9947], 0.8),
    section([0.7, -0.3], [0.97, 0.5], -0.9),
    section([0.4, 0.1], [0.9, 0.2], -1.1),
)
"""Memories of 0.3 s and of 90 ms at 10 Hz among them, as an H-infinity controller has."""
