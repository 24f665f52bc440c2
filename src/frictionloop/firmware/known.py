"""Which fields of a controller the firmware's form of it has, and of the bench what its words tell it."""

from __future__ import annotations

from frictionloop.control.limit_observer import LimitObserverController
from frictionloop.parameters import (
    Board,
    FilteredPiController,
    LoadCells,
    LookupController,
    Model,
    NotchPiController,
    PiController,
    PositionSensor,
    System,
    Timing,
    Touch,
)
from frictionloop.parameters.filtered import FeedForward
from frictionloop.parameters.represented import Represented

FIRMWARE = Represented(
    "the firmware's form of the law",
    {
        # Delay, jitter and lost ticks are the board's own: a simulation keeps them.
        Timing: "rate_hz delay_s jitter_s lost_ticks open_until_s form model",
        PiController: "kind kp ki",
        LookupController: "kind overdrive",
        FeedForward: "kp ki feedforward overdrive",
        FilteredPiController: "kind sections",
        NotchPiController: "kind kp ki notch_hz notch_depth notch_width",
        LimitObserverController: "kind slip_length_um susceptibility_margin bandwidth_hz spring_noise",
        Model: "nominal_n susceptibility_per_um2 max_amplitude_um plate_hz resonance_hz resonance_q sensor_hz "
        "table_um2",
        Touch: "position load",
        PositionSensor: "tracking_hz",
        LoadCells: "touch_n touch_share mean_s least_speed_mm_s speed_share developed_mm turn_mm",
        Board: "force_axes force_zero_counts force_n_per_count across_n_per_count load_zero_counts load_n_per_count "
        "position_m_per_count ceiling_um ramp_s force_limit_n hum_share",
    },
    # Its table has 257 entries whatever is given; noise, range and length are those of the sensors that it reads.
    {
        Model: "table_size gain_spread",
        PositionSensor: "noise_um resolution_um fastest_mm_s",
        LoadCells: "noise_n length_mm",
    },
)


def check_known(system: System, *blocks: str) -> None:
    """Refuse a field of a System's blocks that no word of the firmware has.

    Raises
    ------
    FrictionloopError
        Naming the field.
    """
    FIRMWARE.check({name: getattr(system, name) for name in blocks})
