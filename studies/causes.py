"""Causes of the residual f_a - f_r, each as the change of a System that takes it away; all else stays, the noise too.

Disturbances move the force or its reading; limits are what the loop cannot do. Only tremor, roughness and sensor noise
are drawn, each from a stream of its own, so that runs of one seed pair up whatever is taken away.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from frictionloop.analysis.operating_point import law_at
from frictionloop.parameters import Constant, FingerFriction, Source, Strokes, SuspendedSensor, System
from frictionloop.physics.friction import is_gaussian
from frictionloop.physics.signal_values import sampler

Overrides = Mapping[str, Any]
AT_ONCE_HZ, AT_ONCE_Q = 1e6, 0.5
"""Springs that follow at once: 0.3 us late, without ringing."""
STRONGER = 2.0
"""Factor on the plate's largest amplitude that takes saturation away: tau a^2 up to 9.5 at the bench's tau."""


def _field(block: str, kind: type, values: Overrides) -> Callable[[System, float, float], Overrides | None]:
    return lambda system, start_s, stop_s: values if isinstance(getattr(system, block), kind) else None


def _held(name: str) -> Callable[[System, float, float], Overrides | None]:
    def removed(system: System, start_s: float, stop_s: float) -> Overrides | None:
        source = getattr(system, name)
        if isinstance(source, Constant):
            return None
        return {name: Constant(offset_n=_mean_n(source, system.controller.rate_hz, start_s, stop_s))}

    return removed


def _mean_n(source: Source, rate_hz: float, start_s: float, stop_s: float) -> float:
    """Return the mean of a signal over the scored time; of a formula and of noise, their offset."""
    take = None if source.kind == "noise" else sampler(source, rate_hz, 0, 0)
    if take is None:
        return float(source.offset_n)  # type: ignore[attr-defined]
    return float(np.mean(take(0, round(stop_s * rate_hz))[round(start_s * rate_hz) : -1]))


def mean_occlusion(system: System, start_s: float, stop_s: float) -> float:
    """Return the mean of w = s (1 - e^(-t/T)) over a time, s the share of it in contact (cycles short against T)."""
    friction, motion = system.friction, system.motion
    if not (isinstance(friction, FingerFriction) and isinstance(motion, Strokes)):
        return 0.0
    share = motion.contact_s / (motion.contact_s + motion.lifted_s) if motion.contact_s else 1.0
    a, b = start_s / friction.occlusion_s, stop_s / friction.occlusion_s
    return share * (1.0 - (math.exp(-a) - math.exp(-b)) / (b - a))


def _no_occlusion(system: System, start_s: float, stop_s: float) -> Overrides | None:
    """Friction of no moisture whose f0 and tau are the means of those with it."""
    friction, w = system.friction, mean_occlusion(system, start_s, stop_s)
    if not isinstance(friction, FingerFriction):
        return None
    return {
        "friction.nominal_n": friction.nominal_n * (1.0 + (friction.occlusion_ratio - 1.0) * w),
        "friction.susceptibility_per_um2": friction.susceptibility_per_um2 * (1.0 - friction.moist_loss * w),
        "friction.occlusion_ratio": 1.0,
        "friction.moist_loss": 0.0,
    }


def _quiet(system: System, start_s: float, stop_s: float) -> Overrides:
    if isinstance(system.sensor, SuspendedSensor):
        return {"sensor.noise_density_n_rthz": 0.0, "sensor.adc_bits": 32}
    return {"sensor.noise_rms_n": 0.0}


def _no_springs(system: System, start_s: float, stop_s: float) -> Overrides | None:
    """Springs that follow at once, and a controller that is told: no resonance in its model, none undone by a notch.

    Sections given as numbers undo it without saying where: they cannot be told, None.
    """
    law: Any = system.controller
    if not isinstance(system.sensor, SuspendedSensor) or getattr(law, "sections", None):
        return None
    found: dict[str, Any] = {"sensor.resonance_hz": AT_ONCE_HZ, "sensor.q": AT_ONCE_Q}
    found["controller.model.resonance_hz"] = 0.0
    if law.kind == "notch_pi":
        found["controller.kind"] = "filtered_pi"
        found |= {f"controller.{name}": getattr(law, name) for name in ("kp", "ki", "feedforward", "overdrive")}
        found["controller.sections"] = (_undoes_nothing(law.notch_hz, law.notch_width, law.rate_hz),)
    return found


def _undoes_nothing(notch_hz: float, width: float, rate_hz: float) -> tuple[float, ...]:
    """w^2 / (s^2 + 2 width w s + w^2) as a section: `notch_section` without the zeros that undo the resonance."""
    t = math.tan(math.pi * notch_hz / rate_hz)
    scale = 1.0 / (1.0 + 2.0 * width * t + t * t)
    gain = t * t * scale
    return (gain, 2.0 * gain, gain, 2.0 * (t * t - 1.0) * scale, (1.0 - 2.0 * width * t + t * t) * scale)


def _as_believed(system: System, start_s: float, stop_s: float) -> Overrides | None:
    model = system.controller.model
    if not isinstance(system.sensor, SuspendedSensor) or model.resonance_hz == 0.0:
        return None
    return {"sensor.resonance_hz": model.resonance_hz, "sensor.q": model.resonance_q}


def _stronger(system: System, start_s: float, stop_s: float) -> Overrides:
    """Lower forces and more overdrive; the highest force is the finger's own, which no plate can raise."""
    return {
        "plate.max_amplitude_um": STRONGER * system.plate.max_amplitude_um,
        "controller.model.max_amplitude_um": STRONGER * system.controller.model.max_amplitude_um,
    }


def _calibrated(system: System, start_s: float, stop_s: float) -> Overrides:
    law = law_at(system, mean_occlusion(system, start_s, stop_s))
    assert is_gaussian(law)
    most: float = getattr(system.sensor, "range_n", math.inf)
    return {
        "controller.model.nominal_n": min(law.nominal_n, most),
        "controller.model.susceptibility_per_um2": law.susceptibility_per_um2,
    }


DISTURBANCES: dict[str, Callable[[System, float, float], Overrides | None]] = {
    "tangential tremor": _field("motion", Strokes, {"motion.tremor_um": 0.0}),
    "normal tremor": _field("motion", Strokes, {"motion.tremor_n": 0.0}),
    "roughness": _field("friction", FingerFriction, {"friction.roughness_rms": 0.0}),
    "load drift": _field("motion", Strokes, {"motion.load_drift": 0.0}),
    "occlusion": _no_occlusion,
    "set-point": _held("setpoint"),
    "disturbance": _held("disturbance"),
    "sensor noise": _quiet,
}
"""What moves the force or its reading."""
LIMITS: dict[str, Callable[[System, float, float], Overrides | None]] = {
    "misjudged resonance": _as_believed,
    "resonance": _no_springs,
    "saturation": _stronger,
    "unknown finger": _calibrated,
}
"""What the loop cannot do: know the sensor's resonance, do without it, push harder, know f0 and tau of the finger.

A misjudged resonance comes before the resonance: with both taken away there are no springs.
"""
CAUSES = DISTURBANCES | LIMITS


def causes_of(system: System, start_s: float = 0.0, stop_s: float = 10.0) -> tuple[str, ...]:
    """Return the causes that can be taken away from a system."""
    return tuple(name for name, removed in CAUSES.items() if removed(system, start_s, stop_s) is not None)


def without(system: System, names: Iterable[str], start_s: float = 0.0, stop_s: float = 10.0) -> dict[str, Any]:
    """Return overrides that take causes away from a system, one after the other.

    Parameters
    ----------
    system
        The loop, with any controller.
    names
        Keys of `CAUSES`. What a system does not have is not there to be taken away.
    start_s, stop_s
        The scored time in s, over which set-point and occlusion keep their means.
    """
    asked = set(names)
    found: dict[str, Any] = {}
    for name, removed in CAUSES.items():
        if name in asked:
            found |= removed(system, start_s, stop_s) or {}
    return found
