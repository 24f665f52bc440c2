"""Linear analysis of the loop: equation (2) as responses and state space, margins, equation (3), and its limits."""

from frictionloop.analysis.disturbance_spectrum import (
    command_noise_rms_n,
    equation_3_rms_n,
    output_noise_rms_n,
    touch_spectrum,
)
from frictionloop.analysis.law_space import law_space
from frictionloop.analysis.limits import (
    Lag,
    Stubborn,
    available_crossover_hz,
    bode_integral,
    phase_lag,
    stubborn,
    unstable_sum,
)
from frictionloop.analysis.linear import LinearLoop, Reading, linearise, operating_band
from frictionloop.analysis.loop_elements import Elements, elements, lumped_gain
from frictionloop.analysis.margins import Margins
from frictionloop.analysis.stability import Ringing, kp_limit, rings
from frictionloop.analysis.state_space import StateSpace
from frictionloop.analysis.waterbed import Waterbed, waterbed_bound
