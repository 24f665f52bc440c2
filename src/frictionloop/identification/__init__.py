"""Recordings to parameters, with uncertainty: sees datasets only, a simulated rig and a recording look the same.

channels  bench  run  compare   the verbs: what is in a file, a bench from its recordings, a recording, two certificates
load  weights  response  modes  noise  friction  vibrated   the analyses by themselves, on recordings of your own
"""

from frictionloop.identification.agreement import Corner
from frictionloop.identification.amplitude_protocol import amplitude_protocol
from frictionloop.identification.bench_file import to_toml
from frictionloop.identification.bench_identification import Bench, bench
from frictionloop.identification.calibration import Calibration, Plateaus, plateaus, weights
from frictionloop.identification.calibration_wizard import Recorded, Step, map_beside, run, steps_of
from frictionloop.identification.carrier_drift import CarrierDrift, carrier_drift
from frictionloop.identification.certificates import Change, Comparison, certified_corners, compare
from frictionloop.identification.channel_map import Channel, ChannelMap, read_map
from frictionloop.identification.channel_summary import ChannelSummary
from frictionloop.identification.estimate import Estimate, Interval
from frictionloop.identification.figures_of_merit import (
    FloorReading,
    dynamic_range_db,
    floor_readings,
    residual_share,
    uniform_std_n,
)
from frictionloop.identification.file_channels import FileChannels, channels
from frictionloop.identification.file_traces import FirstLook, first_look
from frictionloop.identification.frequency_response import FrequencyResponse, response
from frictionloop.identification.hits import Hit, Hits, pick_hits
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
from frictionloop.identification.opened import findings_of, load
from frictionloop.identification.people import People, people
from frictionloop.identification.plate_decay import PlateEnvelope, plate_decay, plate_envelope
from frictionloop.identification.plate_sweep import PlateResonance, plate_sweep
from frictionloop.identification.project import Converter, Project, Take
from frictionloop.identification.quiet import Quiet, noise
from frictionloop.identification.recording_columns import channel, rate_of
from frictionloop.identification.refused import Refused
from frictionloop.identification.resonance import Resonance, fit_resonance
from frictionloop.identification.ring_down import RingDown, fit_ring_down
from frictionloop.identification.slides import Friction, Slide, friction
from frictionloop.identification.spurs import Spur
from frictionloop.identification.straightness import (
    PulleyFriction,
    Straightness,
    exponent_for_r2,
    pulley_friction,
    r2_with_friction,
    straightness,
)
from frictionloop.identification.vibrated import Vibrated, vibrated
from frictionloop.identification.vibrated_fit import LawFit

__all__ = [
    "Bench",
    "Calibration",
    "CarrierDrift",
    "Change",
    "Channel",
    "ChannelMap",
    "ChannelSummary",
    "Comparison",
    "Converter",
    "Corner",
    "Estimate",
    "FileChannels",
    "FirstLook",
    "FloorReading",
    "FrequencyResponse",
    "Friction",
    "Hit",
    "Hits",
    "Interval",
    "LawFit",
    "LoopDelay",
    "Measured",
    "Mode",
    "Modes",
    "MonotoneTable",
    "NoiseSpectrum",
    "People",
    "PlateEnvelope",
    "PlateResonance",
    "Plateaus",
    "Project",
    "PulleyFriction",
    "Quiet",
    "Recorded",
    "Refused",
    "Resonance",
    "RingDown",
    "Slide",
    "Spur",
    "Step",
    "Straightness",
    "Take",
    "Vibrated",
    "amplitude_protocol",
    "band_rms",
    "bench",
    "carrier_drift",
    "certified_corners",
    "channel",
    "channels",
    "compare",
    "dynamic_range_db",
    "exponent_for_r2",
    "findings_of",
    "first_look",
    "fit_resonance",
    "fit_ring_down",
    "floor_density",
    "floor_readings",
    "friction",
    "load",
    "loop_delay",
    "map_beside",
    "modes",
    "monotone_table",
    "noise",
    "noise_spectrum",
    "people",
    "pick_hits",
    "plate_decay",
    "plate_envelope",
    "plate_sweep",
    "plateaus",
    "pulley_friction",
    "r2_with_friction",
    "rate_of",
    "read_map",
    "residual_share",
    "response",
    "run",
    "steps_of",
    "straightness",
    "to_toml",
    "uniform_std_n",
    "vibrated",
    "weights",
]
