"""No field of a block is silently without effect: a model of the loop has it, leaves it out knowingly, or refuses."""

from __future__ import annotations

from typing import Literal

import pytest
from kinds import kinds_of
from pydantic import BaseModel

import frictionloop as fl
from frictionloop.analysis.elements import LINEAR, elements
from frictionloop.firmware.compiled_core import FIRMWARE
from frictionloop.firmware.parameter_words import device_words
from frictionloop.loop.kernel.quadrature import QUADRATURE
from frictionloop.loop.kernel.structure import kernel_of
from frictionloop.parameters.represented import Represented
from frictionloop.physics.vibration import GAUSSIAN, vibration_of

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
