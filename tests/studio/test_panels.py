"""Fields of the panels: every parameter of a System has one."""

from __future__ import annotations

import pytest
from live_engines import GRATING

from frictionloop.parameters.block import Block
from frictionloop.studio.panels import panels_of


def test_every_parameter_but_lists_has_a_field():
    told = {field["path"] for fields in panels_of(GRATING).values() for field in fields}

    def paths(block, at=""):
        for name in type(block).model_fields:
            value = getattr(block, name)
            if isinstance(value, Block):
                yield from paths(value, f"{at}{name}.")
            elif name != "kind" and not isinstance(value, tuple):
                yield f"{at}{name}"

    assert set(paths(GRATING)) <= told


@pytest.mark.parametrize(("value", "slides"), [(None, False), (1.5, True)])
def test_a_number_that_is_left_out_can_be_typed_and_has_no_slider(value, slides):
    fields = panels_of(GRATING.evolve({"board.ceiling_um": value}))["board"]
    (field,) = (each for each in fields if each["path"] == "board.ceiling_um")
    assert field["value"] == value
    assert (field["high"] is not None) == slides
    assert "choices" not in field
