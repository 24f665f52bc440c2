"""Fields of the panels: every parameter of a System has one."""

from __future__ import annotations

import pytest
from live_engines import GRATING

import frictionloop as fl
from frictionloop.parameters.block import Block
from frictionloop.studio.parameter_panels import panels_of


def changed_by(fields):
    return {path for each in fields for path in each.get("columns") or [each["path"]]}


@pytest.mark.parametrize(
    "kinds",
    [{}, {"controller.kind": "filtered_pi", "disturbance.kind": "steps"}, {"controller.kind": "limit_observer"}],
    ids=["grating", "lists", "limit_observer"],
)
def test_every_parameter_has_a_field(kinds):
    system = GRATING.evolve(kinds)
    told = changed_by(field for fields in panels_of(system).values() for field in fields)

    def paths(block, at=""):
        for name in type(block).model_fields:
            value = getattr(block, name)
            if isinstance(value, Block):
                yield from paths(value, f"{at}{name}.")
            elif name != "kind":
                yield f"{at}{name}"

    assert set(paths(system)) <= told


@pytest.mark.parametrize(
    ("path", "value", "shown"),
    [
        ("board.force_zero_counts", (112, 0), [(112,), (0,)]),
        ("controller.model.table_um2", (), []),
        (
            "setpoint.effect",
            fl.rendering.Map(values_n=[[0.1, 0.2], [0.3, 0.4]], pitch_mm=1.0),
            [(0.1, 0.2), (0.3, 0.4)],
        ),
        ("controller.sections", ((1.0, 0.0, 0.0, 0.5, 0.0),), [(1.0, 0.0, 0.0, 0.5, 0.0)]),
    ],
)
def test_a_list_is_shown_as_rows_of_numbers(path, value, shown):
    system = GRATING.evolve({"controller.kind": "filtered_pi"}).evolve({path: value})
    path += ".values_n" * (path == "setpoint.effect")
    (field,) = (each for fields in panels_of(system).values() for each in fields if each["path"] == path)
    assert list(field["value"]) == shown


@pytest.mark.parametrize(("value", "slides"), [(None, False), (1.5, True)])
def test_a_number_that_is_left_out_can_be_typed_and_has_no_slider(value, slides):
    fields = panels_of(GRATING.evolve({"board.ceiling_um": value}))["board"]
    (field,) = (each for each in fields if each["path"] == "board.ceiling_um")
    assert field["value"] == value
    assert (field["high"] is not None) == slides
    assert "choices" not in field
