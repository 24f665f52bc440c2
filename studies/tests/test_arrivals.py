"""How much of effects arrives: what is stored is what is found, and what is kept is not run again."""

from __future__ import annotations

import pytest

from frictionloop.report.effect_arrivals import SPEEDS_MM_S, stored
from studies.arrivals import FINGERS, run


@pytest.mark.timeout(600)
@pytest.mark.parametrize(
    ("laws", "effects"),
    [
        (["retuned_pi"], ["bump"]),
        pytest.param(["lookup", "retuned_pi"], ["bump", "grating"], marks=pytest.mark.soak),
    ],
    ids=["one", "some"],
)
def test_what_is_stored_is_what_is_found(laws, effects, tmp_path):
    found = run(laws, tmp_path / "kept.json", FINGERS, effects)
    for law in laws:
        for effect in effects:
            there = stored().laws[law][effect]
            assert {name: pytest.approx(list(there[name]), rel=0.01) for name in there} == found["laws"][law][effect]


def test_it_goes_on_where_it_was_stopped(tmp_path):
    path = tmp_path / "kept.json"
    first = run(["lookup"], path, 6, ["bump"])
    path.write_text(path.read_text().replace('"contrast": ', '"contrast": 7'))
    again = run(["lookup"], path, 6, ["bump", "edge"])["laws"]["lookup"]
    assert all(each > 70 for each in again["bump"]["contrast"]) and len(again["edge"]["contrast"]) == len(SPEEDS_MM_S)
    assert again["bump"]["spread_n"] == first["laws"]["lookup"]["bump"]["spread_n"]
