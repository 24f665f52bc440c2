"""Which fields of a System the linear analysis has; `linearise` says what it leaves out."""

from __future__ import annotations

from frictionloop import parameters as block
from frictionloop.parameters import FingerFriction, PiController, Strokes, System
from frictionloop.parameters.controller import CONTROLLERS
from frictionloop.parameters.represented import Represented
from frictionloop.physics.friction import is_gaussian
from frictionloop.physics.friction_limit import aged_step, ageing_coefficients
from frictionloop.physics.plate import LINEAR_PLATE
from frictionloop.quantities import FrictionloopError

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
        block.Timing: "jitter_s lost_ticks open_until_s form",
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
