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
        ("obsever", "^laws: 'obsever' .*did you mean observer.*lookup, retuned_pi, observer$"),
        ("xyz", "^laws: 'xyz' is unknown; accepted: lookup, retuned_pi, observer$"),
    ],
)
def test_an_unknown_name_is_told_with_near_ones(name, line):
    with pytest.raises(FrictionloopError, match=line):
        check_known("laws", ["lookup", name], THERE)


@pytest.mark.parametrize(("names", "said"), [((), "''"), (("a", "b", "a"), "'a,b,a'")])
def test_none_or_twice_is_refused(names, said):
    with pytest.raises(FrictionloopError, match=f"^laws = {said}: "):
        check_each_once("laws", "law", names)
