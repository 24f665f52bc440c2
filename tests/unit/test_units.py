"""Units carried by names."""

from __future__ import annotations

import importlib
import pkgutil

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from frictionloop import parameters
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
        ("rate_n_s", "N/s"),
        ("gravity_m_s2", "m/s^2"),
        ("vibration_m_s2_rthz", "m/s^2/rtHz"),
        ("noise_rthz", "1/rtHz"),
        ("damping_n_s_m", "N s/m"),
        ("resistance_n_s_per_m", "N s/m"),
        ("n_per_count", "N/count"),
        ("word_count", ""),
        ("e31_n_per_vm", "N/(V m)"),
        ("density_kg_per_m3", "kg/m^3"),
        ("compliance_um_per_n", "um/N"),
        ("controller.kp", "N/N"),
        ("ki", "1/s"),
        ("controller.model.table_size", ""),
        ("setpoint.kind", ""),
        ("delay_s.kind", ""),  # only the last word counts
        ("gain", ""),  # ends in n, without the underscore
        ("", ""),
    ],
)
def test_the_suffix_tells_the_unit(name, unit):
    assert unit_of(name) == unit


ALONE = {"n": "N", "mm": "mm", "um": "um", "s": "s", "hz": "Hz", "kg": "kg", "v": "V", "deg": "deg", "count": "count"}


@given(st.sampled_from(sorted(ALONE)), st.sampled_from(sorted(ALONE)), st.sampled_from(["_", "_per_"]))
def test_a_unit_over_another_has_both(above, below, between):
    assert unit_of(f"some_rate_{above}{between}{below}") == f"{ALONE[above]}/{ALONE[below]}"


FIELDS = sorted(
    {
        name
        for module in pkgutil.iter_modules(parameters.__path__)
        for block in vars(importlib.import_module(f"frictionloop.parameters.{module.name}")).values()
        if isinstance(block, type) and issubclass(block, BaseModel)
        for name in block.model_fields
    }
)


@pytest.mark.parametrize("name", FIELDS)
def test_every_word_of_a_fields_unit_is_in_it(name):
    """Read from the end, by hand: a word that is a unit is in the unit, whatever comes after it."""
    words, unit = name.split("_")[1:], unit_of(name)
    while words and (words[-1] in ALONE or words[-1] == "per"):
        assert words[-1] == "per" or ALONE[words[-1]] in unit
        words.pop()


def test_bad_values_can_be_caught_as_value_errors():
    assert issubclass(FrictionloopError, ValueError)
