"""The page in a real browser: drag and read the force, compare, download, come back, be told what is wrong."""

from __future__ import annotations

import numpy as np
import pytest
from live_engines import GRATING, Echo
from studio_files import wav
from studio_pages import opened, room_of, seen, until

import frictionloop as fl
from frictionloop.live.live_engines import TwinEngine
from frictionloop.studio.connections import Doors

pytestmark = pytest.mark.slow
LOST = "WebSocket", "ERR_CONNECTION", "403", "404"
"""What a browser itself says of a server that is gone or does not let it in."""


def drag(page, strokes=3, half_px=220):
    box = page.locator("#plate").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x - half_px, y)
    page.mouse.down()
    for stroke in range(strokes):
        for step in range(60):
            way = (step + 1) / 60 if stroke % 2 == 0 else 1 - (step + 1) / 60
            page.mouse.move(x - half_px + 2 * half_px * way, y)
            page.wait_for_timeout(16)


def test_a_drag_moves_the_finger_and_shows_what_both_loops_give(page, serve):
    """On a finger that the model does not know: closed follows the grating, open does not."""
    room = room_of(TwinEngine(GRATING.evolve({"friction.nominal_n": 1.3})))
    opened(page, serve(room).url)
    follows = False
    for _ in range(5):  # a loaded machine moves the mouse by jerks, or loses the finger for a moment
        drag(page, strokes=2)
        closed, open_ = (page.text_content(f"[data-number={name}_error_n]") for name in ("closed", "open"))
        follows = closed != "–" and float(closed.removesuffix(" mN")) < 0.5 * float(open_.removesuffix(" mN"))
        if follows:
            break
    page.mouse.up()
    assert follows, (closed, open_)
    assert not page.text_content("#verdict").startswith("Slide")
    until(lambda: room.session.finger.load_n == 0.0)


def test_the_place_under_the_mouse_is_the_place_of_the_finger(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    box = page.locator("#plate").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2 + 96.0, box["y"] + 60.0)
    page.mouse.down()
    until(lambda: room.session.finger.load_n > 0.4)
    assert room.session.finger.x_mm == pytest.approx(25.4, abs=0.2)


def test_a_finger_on_a_touch_screen_moves_it_too(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    box, line = page.locator("#plate").bounding_box(), page.context.new_cdp_session(page)
    x, y = box["x"] + box["width"] / 2, box["y"] + 80

    def touch(kind, *points):
        line.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": at, "y": y} for at in points]})

    touch("touchStart", x)
    for step in range(30):
        touch("touchMove", x + 4 * step)
        page.wait_for_timeout(16)
    assert room.session.finger.x_mm > 20.0
    touch("touchEnd")
    until(lambda: room.session.finger.load_n == 0.0)


def test_the_keyboard_alone_strokes_and_stops(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.locator("#plate").focus()
    page.keyboard.down("ArrowRight")
    until(lambda: room.session.finger.x_mm > 10.0)
    page.keyboard.up("ArrowRight")
    page.keyboard.press("Space")
    until(lambda: room.session.stopped and room.session.finger.load_n == 0.0)
    seen(page, "document.querySelector('#stop').textContent === 'Go'")


def test_every_panel_changes_what_it_says(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    for box, path, value in (
        ("wish", "setpoint.effect.spacing_mm", 3.5),
        ("controller", "controller.delay_s", 0.0001),
        ("plate", "plate.max_amplitude_um", 2.0),
        ("friction", "friction.nominal_n", 1.25),
        ("sensor", "sensor.resonance_hz", 180.0),
        ("motion", "motion.stroke_mm", 50.0),
        ("board", "board.ramp_s", 0.02),
        ("board", "board.ceiling_um", 1.5),
        ("disturbance", "disturbance.offset_n", 0.05),
    ):
        page.click(f"[data-box={box}]")
        field = page.locator(f".field:has([title='{path}']) input[type=number]")
        field.fill(str(value))
        field.press("Enter")

        def there(path=path):
            node = room.session.engine.system
            for name in path.split("."):
                node = getattr(node, name)
            return node

        until(lambda there=there, value=value: there() == pytest.approx(value))
    page.click("#undo")
    until(lambda: room.session.engine.system.disturbance.offset_n == 0.0)


def test_a_list_is_changed_a_line_at_an_entry(page, serve):
    room = room_of()
    opened(page, serve(room).url)

    def typed(box, path, text):
        page.click(f"[data-box={box}]")
        field = page.locator(f".field:has([title='{path}']) textarea")
        field.fill(text)
        field.blur()
        return field

    typed("board", "board.force_zero_counts", "112\n-3")
    until(lambda: room.session.engine.system.board.force_zero_counts == (112, -3))
    page.click("[data-box=disturbance]")
    page.locator(".field:has([title='disturbance.kind']) select").select_option("steps")
    until(lambda: room.session.engine.system.disturbance.kind == "steps")
    typed("disturbance", "disturbance.steps", "0 0\n0.5 0.1\n1.5 0")
    until(lambda: room.session.engine.system.disturbance.levels_n == (0.0, 0.1, 0.0))
    field = typed("disturbance", "disturbance.steps", "0 0\n0,5 0.2")
    until(lambda: "0,5: must be a number, with a decimal point" in page.text_content("#status"))
    assert field.input_value() == "0  0\n0.5  0.1\n1.5  0"


def test_a_value_that_was_refused_does_not_stay_in_its_field(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    field = page.locator(".field:has([title='controller.rate_hz']) input[type=number]")
    field.fill("-4")
    field.press("Enter")
    until(lambda: "must be greater than 0" in page.text_content("#status"))
    field.blur()
    assert field.input_value() == "5000"
    assert room.session.engine.system == GRATING


def test_a_phone_is_not_wider_when_the_loop_is_shared_and_its_card_stands_upright(page, serve):
    page.set_viewport_size({"width": 390, "height": 844})
    opened(page, serve(room_of()).url)
    page.click("#words summary")
    assert page.evaluate("document.documentElement.scrollWidth") == 390
    page.click("#scale-open")
    page.locator("#scale-px").fill("6")
    box = page.locator("#scale-card").bounding_box()
    assert (box["width"], box["height"]) == (pytest.approx(6 * 53.98, abs=1.0), pytest.approx(6 * 85.6, abs=1.0))


def test_a_recording_over_time_is_asked_for_no_speed(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    tone = wav(16384 * np.sin(2 * np.pi * 80 * np.arange(8000) / 8000))
    page.set_input_files("#effect-file", {"name": "hum.wav", "mimeType": "audio/wav", "buffer": tone})
    until(lambda: page.is_visible("[name=speed_mm_s]"))
    page.check("[name=over][value=time]")
    assert page.is_hidden("[name=speed_mm_s]")
    page.fill("[name=scale_n]", "0.3")
    page.click("#bring .main")
    until(lambda: room.session.engine.system.setpoint.effect.kind == "wave")


def test_an_effect_is_chosen_and_drawn(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.click("[data-effect=braille]")
    until(lambda: room.session.engine.system.setpoint.effect == fl.rendering.LIBRARY["braille"])
    page.wait_for_selector("[data-effect=braille][aria-checked=true]")


def test_a_recording_downloads_and_loads(page, serve, tmp_path):
    opened(page, serve(room_of(TwinEngine(GRATING), ghost=True)).url)
    page.wait_for_timeout(500)
    with page.expect_download() as download:
        page.click("#save-h5")
    download.value.save_as(tmp_path / "run.h5")
    run = fl.load(tmp_path / "run.h5")
    assert run.attrs["source"] == "simulated"
    assert float(abs(run["f_a"]).max()) > 0.2
    with page.expect_download() as download:
        page.click("#save-png")
    assert download.value.path().read_bytes().startswith(b"\x89PNG")


def test_the_plate_is_at_rest_when_the_driving_page_is_gone(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.mouse.move(500, 250)
    page.mouse.down()
    until(lambda: room.session.finger.load_n > 0.4)
    page.close()
    until(lambda: room.session.finger.load_n == 0.0, timeout_s=1.0)
    until(lambda: room.driver is None)  # a page that says nothing is found before one that is gone


def test_it_comes_back_when_the_server_does(page, serve):
    page.excused = LOST
    first = serve(room_of())
    opened(page, first.url)
    first.stop()
    seen(page, "document.querySelector('#trouble').textContent.includes('lost')")
    room = room_of()
    serve(room, port=first.port)
    seen(page, "document.querySelector('#trouble').hidden")
    until(lambda: room.driver is not None)


def test_a_wrong_token_is_told_in_words(page, serve):
    page.excused = LOST
    answer = page.goto(serve(room_of(), Doors((), "right", "watch")).url + "?token=wrong")
    assert answer.status == 403
    assert "address" in page.text_content("body")


def test_another_page_of_the_browser_cannot_drive(page, serve):
    page.excused = LOST
    room = room_of()
    own = serve(room)
    page.goto("about:blank")
    tried = f"""() => new Promise((tell) => {{
        const socket = new WebSocket('ws://127.0.0.1:{own.port}/live');
        socket.onopen = () => tell('open');
        socket.onerror = () => tell('refused');
    }})"""
    assert page.evaluate(tried) == "refused"
    assert room.guests == []


def test_a_dead_engine_is_seen(page, serve):
    page.goto(serve(room_of(Echo(fails_at=5000))).url)
    seen(page, "document.querySelector('#trouble').textContent.includes('the wheel came off')")
    assert page.is_visible("#trouble")


def test_two_viewers_see_the_same_and_one_takes_over(page, serve):
    room = room_of()
    at = serve(room)
    opened(page, at.url)
    other = page.context.new_page()
    other.goto(at.url)
    other.click("#take")
    page.wait_for_selector("#take:visible")
    assert len(room.guests) == 2
    for each in (page, other):  # who drives does not look on
        seen(each, "document.querySelector('#status').textContent.includes('page drives · 1 page looks on')")


def test_an_address_restores_the_loop(page, serve):
    room = room_of(Echo())
    at = serve(room)
    room.session.engine.system = GRATING.evolve({"friction.nominal_n": 1.11})
    opened(page, at.url)
    page.click("#words summary")
    page.evaluate("() => { navigator.clipboard.writeText = async () => { throw new Error('no clipboard') } }")
    page.click("[data-copy=address]")
    seen(page, "document.querySelector('#copied').textContent.startsWith('http')")
    address = page.text_content("#copied")
    page.close()
    until(lambda: room.driver is None)
    room.session.engine.system = GRATING
    again = page.context.new_page()
    again.goto(address)
    until(lambda: room.session.engine.system.friction.nominal_n == pytest.approx(1.11))


@pytest.mark.parametrize("width", [390, 1280, 3840])
def test_nothing_overflows_and_every_control_has_a_name(page, serve, width):
    page.set_viewport_size({"width": width, "height": 900})
    opened(page, serve(room_of()).url)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    nameless = page.evaluate(
        """[...document.querySelectorAll('button, input, select, a[href], canvas')]
             .filter((each) => !each.closest('[role=img]:not(canvas)'))
             .filter((each) => !(each.textContent.trim() || each.getAttribute('aria-label') || each.labels?.length))
             .map((each) => each.outerHTML)"""
    )
    assert nameless == []


def contrast(page, selector):
    """Return the contrast of a text to the first ground behind it (WCAG 2.2)."""
    return page.evaluate(
        """(selector) => {
          const element = document.querySelector(selector), parse = (text) => text.match(/[\\d.]+/g).map(Number);
          let behind = element;
          while (behind && parse(getComputedStyle(behind).backgroundColor)[3] === 0) behind = behind.parentElement;
          const light = (text) => {
            const bent = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
            const [r, g, b] = parse(text).slice(0, 3).map((c) => bent(c / 255));
            return 0.2126 * r + 0.7152 * g + 0.0722 * b;
          };
          const ground = light(getComputedStyle(behind ?? document.body).backgroundColor);
          const [low, high] = [light(getComputedStyle(element).color), ground].sort((a, b) => a - b);
          return (high + 0.05) / (low + 0.05);
        }""",
        selector,
    )


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_texts_stand_out_from_their_ground(page, serve, scheme):
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")  # a colour that still changes is none
    opened(page, serve(room_of()).url)
    for selector in (
        "h2",
        ".hint",
        "#numbers .open",
        "#numbers .closed",
        "#stop",
        "[data-effect][aria-checked=true]",
        ".field p",
    ):
        assert contrast(page, selector) >= 4.5, selector


def test_the_tour_has_seven_steps_and_each_sets_the_page_up(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.click("#tour")
    kinds = ["notch_pi", "notch_pi", "notch_pi", "pi", "pi", "notch_pi", "notch_pi"]
    for step, kind in enumerate(kinds):
        until(lambda step=step: page.text_content("#tour-card .count") == f"{step + 1} of 7")
        until(lambda kind=kind: room.session.engine.system.controller.kind == kind)
        assert page.is_hidden("#trouble")
        assert "must" not in page.text_content("#status")
        assert page.text_content("#tour-card .task")
        page.click("[data-tour=next]")
    assert page.is_hidden("#tour-card")


def test_the_friction_is_heard_when_asked_for(page, serve):
    room = room_of(ghost=True)
    opened(page, serve(room).url)
    assert not any(guest.listens for guest in room.guests)
    page.select_option("#sound", "closed")
    until(lambda: any(guest.listens for guest in room.guests))
    page.wait_for_timeout(300)
    page.select_option("#sound", "off")
    until(lambda: not any(guest.listens for guest in room.guests))
