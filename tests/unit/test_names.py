"""Names given out of those there are: what is refused, and how."""

from __future__ import annotations

import pytest

from frictionloop.quantities import FrictionloopError, check_each_once, check_known

THERE = ("lookup", "retuned_pi", "observer")


def test_what_is_there_once_is_accepted():
    check_known("laws", ["observer", "lookup"], THERE)
    check_known("laws", [], THERE)
    check_each_once("laws", "law", ["observer", "lookup"])


@pytest.mark.parametrize(
    ("name", "line"),
    [
        ("obsever", "laws: 'obsever' is unknown; did you mean observer? accepted: lookup, retuned_pi, observer"),
        ("xyz", "laws: 'xyz' is unknown; accepted: lookup, retuned_pi, observer"),
    ],
)
def test_an_unknown_name_is_told_with_near_ones(name, line):
    with pytest.raises(FrictionloopError) as error:
        check_known("laws", ["lookup", name], THERE)
    assert str(error.value) == line


@pytest.mark.parametrize(("names", "said"), [((), "''"), (("a", "b", "a"), "'a,b,a'")])
def test_none_or_twice_is_refused(names, said):
    with pytest.raises(FrictionloopError) as error:
        check_each_once("laws", "law", names)
    assert str(error.value) == f"laws = {said}: must name at least one law, none of them twice"
