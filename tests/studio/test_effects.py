"""Effects on the page: painted, dropped, chosen from the gallery, and hatched where they will not arrive."""

from __future__ import annotations

import base64

import numpy as np
import pytest
from live_engines import GRATING, Echo
from studio_files import png
from studio_pages import opened, seen, until

import frictionloop as fl
from frictionloop.live.live_session import Session
from frictionloop.rendering.force_tables import Map
from frictionloop.studio import effect_feasibility
from frictionloop.studio.effect_feasibility import BEYOND, STEEP, WEAK, previewed
from frictionloop.studio.effect_pictures import BLACK_N, WHITE_N, force_over, gallery
from frictionloop.studio.room import Room


def room_of(system=GRATING):
    room = Room(Session(Echo()))
    room.session.engine.system, room.session.ghost_on = system, False
    return room


def effect(room):
    return room.session.engine.system.setpoint.effect


def level(n):
    return GRATING.evolve({"setpoint.effect": fl.rendering.Constant(level_n=n)})


@pytest.mark.slow
def test_what_will_not_arrive_has_its_reasons():
    """A level above the finger's friction, a step that no skin follows, and a slope too slow to be felt."""
    beyond = previewed(level(1.5).evolve({"friction.nominal_n": 0.6, "controller.model.nominal_n": 2.0}), 80.0, 0.5)
    assert beyond["shares"] == {"beyond": pytest.approx(1.0, abs=0.05), "steep": 0.0, "weak": 0.0}
    assert set(beyond["reasons"][0]) <= {0, BEYOND}
    step = fl.rendering.Edge(from_n=0.3, to_n=0.6, width_mm=0.05)
    steep = previewed(GRATING.evolve({"setpoint.effect": step}), 80.0, 0.5)
    where = np.flatnonzero(np.array(steep["reasons"][0]) & STEEP)
    assert 0 < where.size < 5
    assert np.abs(steep["from_mm"] + steep["step_mm"] * where).max() < 1.0
    slow = previewed(GRATING.evolve({"setpoint.effect": fl.rendering.Gradient()}), 20.0, 0.5)
    assert slow["shares"]["weak"] > 0.2
    assert set(slow["reasons"][0]) <= {0, WEAK}


@pytest.mark.slow
def test_what_will_not_arrive_on_another_line_is_known_too():
    """The upper half asks for more than the finger has; the stroke that is tried runs along the lower one."""
    halves = Map(values_n=[[0.4, 0.4], [0.4, 0.4], [1.5, 1.5], [1.5, 1.5]], pitch_mm=10.0, start_y_mm=-15.0)
    system = level(0.4).evolve({"setpoint.effect": halves, "setpoint.track.y_mm": -10.0, "friction.nominal_n": 0.6})
    told = previewed(system, 80.0, 0.5)
    height = told["bottom_mm"] + told["row_mm"] * np.arange(len(told["reasons"]))
    share = np.mean(np.array(told["reasons"]) & BEYOND > 0, axis=1)
    assert (height[0], height[-1]) == (-29.5, 29.5)
    assert (share[height < -5.0] == 0.0).all()
    assert (share[height > 5.0] > 0.9).all()


def test_a_look_ahead_that_dies_is_told_and_takes_nothing_with_it(monkeypatch):
    def dies(*asked):
        raise ValueError("no more room")

    monkeypatch.setattr(effect_feasibility, "preview", dies)
    assert previewed(GRATING, 80.0, 0.5)["why"] == "ValueError: no more room"
    assert "must be effect" in previewed(fl.bench(), 80.0, 0.5)["why"]


def test_the_gallery_shows_the_forces_of_every_effect():
    by_name = {each["name"]: np.frombuffer(base64.b64decode(each["picture"]), np.uint8) for each in gallery()}
    assert list(by_name) == list(fl.rendering.LIBRARY)
    wanted = 255 * (fl.rendering.LIBRARY["constant"].level_n - BLACK_N) / (WHITE_N - BLACK_N)
    np.testing.assert_allclose(by_name["constant"], wanted, atol=0.5)
    assert np.unique(by_name["grating"]).size > 20


@pytest.mark.slow
def test_friction_is_painted_erased_and_undone(page, serve):
    room = room_of(level(0.3))
    opened(page, serve(room).url)
    page.click("[data-tool=brush]")
    page.locator("#brush-n").fill("0.6")
    box = page.locator("#plate").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x - 40, y)
    page.mouse.down()
    page.mouse.move(x + 40, y, steps=8)
    page.mouse.up()
    until(lambda: isinstance(effect(room), Map))
    places = np.array([-20.0, 0.0, 8.0, 20.0])
    line = force_over(room.session.engine.system.setpoint, places, np.array([0.0, 8.0]))
    np.testing.assert_allclose(line, [[0.3, 0.6, 0.6, 0.3], [0.3, 0.3, 0.3, 0.3]], atol=0.005)
    assert page.is_visible("#own-effect")
    assert room.session.finger.load_n == 0.0
    painted = effect(room)
    page.click("[data-tool=eraser]")
    page.mouse.click(x, y)
    until(lambda: effect(room) != painted)
    line = force_over(room.session.engine.system.setpoint, np.array([0.0, 8.0]), np.array([0.0]))
    np.testing.assert_allclose(line, [[0.3, 0.6]], atol=0.005)
    page.click("#undo")
    page.click("#undo")
    until(lambda: effect(room) == level(0.3).setpoint.effect)


@pytest.mark.slow
def test_paint_that_is_refused_is_not_left_on_the_plate(page, serve):
    page.excused = ("400",)
    room = room_of(fl.bench())
    opened(page, serve(room).url)
    page.click("[data-tool=brush]")
    page.click("#plate")
    until(lambda: "setpoint.kind" in page.text_content("#status"))
    assert room.session.engine.system == fl.bench()


@pytest.mark.slow
def test_the_keyboard_paints_too(page, serve):
    room = room_of(level(0.3))
    opened(page, serve(room).url)
    page.focus("[data-tool=slide]")
    page.keyboard.press("ArrowRight")
    page.focus("#plate")
    page.keyboard.press("ArrowRight")
    page.keyboard.press("Enter")
    until(lambda: isinstance(effect(room), Map))
    line = force_over(room.session.engine.system.setpoint, np.array([-10.0, 2.0]), np.array([0.0]))
    np.testing.assert_allclose(line, [[0.3, 0.6]], atol=0.005)


@pytest.mark.slow
def test_a_picture_is_asked_about_and_laid_on_the_plate(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    dropped = """(bytes) => {
      const file = new File([Uint8Array.from(bytes)], 'leaf.png', { type: 'image/png' }), data = new DataTransfer();
      data.items.add(file);
      document.querySelector('#plate').dispatchEvent(new DragEvent('drop', { dataTransfer: data, bubbles: true }));
    }"""
    page.evaluate(dropped, list(png(np.tile([0, 255], (20, 10)))))
    until(lambda: page.is_visible("#bring"))
    page.click("#bring .main")
    assert page.is_visible("#bring")  # neither scale nor polarity is assumed
    page.fill("[name=mm_per_pixel]", "0.8")
    assert "16.0 × 16.0 mm" in page.text_content("#bring-size")
    page.check("[name=polarity][value=dark]")
    page.click("#bring .main")
    until(lambda: isinstance(effect(room), Map))
    assert effect(room).pitch_mm == 0.8
    assert effect(room).values_n[0][:2] == (0.6, 0.3)
    until(lambda: page.is_hidden("#bring"))
    until(lambda: "20 x 20" in page.text_content("#status"))


@pytest.mark.slow
def test_what_cannot_be_read_is_told_in_the_dialog(page, serve):
    page.excused = ("400",)
    opened(page, serve(room_of()).url)
    page.set_input_files("#effect-file", {"name": "bad.wav", "mimeType": "audio/wav", "buffer": b"RIFFnonsense"})
    for name, value in (("speed_mm_s", "40"), ("scale_n", "0.3")):
        page.fill(f"[name={name}]", value)
    page.click("#bring .main")
    until(lambda: "recording" in page.text_content("#bring-why"))
    page.click("#bring-cancel")
    page.set_input_files("#effect-file", {"name": "notes.txt", "mimeType": "text/plain", "buffer": b"x"})
    until(lambda: "a PNG or a WAV" in page.text_content("#status"))


@pytest.mark.slow
def test_the_overlay_says_what_will_not_arrive(page, serve):
    room = room_of(level(0.9).evolve({"friction.nominal_n": 0.5}))
    opened(page, serve(room).url)
    until(lambda: "out of this finger's reach" in page.text_content("#ahead-told"))
    page.uncheck("#ahead")
    seen(page, "document.querySelector('#ahead-told').textContent === ''")
    page.check("#ahead")
    until(lambda: "out of this finger's reach" in page.text_content("#ahead-told"))
    page.click("[data-effect=constant]")
    page.click("#presets-open")
    page.click("text=Usual finger")
    until(lambda: "within reach" in page.text_content("#ahead-told"))


@pytest.mark.slow
def test_a_preset_is_one_press(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.click("#presets-open")
    page.click("text=Weak plate")
    until(lambda: room.session.engine.system.plate.max_amplitude_um == pytest.approx(1.2))
    page.click("text=Recommended law")
    until(lambda: room.session.engine.system.controller.kind == "notch_pi")
