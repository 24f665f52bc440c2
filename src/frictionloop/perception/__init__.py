"""Is a force felt? Thresholds, the index D of a residual (spectral and streaming), just-noticeable differences."""

from frictionloop.perception.differences import (
    Jnd,
    force_jnd_n,
    friction_jnd_n,
    slow_error_felt,
    timing_felt,
)
from frictionloop.perception.index import (
    index_db,
    index_of_residual,
    index_of_spectrum,
    is_perceptible,
    ratio_to_plain,
)
from frictionloop.perception.thresholds import (
    Fingertip,
    Impedance,
    displacement_threshold_um,
    force_threshold_n,
)
from frictionloop.perception.weighting import (
    settled_state,
    weighting_error_db,
    weighting_sos,
)
from frictionloop.perception.windows import streaming_index, weighted_residual, windowed_index

__all__ = [
    "Fingertip",
    "Impedance",
    "Jnd",
    "displacement_threshold_um",
    "force_jnd_n",
    "force_threshold_n",
    "friction_jnd_n",
    "index_db",
    "index_of_residual",
    "index_of_spectrum",
    "is_perceptible",
    "ratio_to_plain",
    "settled_state",
    "slow_error_felt",
    "streaming_index",
    "timing_felt",
    "weighted_residual",
    "weighting_error_db",
    "weighting_sos",
    "windowed_index",
]
