"""A law and a friction law from outside are panels like those of the package: chosen by name, changed by slider."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest
from half_law import Gains, HalfController, State, half
from live_engines import GRATING, Echo
from studio_pages import opened, until

import frictionloop as fl
from frictionloop.live.live_engines import TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.loop.registered_blocks import forget
from frictionloop.studio.commands import obey
from frictionloop.studio.connections import Guest
from frictionloop.studio.effect_pictures import gallery
from frictionloop.studio.parameter_panels import as_python, differences, panels_of, system_message
from frictionloop.studio.room import Room


@pytest.fixture
def own():
    fl.register(fl.Law("half", half, State, Gains), HalfController)
    yield
    forget()


class Waves(fl.rendering.Effect):
    kind: Literal["waves"] = "waves"
    length_mm: float = 5.0
    """Distance from crest to crest."""

    @property
    def is_static(self):
        return True

    def force_of(self, touch):
        return 0.45 + 0.1 * np.sin(2 * np.pi * np.asarray(touch.x_mm) / self.length_mm)


class Unfinished(Waves):
    kind: Literal["unfinished"] = "unfinished"
    depth_n: float


def test_an_effect_from_outside_is_in_the_gallery_and_its_fields_are_sliders():
    kinds = fl.rendering.EFFECTS
    kinds.register(Waves)
    kinds.register(Unfinished)
    try:
        names = [each["name"] for each in gallery()]
        assert names == [*fl.rendering.LIBRARY, "waves"]  # the other one has no value for its depth
        room = Room(Session(Echo()))
        room.join(guest := Guest(may_drive=True))
        obey(room, guest, {"do": "effect", "name": "waves"})
        system = room.session.engine.system
        assert system.setpoint.effect == Waves()
        assert by_path(system, "wish")["setpoint.effect.length_mm"]["means"] == "Distance from crest to crest."
        assert system_message(system)["effect"] == "waves"
        live = Session(TwinEngine(system))
        live.step(0.0)
        rows = np.concatenate([block.rows for block in live.step(0.4)], axis=1)
        np.testing.assert_allclose(rows[2, -500:], Waves().force_of(fl.rendering.Touch(rows[0, -500:])), atol=0.02)
    finally:
        kinds.forget()


def by_path(system, box):
    return {field["path"]: field for field in panels_of(system)[box]}


def test_a_law_from_outside_has_its_name_its_fields_and_their_meaning(own):
    assert "half" in by_path(GRATING, "controller")["controller.kind"]["choices"]
    mine = GRATING.evolve({"controller.kind": "half", "controller.share": 0.7})
    share = by_path(mine, "controller")["controller.share"]
    assert (share["value"], share["low"], share["high"]) == (0.7, 0.0, pytest.approx(3.5))
    assert share["means"] == "Share of the wish that is commanded."
    assert "\"controller.kind\": 'half'" in as_python(mine, differences(mine))


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
