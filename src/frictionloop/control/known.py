"""Which fields the oracle has, of the blocks that it is worked out from."""

from __future__ import annotations

from frictionloop import parameters as block
from frictionloop.parameters import System
from frictionloop.parameters.represented import Represented
from frictionloop.physics.friction import is_gaussian

ORACLE = Represented(
    "the oracle",
    {
        block.LowpassPlate: "kind cutoff_hz max_amplitude_um",
        block.ResonantPlate: "kind frequency_hz q max_amplitude_um",
        block.FrictionLimit: "nominal_n",
        block.FrictionLaw: "susceptibility_per_um2",
        block.Friction: "kind",
        block.FingerFriction: "kind reference_load_n load_exponent speed_slope reference_speed_mm_s slow_mm_s "
        "static_ratio static_mm_s occlusion_ratio occlusion_s drying_s moist_loss roughness_rms roughness_longest_mm",
        block.RigidFinger: "kind",
        block.Skin: "kind stiffness_n_m damping_n_s_m mass_kg slip_length_um",
        block.Sliding: "kind",
        block.Strokes: "kind speed_mm_s stroke_mm reversal_s start load_n load_drift load_drift_s tremor_um tremor_n "
        "tremor_hz tremor_width_hz landing_s contact_s lifted_s person unscored_n",
    },
    # Pulses round the command that it has chosen.
    {block.LowpassPlate: "pulse_ticks", block.ResonantPlate: "pulse_ticks"},
)
"""It tries commands on the plant; sensors it does not need."""


def check_oracle(system: System) -> None:
    """Refuse what an oracle does not know of the plant."""
    ORACLE.check({name: getattr(system, name) for name in ("plate", "finger", "motion")})
    if is_gaussian(system.friction):  # of another law it has the step and the inverse
        ORACLE.check({"friction": system.friction})
