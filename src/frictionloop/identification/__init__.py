"""Recordings to parameters, with uncertainty: sees datasets only, a simulated rig and a recording look the same."""

from frictionloop.identification.agreement import Corner
from frictionloop.identification.amplitude_protocol import amplitude_protocol
from frictionloop.identification.bench import Bench, bench
from frictionloop.identification.bench_file import to_toml
from frictionloop.identification.calibration import Calibration, weights
from frictionloop.identification.carrier_drift import CarrierDrift, carrier_drift
from frictionloop.identification.certified import certified_corners
from frictionloop.identification.channel_map import Channel, ChannelMap, read_map
from frictionloop.identification.channels import channel, rate_of
from frictionloop.identification.compare import Change, compare
from frictionloop.identification.estimate import Estimate, Interval
from frictionloop.identification.figures_of_merit import (
    FloorReading,
    dynamic_range_db,
    floor_readings,
    residual_share,
    uniform_std_n,
)
from frictionloop.identification.frequency_response import FrequencyResponse, response
from frictionloop.identification.glance import ChannelPreview
from frictionloop.identification.hits import Hit, Hits, pick_hits
from frictionloop.identification.kept import kept_results
from frictionloop.identification.load import load
from frictionloop.identification.loop_delay import LoopDelay, loop_delay
from frictionloop.identification.measured import Measured
from frictionloop.identification.mode import Mode, Modes
from frictionloop.identification.modes import modes
from frictionloop.identification.monotone_table import MonotoneTable, monotone_table
from frictionloop.identification.noise import (
    NoiseSpectrum,
    band_rms,
    floor_density,
    noise_spectrum,
)
from frictionloop.identification.people import People, people
from frictionloop.identification.plate_decay import plate_decay
from frictionloop.identification.plate_envelope import PlateEnvelope, plate_envelope
from frictionloop.identification.plate_sweep import PlateResonance, plate_sweep
from frictionloop.identification.plateaus import Plateaus, plateaus
from frictionloop.identification.preview import Preview, preview
from frictionloop.identification.project import Converter, Project, Take
from frictionloop.identification.pulley import PulleyFriction, exponent_for_r2, pulley_friction, r2_with_friction
from frictionloop.identification.quiet import Quiet, noise
from frictionloop.identification.resonance import Resonance, fit_resonance
from frictionloop.identification.ring_down import RingDown, fit_ring_down
from frictionloop.identification.slides import Friction, Slide, friction
from frictionloop.identification.spurs import Spur
from frictionloop.identification.straightness import Straightness, straightness
from frictionloop.identification.vibrated import Vibrated, vibrated
from frictionloop.identification.vibrated_fit import LawFit

__all__ = [
    "Corner",
    "CarrierDrift",
    "carrier_drift",
    "Change",
    "compare",
    "LoopDelay",
    "loop_delay",
    "People",
    "people",
    "PlateEnvelope",
    "plate_decay",
    "plate_envelope",
    "PlateResonance",
    "plate_sweep",
    "Bench",
    "Calibration",
    "Channel",
    "ChannelMap",
    "ChannelPreview",
    "Converter",
    "Estimate",
    "FloorReading",
    "FrequencyResponse",
    "Friction",
    "Hit",
    "Hits",
    "Interval",
    "LawFit",
    "Measured",
    "Mode",
    "Modes",
    "MonotoneTable",
    "NoiseSpectrum",
    "Plateaus",
    "Preview",
    "PulleyFriction",
    "Project",
    "Quiet",
    "Resonance",
    "RingDown",
    "Slide",
    "Spur",
    "Straightness",
    "Take",
    "Vibrated",
    "amplitude_protocol",
    "band_rms",
    "bench",
    "certified_corners",
    "channel",
    "dynamic_range_db",
    "exponent_for_r2",
    "fit_resonance",
    "fit_ring_down",
    "floor_density",
    "floor_readings",
    "friction",
    "kept_results",
    "load",
    "modes",
    "monotone_table",
    "noise",
    "noise_spectrum",
    "pick_hits",
    "plateaus",
    "preview",
    "pulley_friction",
    "r2_with_friction",
    "rate_of",
    "read_map",
    "residual_share",
    "response",
    "straightness",
    "to_toml",
    "uniform_std_n",
    "vibrated",
    "weights",
]
