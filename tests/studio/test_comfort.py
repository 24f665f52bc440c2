"""True scale, light and dark, less motion, hints of vibration, keys: what makes the page fit who looks at it."""

from __future__ import annotations

import numpy as np
import pytest
from live_engines import Echo
from studio_pages import opened, room_of, seen, until

from frictionloop.live.live_session import Session
from frictionloop.studio.room import Room

pytestmark = pytest.mark.slow
CARD_MM = 85.6


class Ripple(Echo):
    """A closed loop whose force ripples by 0.1 N at 100 Hz."""

    def advance(self, path):
        rows = super().advance(path)
        rows[4] = 0.4 + 0.1 * np.sin(2 * np.pi * 100 / 5000 * (self.ticks + np.arange(len(path))))
        return rows


def test_a_bank_card_sets_the_scale_and_it_is_kept(page, serve):
    room = room_of()
    at = serve(room)
    opened(page, at.url)
    page.click("#scale-open")
    page.locator("#scale-px").fill("5")
    assert page.locator("#scale-card").bounding_box()["width"] == pytest.approx(5 * CARD_MM, abs=1.0)
    page.click("#scale-keep")
    page.reload()
    seen(page, "document.querySelector('#status').textContent.includes('drives')")
    box = page.locator("#plate").bounding_box()
    page.mouse.move(box["x"] + box["width"] / 2 + 100.0, box["y"] + 60.0)
    page.mouse.down()
    until(lambda: room.session.finger.load_n > 0.4)
    assert room.session.finger.x_mm == pytest.approx(20.0, abs=0.2)


def test_the_wheel_over_the_plate_presses_harder(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.hover("#plate")
    page.mouse.wheel(0, -100)
    page.mouse.wheel(0, -100)
    until(lambda: room.session.load_n == pytest.approx(0.6))


def test_colours_follow_the_system_until_they_are_chosen(page, serve):
    page.emulate_media(color_scheme="dark")
    opened(page, serve(room_of()).url)
    look = "document.documentElement.dataset.look"
    assert page.evaluate(look) == "dark"
    page.emulate_media(color_scheme="light")
    seen(page, f"{look} === 'light'")
    page.click("#look")
    page.click("#look")
    assert page.evaluate(look) == "dark"
    page.reload()
    assert page.evaluate(look) == "dark"
    assert "dark" in page.get_attribute("#look", "aria-label")


def test_nothing_moves_by_itself_for_who_asks_for_less_motion(page, serve):
    room = room_of(ghost=True)
    page.emulate_media(reduced_motion="reduce")
    opened(page, serve(room).url)
    until(lambda: not room.session.ghost_on)
    until(lambda: not page.is_checked("#ghost"))


def test_keys_press_harder_and_go_to_another_line(page, serve):
    room = room_of()
    opened(page, serve(room).url)
    page.focus("#plate")
    page.keyboard.press("+")
    until(lambda: room.session.load_n == pytest.approx(0.55))
    page.keyboard.press("ArrowUp")
    page.keyboard.press("ArrowUp")
    until(lambda: room.session.line_mm == pytest.approx(2.0))
    until(lambda: room.session.finger.load_n > 0.4)
    page.keyboard.press("l")
    until(lambda: room.session.finger.load_n == 0.0)
    page.keyboard.press("p")
    assert page.get_attribute("#pause", "aria-pressed") == "true"


@pytest.mark.parametrize(("force", "load_n"), [(0.3, 0.6), (1.0, 0.5)])
def test_a_screen_that_feels_pressure_sets_the_load_and_another_does_not(page, serve, force, load_n):
    room = room_of()
    opened(page, serve(room).url)
    box, line = page.locator("#plate").bounding_box(), page.context.new_cdp_session(page)
    point = {"x": box["x"] + 200, "y": box["y"] + 80, "force": force}
    line.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": [point]})
    until(lambda: room.session.finger.load_n == pytest.approx(load_n))


def test_a_phone_vibrates_with_the_friction_when_asked_to(browser, serve):
    room = Room(Session(Ripple()))
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page = context.new_page()
    page.add_init_script("window.shaken = []; navigator.vibrate = (ms) => window.shaken.push(ms);")
    opened(page, serve(room).url)
    page.wait_for_timeout(400)
    assert page.evaluate("shaken.length") == 0
    page.check("#hint")
    seen(page, "shaken.length > 2")
    assert "no friction" in page.text_content("label:has(#hint)")
    context.close()


def test_a_desktop_without_a_pad_is_not_offered_vibration(page, serve):
    opened(page, serve(room_of()).url)
    assert page.is_hidden("label:has(#hint)")


def test_the_signals_of_a_box_go_to_the_scope_and_back(page, serve):
    opened(page, serve(room_of()).url)
    page.click("[data-box=sensor]")
    own, all_of_them = "#box-signals [data-channel=measured_n]", "#legend [data-channel=measured_n]"
    assert page.locator("#box-signals input").count() == 2
    page.check(own)
    assert page.is_checked(all_of_them)
    page.uncheck(all_of_them)
    assert not page.is_checked(own)


def test_frames_that_were_lost_are_a_gap_in_the_curve(page, serve):
    page.goto(serve(room_of()).url)
    told = page.evaluate(
        """async () => {
          const { Ring } = await import('/static/ring.js'), ring = new Ring(['f'], 10, 1000);
          const frame = (time) => ({ time, spacing: 0.001, rows: 5, channels: [new Float32Array(5).fill(2)] });
          for (const time of [0.001, 0.006, 0.031]) ring.push(frame(time));
          const [x, y] = ring.envelope(['f'], 0, ring.now, 1000);
          return { now: ring.now, latest: ring.latest('f'), gaps: y.filter((each) => each === null).length,
                   even: x.every((each, at) => Math.abs(each - x[0] - at / 1000) < 1e-9) };
        }"""
    )
    assert told == {"now": pytest.approx(0.035), "latest": 2, "gaps": 20, "even": True}


def test_frames_that_were_lost_are_a_gap_over_place_and_in_the_row_of_fingers(page, serve):
    page.goto(serve(room_of()).url)
    told = page.evaluate(
        """async () => {
          const { Ring } = await import('/static/ring.js'), { Scope } = await import('/static/scope.js');
          const { Crowd } = await import('/static/crowd.js'), { SIGNALS } = await import('/static/signals.js');
          const names = ['x_mm', 'load_n', ...SIGNALS.map((each) => each.channel)];
          const element = document.createElement('div');
          document.body.append(element);
          const scope = new Scope(element, new Ring(names, 10, 1000), 20);
          const stroke = (time, from) => scope.take({ time, spacing: 0.001, rows: 2, channels: names.map((name) =>
            Float32Array.from(name === 'x_mm' ? [from, from + 0.25] : [0.5, 0.5])) });
          for (const [time, from] of [[0.001, 0], [0.003, 0.5], [0.015, 2.5]]) stroke(time, from);
          const place = scope.byPlace[0].slice(40, 54).map((each) => each !== null);
          const crowd = new Crowd(Object.assign(new EventTarget(), { ask() {}, tell() {} }));
          for (const time of [0.005, 0.01, 0.035])
            crowd.push({ time, spacing: 0.005, rows: 1,
                         channels: Array.from({ length: 25 }, () => new Float32Array([0.5])) });
          const drawn = [], pen = { moveTo: (x) => drawn.push(['from', x]), lineTo: (x) => drawn.push(['to', x]) };
          crowd.trace(pen, crowd.size, crowd.rows[3]);
          return { place, count: crowd.count, drawn, size: crowd.size };
        }"""
    )
    assert told["place"] == [True] * 4 + [False] * 6 + [True] * 2 + [False] * 2
    assert told["count"] == 7  # 20 ms were lost
    first = told["size"] - 7
    assert told["drawn"] == [["from", first], ["to", first + 1], ["from", first + 6]]
