"""A law and a friction law from outside are panels like those of the package: chosen by name, changed by slider."""

from __future__ import annotations

from typing import Literal, NamedTuple

import pytest
from live_engines import GRATING, Echo
from studio_pages import opened, until

import frictionloop as fl
from frictionloop.device.live_session import Session
from frictionloop.loop.blocks import forget
from frictionloop.studio.panels import panels_of
from frictionloop.studio.room import Room
from frictionloop.studio.share import as_python


class HalfController(fl.Timing):
    kind: Literal["half"] = "half"
    share: float = 0.5
    """Share of the wish that is commanded."""


class State(NamedTuple):
    nothing: float


class Gains(NamedTuple):
    share: float
    low: float
    high: float


@fl.step
def half(state, measured, setpoint_n, gains, dt):
    v = gains.share * setpoint_n
    u = min(max(v, gains.low), gains.high)
    return state, fl.ForceCommand(u, 1.0 if u != v else 0.0)


@pytest.fixture
def own():
    fl.register(fl.Law("half", half, State, Gains), HalfController)
    yield
    forget()


def by_path(system, box):
    return {field["path"]: field for field in panels_of(system)[box]}


def test_a_law_from_outside_has_its_name_its_fields_and_their_meaning(own):
    assert "half" in by_path(GRATING, "controller")["controller.kind"]["choices"]
    mine = GRATING.evolve({"controller.kind": "half", "controller.share": 0.7})
    share = by_path(mine, "controller")["controller.share"]
    assert (share["value"], share["low"], share["high"]) == (0.7, 0.0, pytest.approx(3.5))
    assert share["means"] == "Share of the wish that is commanded."
    assert "\"controller.kind\": 'half'" in as_python(mine)


@pytest.mark.slow
def test_it_is_chosen_and_changed_on_the_page(page, serve, own):
    room = Room(Session(Echo()))
    opened(page, serve(room).url)
    page.select_option(".field:has([title='controller.kind']) select", "half")
    until(lambda: room.session.engine.system.controller.kind == "half")
    field = page.locator(".field:has([title='controller.share']) input[type=number]")
    field.fill("0.8")
    field.press("Enter")
    until(lambda: room.session.engine.system.controller.share == pytest.approx(0.8))
