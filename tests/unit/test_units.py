"""Units carried by names."""

from __future__ import annotations

import pytest

from frictionloop.quantities import FrictionloopError, unit_of


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("friction.susceptibility_per_um2", "um^-2"),
        ("plate.max_amplitude_um", "um"),
        ("speed_mm_s", "mm/s"),
        ("controller.rate_hz", "Hz"),
        ("controller.delay_s", "s"),
        ("sensor.noise_rms_n", "N"),
        ("stroke_m", "m"),
        ("controller.kp", "N/N"),
        ("ki", "1/s"),
        ("controller.k1", "N^0.5/s"),
        ("controller.k2", "N/s^2"),
        ("controller.model.table_size", ""),
        ("setpoint.kind", ""),
        ("delay_s.kind", ""),  # only the last word counts
        ("gain", ""),  # ends in n, without the underscore
        ("", ""),
    ],
)
def test_the_suffix_tells_the_unit(name, unit):
    assert unit_of(name) == unit


def test_bad_values_can_be_caught_as_value_errors():
    assert issubclass(FrictionloopError, ValueError)
