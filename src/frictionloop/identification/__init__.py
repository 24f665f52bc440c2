"""Recordings to parameters, with uncertainty: sees datasets only, a simulated rig and a recording look the same.

channels  bench  run  compare   the verbs: what is in a file, a bench from its recordings, a recording, two certificates
load  weights  response  modes  noise  friction  susceptibility   the analyses by themselves, on recordings of your own
"""

from frictionloop.identification.bench_identification import bench
from frictionloop.identification.calibration_wizard import Recorded, Step, amplitude_protocol, map_beside, run, steps_of
from frictionloop.identification.certificate_comparison import Change, Comparison, Corner, certified_corners, compare
from frictionloop.identification.channel_summary import ChannelSummary
from frictionloop.identification.decay_modes import Mode, Modes, modes
from frictionloop.identification.estimate import Estimate, Interval, Measured
from frictionloop.identification.file_overview import FileChannels, FirstLook, channels, first_look
from frictionloop.identification.finger_population import People, people
from frictionloop.identification.frequency_response import FrequencyResponse, Resonance, fit_resonance, response
from frictionloop.identification.hits import Hit, Hits, pick_hits
from frictionloop.identification.identified_bench import Bench, to_toml
from frictionloop.identification.linear_calibration import CarrierDrift, carrier_drift
from frictionloop.identification.loop_delay import LoopDelay, loop_delay
from frictionloop.identification.noise_density import (
    FloorReading,
    NoiseSpectrum,
    Spur,
    band_rms,
    dynamic_range_db,
    floor_density,
    floor_readings,
    noise_spectrum,
    residual_share,
    uniform_std_n,
)
from frictionloop.identification.plate_decay import PlateEnvelope, plate_decay, plate_envelope
from frictionloop.identification.plate_sweep import PlateResonance, plate_sweep
from frictionloop.identification.project_entry_result import Refused
from frictionloop.identification.project_file import Channel, ChannelMap, Converter, Project, Take, read_map
from frictionloop.identification.quiet import Quiet, noise
from frictionloop.identification.recording_columns import channel, rate_of
from frictionloop.identification.recording_file import findings_of, load
from frictionloop.identification.slides import Friction, Slide, friction
from frictionloop.identification.susceptibility import MonotoneTable, SusceptibilityFit, monotone_table, susceptibility
from frictionloop.identification.susceptibility_fit import LawFit
from frictionloop.identification.weights_calibration import (
    Calibration,
    Plateaus,
    PulleyFriction,
    exponent_for_r2,
    plateaus,
    pulley_friction,
    r2_with_friction,
    weights,
)
from frictionloop.identification.weights_straightness import Straightness, straightness
