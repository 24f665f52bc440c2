"""The elements of equation (2), C, P and S, of a System at an operating point, and which of its fields they have."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from frictionloop import parameters as block
from frictionloop.analysis.operating_point import law_at, operating_amplitude_um
from frictionloop.control.lookup import lookup_table
from frictionloop.control.pi import is_pi, linearise_pi
from frictionloop.parameters import FingerFriction, Model, PiController, Skin, Strokes, System, check_system
from frictionloop.parameters.block import Represented
from frictionloop.parameters.controller import CONTROLLERS
from frictionloop.physics.bristle_contact import linearise_slip
from frictionloop.physics.friction import friction_force, is_gaussian, slope_per_um2
from frictionloop.physics.limit_scaling import aged_step, ageing_coefficients
from frictionloop.physics.plate import LINEAR_PLATE, linearise_plate
from frictionloop.quantities import FrictionloopError, Lti
from frictionloop.sensing.force_sensor import linearise_sensor

OF_THEIR_STEP = [CONTROLLERS[kind] for kind in CONTROLLERS.names if CONTROLLERS[kind] is not PiController]
"""Laws of which the step itself is linearised, with all its gains."""
STATIC_SHARE = 0.05
"""Most by which ageing may raise the limit at the stroke's speed and be left out (assumed)."""

LINEAR = Represented(
    "the linear analysis",
    {
        **LINEAR_PLATE,
        block.FrictionLimit: "nominal_n",
        block.FrictionLaw: "susceptibility_per_um2",
        block.Friction: "kind",
        block.FingerFriction: "kind reference_load_n load_exponent speed_slope reference_speed_mm_s slow_mm_s "
        "occlusion_ratio moist_loss",
        block.LowpassSensor: "kind cutoff_hz noise_rms_n",
        block.SuspendedSensor: "kind moving_mass_kg resonance_hz q cutoff_hz noise_density_n_rthz adc_bits range_n",
        block.RigidFinger: "kind",
        block.Skin: "kind stiffness_n_m damping_n_s_m mass_kg slip_length_um",
        block.Sliding: "kind",
        block.Strokes: "kind speed_mm_s load_n",
        block.Touch: "position load",
        block.LoadCells: "touch_n least_speed_mm_s",
        block.Timing: "rate_hz delay_s model",
        block.PiController: "kind kp ki",
        **{law: " ".join(law.model_fields) for law in OF_THEIR_STEP},
        block.Model: "nominal_n susceptibility_per_um2 max_amplitude_um plate_hz resonance_hz resonance_q sensor_hz "
        "table_size table_um2",
    },
    {
        block.Model: "gain_spread",
        block.LowpassPlate: "pulse_ticks",
        block.ResonantPlate: "pulse_ticks",
        block.FingerFriction: "static_ratio static_s static_um occlusion_s drying_s roughness_rms roughness_longest_mm",
        block.Strokes: "stroke_mm reversal_s start load_drift load_drift_s tremor_um tremor_n tremor_hz "
        "tremor_width_hz landing_s contact_s lifted_s person unscored_n",
        block.PositionSensor: "noise_um resolution_um fastest_mm_s tracking_hz",
        block.LoadCells: "noise_n length_mm touch_share mean_s speed_share developed_mm turn_mm",
        block.Timing: "jitter_s lost_ticks open_until_s",
    },
)


def check_known(system: System) -> None:
    """Refuse a System with a field that is not in the linear analysis, or that sticks at the speed of its strokes.

    Raises
    ------
    FrictionloopError
        Naming the field.
    """
    blocks = ("plate", "sensor", "controller", "finger", "motion", "touch")
    LINEAR.check({name: getattr(system, name) for name in blocks})
    friction, motion = system.friction, system.motion
    if is_gaussian(friction):  # of another law the slope is that of its step
        LINEAR.check({"friction": friction})
    if isinstance(friction, FingerFriction) and isinstance(motion, Strokes):
        age_s = 1e-3 * friction.static_um / motion.speed_mm_s
        raised = aged_step(age_s, ageing_coefficients(friction)) - 1.0
        if raised > STATIC_SHARE:
            raise FrictionloopError(
                f"friction.static_ratio = {friction.static_ratio:g}: ages by {raised:.2g}, at most {STATIC_SHARE:g}; "
                f"motion.speed_mm_s = {motion.speed_mm_s:g}"
            )


@dataclass(frozen=True)
class Elements:
    """C(s), P(s), S(s) of equation (2) for small signals, and where on the friction law they hold."""

    controller: Lti | None
    """C(s) = (kp + ki/s) exp(-s delay_s) of a PI law, error to force command, N/N; other laws: `law_space`."""
    delay_s: float
    """Time from a sample to the command computed from it."""
    plate: Lti
    """P(s), force command to friction force, N/N: lookup table, plate, friction law and contact lumped."""
    stages: tuple[Lti, ...]
    """S(s) as blocks in series: springs if there are any, then the electronics' pole. Noise enters before the last."""
    amplitude_um: float
    """Vibration amplitude of the operating point, um zero-to-peak."""
    force_n: float
    """Friction force g(a) of the operating point, N, without the disturbance."""
    occluded: float = 0.0
    """How far occlusion has come at the operating point, 0 to 1."""

    @property
    def sensor(self) -> Lti:
        """S(s), force to measured force, N/N."""
        return math.prod(self.stages[1:], start=self.stages[0])


def elements(
    system: System, amplitude_um: float | None = None, force_n: float | None = None, occluded: float = 0.0
) -> Elements:
    """Return C, P and S of equation (2) at an operating point.

    The literal order of the paper's Section 2.2 is kept, low-pass on the amplitude, then g: small signals then see
    P(s) = `lumped_gain` times the plate's low-pass, times the contact of a finger that slides steadily
    (physics/contact; 1 without skin).

    Parameters
    ----------
    system
        The loop.
    amplitude_um
        Vibration amplitude of the operating point, um, from 0 to the smaller a_max of plate and controller model.
    force_n
        The operating point as a force g(a) instead, N. Without either: as in `linearise`.
    occluded
        How far occlusion under a `FingerFriction` has come: 0 just landed, 1 after long contact.

    Raises
    ------
    FrictionloopError
        Both are given, the point cannot be reached, or a field of a block is not known here (`LINEAR`).
    """
    check_system(system)
    check_known(system)
    law = law_at(system, occluded)
    amplitude = operating_amplitude_um(system, occluded, amplitude_um, force_n)
    force = float(friction_force(amplitude, law))
    gain = lumped_gain(system, amplitude, occluded)
    return Elements(
        controller=linearise_pi(system.controller) if is_pi(system.controller) else None,
        delay_s=system.controller.delay_s,
        plate=Lti((gain,), (1.0,)) * linearise_plate(system.plate) * linearise_contact(system, force),
        stages=linearise_sensor(system.sensor),
        amplitude_um=amplitude,
        force_n=force,
        occluded=occluded,
    )


def lumped_gain(system: System, amplitude_um: float, occluded: float = 0.0) -> float:
    """Return df/du of lookup table and friction law in series, dg/d(a^2) d(a^2)/du; 1 where the model is right.

    With the exact inverse this is g'(a) / g_model'(a), finite at a = 0 too; with a table d(a^2)/du is the slope of
    the cell that holds ``amplitude_um``.
    """
    law = law_at(system, occluded)
    slope = _square_per_newton(system.controller.model, amplitude_um)
    return slope_per_um2(amplitude_um, law) * slope


def linearise_contact(system: System, force_n: float) -> Lti:
    """Return friction limit to friction force at steady sliding with this force (N), N/N; 1 without skin."""
    finger, motion = system.finger, system.motion
    if not (isinstance(finger, Skin) and isinstance(motion, Strokes)):
        return Lti((1.0,), (1.0,))
    return linearise_slip(finger, force_n, 1e-3 * motion.speed_mm_s)


def _square_per_newton(model: Model, amplitude_um: float) -> float:
    """Return d(a^2)/du of the lookup table in um^2/N."""
    if model.table_size == 0:
        believed = model.nominal_n * math.exp(-model.susceptibility_per_um2 * amplitude_um**2)
        return -1.0 / (model.susceptibility_per_um2 * believed)
    squares = lookup_table(model)
    cell = int(np.clip(np.searchsorted(-squares, -(amplitude_um**2), side="right") - 1, 0, squares.size - 2))
    spacing_n = (model.nominal_n - model.floor_n) / (squares.size - 1)
    return float(squares[cell + 1] - squares[cell]) / spacing_n
