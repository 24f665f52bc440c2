"""Linear analysis of the loop: equation (2) as responses and state space, margins, equation (3), re-tuned gains."""

from frictionloop.design.band import operating_band
from frictionloop.design.disturbance import touch_spectrum
from frictionloop.design.elements import Elements, elements, lumped_gain
from frictionloop.design.high_order import Synthesised
from frictionloop.design.hinf import design_hinf, design_lqg
from frictionloop.design.law_space import law_space
from frictionloop.design.limits import (
    Lag,
    Stubborn,
    available_crossover_hz,
    bode_integral,
    phase_lag,
    stubborn,
    unstable_sum,
)
from frictionloop.design.linear import LinearLoop, linearise
from frictionloop.design.linear_optimum import LinearOptimum, linear_optimum
from frictionloop.design.margins import Margins
from frictionloop.design.noise import (
    command_noise_rms_n,
    equation_3_rms_n,
    integrated_noise_rms_n,
    noise_spectrum,
    output_noise_rms_n,
)
from frictionloop.design.notch import Notched, retune_notch
from frictionloop.design.responses import Reading
from frictionloop.design.retune import Retuned, retune
from frictionloop.design.robustness import robustness
from frictionloop.design.stability import kp_limit
from frictionloop.design.state_space import StateSpace
from frictionloop.design.tracker_tuning import TrackerTuning, tune_tracker
from frictionloop.design.waterbed import Waterbed, waterbed_bound

__all__ = [
    "Elements",
    "Lag",
    "LinearLoop",
    "LinearOptimum",
    "Margins",
    "Notched",
    "Reading",
    "Retuned",
    "StateSpace",
    "TrackerTuning",
    "Stubborn",
    "Synthesised",
    "Waterbed",
    "available_crossover_hz",
    "bode_integral",
    "command_noise_rms_n",
    "design_hinf",
    "design_lqg",
    "elements",
    "equation_3_rms_n",
    "integrated_noise_rms_n",
    "kp_limit",
    "law_space",
    "linear_optimum",
    "linearise",
    "lumped_gain",
    "noise_spectrum",
    "operating_band",
    "output_noise_rms_n",
    "phase_lag",
    "retune",
    "retune_notch",
    "robustness",
    "touch_spectrum",
    "tune_tracker",
    "stubborn",
    "unstable_sum",
    "waterbed_bound",
]
