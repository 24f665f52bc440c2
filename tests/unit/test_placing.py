"""Systems of a tile: placed without checks they are what `evolve` makes; and what lanes share is asked once."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import BaseModel

import frictionloop as fl
from frictionloop.loop.kernel.columns import column
from frictionloop.loop.kernel.placing import placed
from frictionloop.parameters.description import _values

CASES = {
    "two gains": [{"controller.kp": float(k), "controller.ki": 2.0} for k in (1, 2, 3)],
    "several blocks": [{"plate.max_amplitude_um": 2.0, "controller.model.nominal_n": n} for n in (0.8, 0.9)],
    "another kind": [{"controller.kind": "lookup"}, {"controller.kind": "pi", "controller.kp": 3.0}],
    "different paths": [{"controller.kp": 1.0}, {"friction.nominal_n": 1.1}, {}],
}


@pytest.mark.parametrize("system", [fl.paper(), fl.bench()], ids=["paper", "bench"])
@pytest.mark.parametrize("overrides", CASES.values(), ids=CASES)
def test_placed_systems_are_those_that_evolve_makes(system, overrides):
    found = placed(system, overrides)
    for made, override in zip(found, overrides, strict=True):
        wanted = system.evolve(override)
        assert made == wanted
        assert made.model_dump() == wanted.model_dump()
    assert system == type(system).model_validate(system.model_dump())  # nothing was written into the one they share


def test_blocks_that_no_path_enters_stay_one_object():
    system = fl.paper()
    one, other = placed(system, [{"controller.kp": 1.0}, {"controller.kp": 2.0}])
    assert one.plate is other.plate is system.plate
    assert one.controller is not other.controller
    assert one.controller.model is system.controller.model


def test_a_column_is_asked_once_of_a_shared_object():
    shared, asked = object(), []
    assert column([shared] * 4, lambda each: asked.append(each) or 3.0).shape == (1,)
    assert len(asked) == 1
    np.testing.assert_array_equal(column([1.0, 2.0], lambda x: (x, -x)), [[1.0, 2.0], [-1.0, -2.0]])


@pytest.mark.parametrize("system", [fl.paper(), fl.bench()], ids=["paper", "bench"])
def test_a_block_is_read_as_pydantic_dumps_it(system):
    for name in type(system).model_fields:
        block = getattr(system, name)
        if isinstance(block, BaseModel):
            assert _values(block) == block.model_dump()
