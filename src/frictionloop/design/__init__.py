"""Linear analysis of the loop: equation (2) as responses and state space, margins, equation (3), re-tuned gains."""

from frictionloop.design.band import operating_band
from frictionloop.design.elements import Elements, elements, lumped_gain
from frictionloop.design.linear import LinearLoop, linearise
from frictionloop.design.margins import Margins
from frictionloop.design.noise import (
    command_noise_rms_n,
    equation_3_rms_n,
    integrated_noise_rms_n,
    noise_spectrum,
    output_noise_rms_n,
)
from frictionloop.design.responses import Reading
from frictionloop.design.retune import Retuned, retune
from frictionloop.design.stability import kp_limit
from frictionloop.design.state_space import StateSpace

__all__ = [
    "Elements",
    "LinearLoop",
    "Margins",
    "Reading",
    "Retuned",
    "StateSpace",
    "command_noise_rms_n",
    "elements",
    "equation_3_rms_n",
    "integrated_noise_rms_n",
    "kp_limit",
    "linearise",
    "lumped_gain",
    "noise_spectrum",
    "operating_band",
    "output_noise_rms_n",
    "retune",
]
