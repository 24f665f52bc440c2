"""Fields without effect and names that no parameter has are refused, with what is meant."""

from __future__ import annotations

import math
from typing import Literal

import pytest
from kinds import kinds_of
from pydantic import BaseModel

import frictionloop as fl
from frictionloop.analysis.loop_elements import LINEAR, elements
from frictionloop.firmware.compiled_core import FIRMWARE
from frictionloop.firmware.parameter_words import device_words
from frictionloop.loop.kernel.period_quadrature import QUADRATURE
from frictionloop.loop.kernel.tile_compatibility import kernel_of
from frictionloop.parameters.aliases import GUESSES
from frictionloop.parameters.block import Represented
from frictionloop.physics.vibration import GAUSSIAN, vibration_of
from frictionloop.quantities import check_each_once, check_known

PLANT = ("friction", "plate", "finger", "motion")
SEEN = {LINEAR: (*PLANT, "sensor", "controller", "touch"), FIRMWARE: ("touch", "board")}
INNER = {"controller": [fl.Model], "touch": [fl.PositionSensor, fl.LoadCells]}
KINDS = {name: [*kinds_of(name), *INNER.get(name, ())] for names in SEEN.values() for name in names}
BLOCKS = [(of, block) for of, names in SEEN.items() for name in names for block in KINDS[name]]


def has_its_own(block: type[BaseModel]) -> bool:
    """Tell whether a friction law is not on the lists, for it is known by its own step."""
    return issubclass(block, fl.FrictionLimit) and vibration_of(block()) is not GAUSSIAN


BLOCKS = [each for each in BLOCKS if not has_its_own(each[1])]


def listed(of: Represented, block: type[BaseModel]) -> list[str]:
    lists = [fields.get(each, "").split() for each in block.__mro__ for fields in (of.fields, of.left_out)]
    return [name for names in lists for name in names]


def test_every_field_is_on_a_list():
    for of, block in BLOCKS:
        assert set(block.model_fields) == set(listed(of, block)), (of.what, block)
    assert len(BLOCKS) > 20


def test_no_list_has_a_field_that_is_gone_or_on_both():
    for of in (LINEAR, FIRMWARE, QUADRATURE):
        for block, names in [*of.fields.items(), *of.left_out.items()]:
            assert set(names.split()) <= set(block.model_fields), (of.what, block)
        for block in of.fields.keys() & of.left_out.keys():
            assert not set(of.fields[block].split()) & set(of.left_out[block].split()), (of.what, block)


class Softer(fl.ResonantPlate):
    """As if a field had been added to the plate."""

    softening_per_um: float = 0.0


Softer.__module__ = "frictionloop.parameters.plant"


class Piezo(Softer):
    """As if a kind had been added."""

    kind: Literal["piezo"] = "piezo"  # type: ignore[assignment]


Piezo.__module__ = "frictionloop.parameters.plant"


def with_plate(system: fl.System, plate: BaseModel) -> fl.System:
    return system.model_copy(update={"plate": plate})


def test_a_new_field_of_the_plate_is_refused_unless_it_has_its_default():
    elements(with_plate(fl.bench(), Softer()))
    with pytest.raises(fl.FrictionloopError, match=r"plate\.softening_per_um = 0\.1: .*0\.0"):
        elements(with_plate(fl.bench(), Softer(softening_per_um=0.1)))
    with pytest.raises(fl.FrictionloopError, match=r"plate\.kind = 'piezo': "):
        elements(with_plate(fl.bench(), Piezo()))


def test_the_rule_for_the_papers_loop_is_for_what_it_knows():
    assert kernel_of(fl.paper()) == "quadrature"
    assert kernel_of(with_plate(fl.paper(), Softer(softening_per_um=0.1))) == "substeps"


class Derived(fl.PiController):
    """As if a gain had been added to PI."""

    kd: float = 0.0


Derived.__module__ = "frictionloop.parameters.controller"


def test_a_new_gain_is_refused_where_the_linear_law_does_not_have_it():
    system = fl.paper().model_copy(update={"controller": Derived(kd=0.5)})
    with pytest.raises(fl.FrictionloopError, match=r"controller\.kd = 0\.5: "):
        elements(system)


def test_inner_blocks_are_looked_at_too():
    class Cells(fl.LoadCells):
        gain: float = 1.0

    Cells.__module__ = "frictionloop.parameters.motion"
    system = fl.bench().model_copy(update={"touch": fl.Touch().model_copy(update={"load": Cells(gain=2.0)})})
    for form in (elements, device_words):
        with pytest.raises(fl.FrictionloopError, match=r"touch\.load\.gain = 2\.0"):
            form(system)


BENCH = fl.bench()


def complaint(overrides, system=BENCH):
    with pytest.raises(fl.FrictionloopError) as caught:
        system.evolve(overrides)
    return str(caught.value)


def test_all_unknown_names_are_told_at_once_a_line_each():
    first, *lines = complaint({"sensor.damping": 0.02, "plate.zzz": 1.0, "controller.kp": 3.0}).splitlines()
    assert first == "2 unknown parameters:"
    assert [line.split(":")[0] for line in lines] == ["  'sensor.damping'", "  'plate.zzz'"]
    assert "sensor.q = 25 (Q = 1/(2 damping))" in lines[0]


def test_a_file_names_the_line_of_each(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text('preset = "bench"\n[sensor]\nzeta = 0.02\n[controller]\nKp = 3\nrate_hz = 4000\n')
    with pytest.raises(fl.FrictionloopError) as caught:
        fl.read_toml(path)
    first, *lines = str(caught.value).splitlines()
    assert first == f"{path}: 2 unknown parameters:"
    assert [line.rpartition("(line ")[2] for line in lines] == ["3: 'zeta = 0.02')", "5: 'Kp = 3')"]


def test_a_whole_file_and_a_constructor_tell_all_too(tmp_path):
    path = tmp_path / "bench.toml"
    path.write_text("\n".join(fl.to_toml(BENCH).splitlines()).replace("\nmoving_mass_kg", "\nmass"))
    path.write_text(path.read_text().replace("\nresonance_hz", "\nf0", 1))
    with pytest.raises(fl.FrictionloopError, match=r"2 unknown parameters:\n.*'sensor.mass'.*\n.*'sensor.f0'"):
        fl.read_toml(path)
    with pytest.raises(fl.FrictionloopError, match=r"SuspendedSensor: 2 unknown parameters:\n  'damping'.*\n  'mass'"):
        fl.SuspendedSensor(damping=0.02, mass=0.25)


def test_a_conversion_takes_what_other_unknown_names_say():
    told = complaint({"sensor.stiffness": 1e5, "sensor.mass": 0.25, "sensor.noise_mn": 5.0, "sensor.pole": 800.0})
    assert f"sensor.resonance_hz = {math.sqrt(1e5 / 0.25) / math.tau:.6g} Hz" in told
    assert "moving_mass_kg = 0.25" in told
    density = 5e-3 / math.sqrt(math.pi / 2 * 800)
    sensor = BENCH.evolve({"sensor.cutoff_hz": 800.0, "sensor.noise_density_n_rthz": density}).sensor
    assert sensor.noise_rms_n == pytest.approx(5e-3)
    assert f"sensor.noise_density_n_rthz = {density:.6g} N/rtHz" in told


@pytest.mark.slow
@pytest.mark.parametrize("given", [0.0, math.nan, math.inf, True, None, [1.0], "x"])
@pytest.mark.parametrize("word", [guess.words.split()[0] for guess in GUESSES])
@pytest.mark.parametrize("block", ["sensor", "plate", "controller"])
def test_no_value_makes_a_hint_fail(block, word, given):
    name = f"{block}.{word}_x"  # never a parameter
    assert repr(name) in complaint({name: given, f"{block}.{word}z": given})
    if word not in ("q", "kp", "filter", "range", "noise"):
        assert complaint({f"{block}.{word}": given}).startswith("unknown parameter")


# Names given out of those there are: what is refused, and how.


THERE = ("lookup", "retuned_pi", "observer")


def test_what_is_there_once_is_accepted():
    check_known("laws", ["observer", "lookup"], THERE)
    check_known("laws", [], THERE)
    check_each_once("laws", "law", ["observer", "lookup"])
