"""Units carried by names."""

from __future__ import annotations

import importlib
from pkgutil import iter_modules

from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel

from frictionloop import parameters
from frictionloop.quantities import FrictionloopError, unit_of

UNITS = {
    "um^-2": "friction.susceptibility_per_um2", "um": "plate.max_amplitude_um", "mm/s": "speed_mm_s",
    "Hz": "controller.rate_hz", "s": "controller.delay_s", "N": "sensor.noise_rms_n", "m": "stroke_m",
    "N/s": "rate_n_s", "m/s^2": "gravity_m_s2", "m/s^2/rtHz": "vibration_m_s2_rthz", "1/rtHz": "noise_rthz",
    "N s/m": "damping_n_s_m resistance_n_s_per_m", "N/count": "n_per_count", "N/(V m)": "e31_n_per_vm",
    "kg/m^3": "density_kg_per_m3", "um/N": "compliance_um_per_n", "N/N": "controller.kp", "1/s": "ki",
    # Only the last word counts, and gain ends in n without the underscore.
    "": "word_count controller.model.table_size setpoint.kind delay_s.kind gain",
}  # fmt: skip


def test_the_suffix_tells_the_unit():
    assert {name: unit_of(name) for names in UNITS.values() for name in names.split()} == {
        name: unit for unit, names in UNITS.items() for name in names.split()
    }
    assert unit_of("") == ""


ALONE = {"n": "N", "mm": "mm", "um": "um", "s": "s", "hz": "Hz", "kg": "kg", "v": "V", "deg": "deg", "count": "count"}


@given(st.sampled_from(sorted(ALONE)), st.sampled_from(sorted(ALONE)), st.sampled_from(["_", "_per_"]))
def test_a_unit_over_another_has_both(above, below, between):
    assert unit_of(f"some_rate_{above}{between}{below}") == f"{ALONE[above]}/{ALONE[below]}"


def test_every_word_of_a_fields_unit_is_in_it():
    """Read from the end, by hand: a word that is a unit is in the unit, whatever comes after it."""
    modules = [
        importlib.import_module(f"{parameters.__name__}.{each.name}") for each in iter_modules(parameters.__path__)
    ]
    blocks = [each for module in modules for each in vars(module).values() if isinstance(each, type)]
    names = {name for block in blocks if issubclass(block, BaseModel) for name in block.model_fields}
    assert len(names) > 200
    for name in names:
        words, unit = name.split("_")[1:], unit_of(name)
        while words and (words[-1] in ALONE or words[-1] == "per"):
            assert words[-1] == "per" or ALONE[words[-1]] in unit, name
            words.pop()


def test_bad_values_can_be_caught_as_value_errors():
    assert issubclass(FrictionloopError, ValueError)
