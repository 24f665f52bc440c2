"""Is a force felt? Thresholds, and the filter that accumulates the index D of a residual."""

from frictionloop.perception.detection_thresholds import displacement_threshold_um, force_threshold_n
from frictionloop.perception.weighting import weighting_sos
