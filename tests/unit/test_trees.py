"""Named tuples as rows of numbers and back: any shape, any numbers, nothing lost and nothing moved."""

from __future__ import annotations

from typing import NamedTuple

import pytest
from hypothesis import given
from hypothesis import strategies as st

import frictionloop as fl
from frictionloop.control.laws import LAWS
from frictionloop.quantities import flat_tuples


class Memory(NamedTuple):
    s1: float
    s2: float


class State(NamedTuple):
    integral: float
    first: Memory
    inner: Memory
    last: float


def named(parts):
    """A named tuple class with these parts, each float or a class."""
    return NamedTuple("Shape", [(f"part_{i}", part) for i, part in enumerate(parts)])


shapes = st.recursive(st.just(float), lambda inner: st.lists(inner, max_size=4).map(named), max_leaves=20).filter(
    lambda shape: shape is not float
)
numbers = st.floats(allow_nan=False) | st.integers(-5, 5)


@given(st.data(), shapes)
def test_a_row_becomes_the_shape_and_the_row_again(data, shape):
    row = data.draw(st.lists(numbers, min_size=flat_tuples.size(shape), max_size=flat_tuples.size(shape)))
    value = flat_tuples.shaped(shape, row)
    assert flat_tuples.flat(value) == row
    assert flat_tuples.shaped(shape, flat_tuples.flat(value)) == value
    assert_is(value, shape)


def assert_is(value, shape):
    """Each part is of its class, all the way down."""
    assert type(value) is shape
    for name, inner in flat_tuples.parts(shape):
        if inner is not None:
            assert_is(getattr(value, name), inner)


@given(st.data(), shapes.filter(flat_tuples.size))
def test_a_name_leads_to_its_number(data, shape):
    value, names = flat_tuples.shaped(shape, range(flat_tuples.size(shape))), flat_tuples.names(shape)
    assert len(set(names)) == len(names) == flat_tuples.size(shape)
    place = data.draw(st.integers(0, len(names) - 1))
    reached = value
    for part in names[place].split("."):
        reached = getattr(reached, part)
    assert reached == place


def test_by_hand():
    value = State(1.0, Memory(2.0, 3.0), Memory(4.0, 5.0), 6.0)
    assert flat_tuples.flat(value) == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]
    assert flat_tuples.shaped(State, range(1, 7)) == value
    assert flat_tuples.names(State) == ("integral", "first.s1", "first.s2", "inner.s1", "inner.s2", "last")
    assert flat_tuples.parts(State) == (("integral", None), ("first", Memory), ("inner", Memory), ("last", None))
    assert flat_tuples.size(State) == 6


def test_numbers_that_are_left_over_are_not_read():
    assert flat_tuples.shaped(Memory, range(9)) == Memory(0, 1)


@pytest.mark.parametrize("kind", LAWS)
def test_gains_and_states_of_every_law(kind):
    law, controller = LAWS[kind], fl.bench().evolve({"controller.kind": kind}).controller
    for value, shape in ((law.gains_for(controller), law.gains), (law.start_for(controller), law.state)):
        assert_is(value, shape)
        assert flat_tuples.shaped(shape, flat_tuples.flat(value)) == value
        assert all(isinstance(number, (int, float)) for number in flat_tuples.flat(value))
    assert flat_tuples.names(law.gains)[-2:] == ("low", "high")
