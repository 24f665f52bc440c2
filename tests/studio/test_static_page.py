"""The live page in one file: the simulator's bits, the session's finger, and the page itself from file://."""

from __future__ import annotations

import base64
import gzip
import json
import math
import os
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from firefox import firefox
from studio_pages import seen, until

import frictionloop as fl
from frictionloop.live.live_engines import CHANNELS, TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.physics.reach import Reach
from frictionloop.rendering.effect import TURNS_MM_S
from frictionloop.studio import opened_studio
from frictionloop.studio.effect_feasibility import BEYOND, SLACK_N, STEEP
from frictionloop.studio.effect_pictures import force_over
from frictionloop.studio.live_numbers import numbers_of, slides
from frictionloop.studio.offline_choices import Choices, PageBench, axes_of
from frictionloop.studio.opened_studio import scene
from frictionloop.studio.replay import STATIC, packed

BASE = scene()
DRIVER = Path(__file__).with_name("page_driver.mjs")
static_page = pytest.importorskip("frictionloop.studio.static_page")
pytest.importorskip("ziglang", reason="ziglang is not installed")


@pytest.fixture(scope="module")
def data():
    return static_page.page_data(BASE, 0)


@pytest.fixture(scope="module")
def play(data, tmp_path_factory):
    path = tmp_path_factory.mktemp("page") / "play.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(static_page, "page_data", lambda *_: data)
        path.write_text(static_page.play_page(BASE), encoding="utf-8")
    return path


def deno(tmp_path, **given):
    """Run the page's modules on what is given, and return what they write."""
    command = pytest.importorskip("deno", reason="deno is not installed").find_deno_bin()
    (tmp_path / "given.json").write_text(json.dumps(given, allow_nan=False))
    asked = [command, "run", "--no-prompt", "--allow-read", DRIVER, STATIC, tmp_path / "given.json"]
    done = subprocess.run(asked, capture_output=True, check=True, env=os.environ | {"DENO_NO_UPDATE_CHECK": "1"})
    return done.stdout


def stroke(first, periods):
    k = np.arange(first, first + periods)
    turns = 2.0 * np.pi * 1.1 * k / 5000
    return np.stack(
        [0.04 * np.sin(turns), 0.276 * np.cos(turns), np.clip(0.3 + 0.5 * np.sin(k / 700), 0.0, 1.0)], axis=1
    )


def combinations(count):
    """Yield choices of the page drawn at random, each with its whole System; gains are calm ones."""
    rng, choices = np.random.default_rng(1), static_page.choices_of(BASE)
    for _ in range(count):
        law, effect = str(rng.choice(list(choices.laws))), str(rng.choice(list(choices.effects)))
        finger, sliders = str(rng.choice(["", *choices.fingers])), choices.stops | choices.gains[law]
        stops = {path: float(rng.choice(values)) for path, values in sliders.items() if rng.random() < 0.4}
        stops |= {"controller.kp": 0.2, "controller.ki": 50.0} if "controller.kp" in sliders else {}
        system = BASE.evolve(choices.effects[effect]).evolve(choices.fingers.get(finger, {})).evolve(choices.laws[law])
        yield {"law": law, "effect": effect, "finger": finger, "stops": stops}, system.evolve(stops)


@pytest.mark.parametrize("build", ["fused", "exact"])
def test_both_loops_have_the_bits_of_the_live_engine_while_choices_change(data, build, tmp_path):
    twin, steps, expected, at = TwinEngine(BASE, 0), [], [], 0
    for chosen, system in combinations(20):
        twin.change(system)
        for block in range(20):
            path = stroke(at, 25)
            at += 25
            steps.append({"path": path.ravel().tolist()} | ({} if block else {"at": chosen}))
            expected.append(twin.advance(path).ravel())
    found = np.frombuffer(deno(tmp_path, data=data, build=build, steps=steps))
    assert np.array_equal(found.view(np.uint64), np.concatenate(expected).view(np.uint64))


def test_a_bench_of_another_rate_and_a_long_delay_runs_too(tmp_path):
    system = BASE.evolve({"controller.kind": "pi", "controller.rate_hz": 10_000.0, "controller.delay_s": 0.009})
    own, twin = static_page.page_data(system, 7), TwinEngine(system, 7)
    steps = [stroke(25 * block, 25) for block in range(20)]
    expected = np.concatenate([twin.advance(path).ravel() for path in steps])
    given = [{"path": path.ravel().tolist()} for path in steps]
    found = np.frombuffer(deno(tmp_path, data=own, build="exact", steps=given))
    assert np.array_equal(found.view(np.uint64), expected.view(np.uint64))


def test_a_build_that_rounds_twice_is_found_out(data, tmp_path):
    bench = PageBench(BASE, 0)
    axes_of(bench, static_page.choices_of(BASE))
    twice = bench.loop.text().replace("return __builtin_fma(a, b, c);", "return a * b + c;")
    builds = {"fused": packed(static_page.wasm(twice, ())), "exact": data["wasm"]["exact"]}
    assert deno(tmp_path, data=data | {"wasm": builds}) == b"exact\n"


class Told:
    """An engine that tells the path it was given."""

    source, system, rate_hz = "simulated", BASE, 5000.0

    def advance(self, path):
        return path.T


def events(seed=3, seconds=3.0):
    """Return pointer messages as a page records them: bursts, pauses, whole pixels, some late, some with pressure."""
    rng, now, x, found = np.random.default_rng(seed), 5.0, 0.0, []
    while now < 5.0 + seconds:
        now += float(rng.choice([0.004, 0.008, 0.0167, 0.3], p=[0.5, 0.3, 0.19, 0.01]))
        rows = []
        for _ in range(int(rng.integers(0, 4))):
            x += float(rng.choice([0.0, 0.25, 0.5, -0.25, 9.0], p=[0.3, 0.3, 0.2, 0.19, 0.01]))
            rows.append(
                [
                    1e3 * (now - float(rng.uniform(0.0, 0.01))),
                    x,
                    3.0,
                    None if rng.random() < 0.7 else float(rng.uniform(0.1, 2.0)),
                ]
            )
        found.append((now, sorted(rows, key=lambda row: row[0])))
    return found


def test_the_finger_follows_recorded_pointer_events_as_the_session_does(tmp_path):
    session, expected, reached = Session(Told()), [], []
    recorded = events()
    session._kept = np.zeros((3, session._kept.shape[1]), np.float32)
    session.step(recorded[0][0])
    for now, rows in recorded:
        if rows:
            session.touch(now, np.array([[math.nan if each is None else each for each in row] for row in rows]))
        for block in session.step(now):
            expected += [[block.first_tick, block.reached_ms], block.rows.astype(float).ravel()]
            reached.append(block.reached_ms)
    found = np.frombuffer(deno(tmp_path, session=recorded))
    np.testing.assert_array_equal(found, np.concatenate(expected))
    assert np.isfinite(reached).mean() > 0.2


def test_the_numbers_are_those_of_the_served_page(tmp_path):
    session = Session(TwinEngine(BASE, 0))
    session.step(0.0)
    for block in range(250):
        session.step(0.01 * (block + 1))
    rows, limits = session.last(2.0), {"touch_n": BASE.touch.load.touch_n, "turns_mm_s": TURNS_MM_S}
    numbers = {"rows": rows.astype(float).tolist(), "names": list(CHANNELS), "limits": limits}
    found, expected = json.loads(deno(tmp_path, numbers=numbers)), numbers_of(rows, 5000.0, limits["touch_n"])
    count = slides(rows[0].astype(float), rows[1], 5000.0, limits["touch_n"])
    reach = [rows[list(CHANNELS).index(name), count].mean(dtype=float) for name in ("floor_n", "limit_n")]
    assert found.pop("reach") == pytest.approx(reach, rel=1e-5)
    assert set(found) == set(expected)
    assert found == {name: pytest.approx(expected[name], rel=1e-5, abs=1e-9) for name in found}


@pytest.mark.parametrize("effect", ["square", "edge", "braille"])
def test_what_will_not_arrive_is_hatched_where_the_served_page_would(data, effect, tmp_path):
    band = [0.41, 0.47]
    found = json.loads(deno(tmp_path, data=data, ahead={"effect": effect, "band": band}))
    source = BASE.evolve({"setpoint.effect": fl.rendering.LIBRARY[effect]}).setpoint
    rows = np.array(found["reasons"])
    x = found["from_mm"] + found["step_mm"] * np.arange(rows.shape[1])
    lines = found["bottom_mm"] + found["row_mm"] * np.arange(rows.shape[0])
    assert len(lines) == (60 if effect == "braille" else 1)
    beyond = Reach(*band).beyond(force_over(source, x, lines), SLACK_N)
    assert 0.1 < beyond.mean() == pytest.approx(found["shares"]["beyond"], abs=0.02)
    assert np.mean((rows & BEYOND > 0) != beyond) < 0.02  # 255 steps of force, lines of 0.25 mm
    fine = np.linspace(x[0], x[-1], 20 * x.size)
    steep = np.abs(np.gradient(force_over(source, fine, lines), fine, axis=1)).max(axis=1) > 1.0  # N/mm of the skin
    assert np.array_equal((rows & STEEP > 0).any(axis=1), steep)


def test_choices_that_do_not_add_up_are_refused_by_name():
    stiff = Choices(
        {"notch_pi": {}},
        {"grating": {}},
        {"soft": {"finger.damping_n_s_m": 3.0}},
        {"finger.stiffness_n_m": [500.0, 2000.0]},
        {},
    )
    with pytest.raises(fl.FrictionloopError, match=r"soft, notch_pi, .*: slab") as refused:
        axes_of(PageBench(BASE, 0), stiff)
    assert refused.value.code == "STUDIO-NO-SUM"


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"plate.pulse_ticks": 783}, "plate.pulse_ticks: math.asin"),
        ({"disturbance": {"kind": "noise"}}, "setpoint, disturbance: must need no samples"),
    ],
)
def test_what_a_page_cannot_run_is_refused(values, why):
    with pytest.raises(fl.FrictionloopError, match=why) as refused:
        PageBench(BASE.evolve(values), 0)
    assert refused.value.code == "NO-C"


def test_the_page_is_small_and_holds_all_it_needs(play):
    text = play.read_bytes()
    assert len(gzip.compress(text, 9)) < 700_000
    assert b"/static/" not in text


SCRIPTS = "script-src 'unsafe-inline' data: 'wasm-unsafe-eval'"
STRICT = f"default-src 'none'; {SCRIPTS}; style-src 'unsafe-inline'; img-src data: blob:"
UNFUSED = "const v = WebAssembly.validate; WebAssembly.validate = (c) => (WebAssembly.validate = v, false)"


def running(page, url):
    """Open the page and wait for its numbers; return what it asked for."""
    asked = []
    page.on("request", lambda request: asked.append(request.url))
    page.goto(url)
    seen(page, "document.querySelector('[data-number=closed_error_n]')?.textContent.includes('mN')")
    return [each for each in asked if not each.startswith(("data:", "blob:"))]


def command(page):
    return page.locator("#as-command").text_content()


def test_the_page_runs_from_a_file_and_has_its_choices(page, play):
    assert running(page, play.as_uri()) == [play.as_uri()]
    page.get_by_role("button", name="Another finger").click()
    page.locator("[data-effect=braille]").click()
    page.locator("#fields select").first.select_option("limit_observer")
    seen(page, "document.getElementById('as-command').textContent.includes('--controller.kind limit_observer')")
    assert "--effect braille" in command(page)
    found: dict[str, object] = {}
    exec(page.locator("#as-python").text_content().rpartition("\n")[0], found)
    chosen = static_page.choices_of(BASE)
    whole = BASE.evolve(chosen.effects["braille"]).evolve(chosen.fingers["finger 1"])
    assert found["system"] == whole.evolve({"controller.kind": "limit_observer"})
    page.locator("[data-box=plate]").click()
    page.get_by_role("slider", name="plate.max_amplitude_um").fill("1.22")
    seen(page, "document.getElementById('as-command').textContent.includes('--plate.max_amplitude_um 1.2')")
    page.locator("#undo").click()
    seen(page, "!document.getElementById('as-command').textContent.includes('max_amplitude')")
    page.click("#presets-open")
    page.click("#presets >> text=Weak plate")
    seen(page, "document.getElementById('ahead-told').textContent.includes(\"out of this finger's reach\")")
    assert static_page.MORE in page.locator("footer").text_content()


def test_twelve_fingers_feel_the_stroke_each_as_if_alone(data, tmp_path):
    chosen = {"law": "pi", "effect": "square", "finger": "", "stops": {"friction.nominal_n": 0.8, "controller.kp": 0.2}}
    steps = [stroke(25 * block, 25) for block in range(60)]
    given = {"at": chosen, "steps": [path.ravel().tolist() for path in steps]}
    found = np.frombuffer(deno(tmp_path, data=data, build="fused", crowd=given)).reshape(60, 25)
    choices = static_page.choices_of(BASE)
    for number, person in list(enumerate(choices.fingers.values()))[::5]:
        system = BASE.evolve(choices.effects["square"]).evolve(choices.laws["pi"])
        twin = TwinEngine(system.evolve({"controller.kp": 0.2} | person), 0)
        rows = np.array([twin.advance(path)[[2, 3, 4], -1] for path in steps])
        assert np.array_equal(found[:, [0, 1 + number, 13 + number]], rows)


def test_the_row_of_fingers_is_shown_where_it_is_quick_enough_and_one_is_taken(page, play):
    running(page, play.as_uri())
    page.click("#crowd-on")
    told = "document.getElementById('crowd-told').textContent"
    seen(page, f"{told}.startsWith('Error with the loop open') || {told}.includes('cannot be shown')")
    if "cannot" in page.text_content("#crowd-told"):
        assert "µs here, at most 8" in page.text_content("#crowd-told")  # this machine, or this hour, is too slow
        return
    assert page.locator("#people button").count() == 12
    page.click("#people button:nth-child(4)")
    wanted = fl.fingers(4, 0)[3]["friction.nominal_n"]
    seen(page, f"document.getElementById('as-command').textContent.includes('{wanted}')")


def test_what_the_page_cannot_do_is_named_with_what_can(page, play):
    given = (
        "#" + base64.b64encode(json.dumps({"controller.rate_hz": 2000.0, "friction.nominal_n": 0.5}).encode()).decode()
    )
    page.goto(play.as_uri() + given)
    said = json.dumps(f"controller.rate_hz: {static_page.MORE}")  # for five seconds
    seen(page, f"document.getElementById('status').textContent === {said}")
    seen(page, "document.getElementById('as-command').textContent.includes('--friction.nominal_n 0.5')")


def test_the_tour_says_what_is_done_and_ends_where_it_began(page, play):
    running(page, play.as_uri())
    before = command(page)
    page.click("#tour")
    box = page.locator("#plate").bounding_box()
    page.mouse.move(box["x"] + 100, box["y"] + 60)
    page.mouse.down()
    for step in range(60):
        page.mouse.move(box["x"] + 100 + 3 * step, box["y"] + 60)
        page.wait_for_timeout(10)
    page.mouse.up()
    done = "document.querySelector('#tour-card .done').textContent.startsWith('✓')"
    seen(page, done)
    for _ in range(5):
        page.click("[data-tour=next]")
    assert page.text_content("#tour-card .count") == "6 of 7"
    seen(page, "document.getElementById('ahead-told').textContent.includes(\"out of this finger's reach\")")
    page.get_by_role("slider", name="plate.max_amplitude_um").fill("2.5")
    seen(page, done)
    page.click("[data-tour=end]")
    seen(page, f"document.getElementById('as-command').textContent === {json.dumps(before)}")


def test_the_pointer_takes_the_finger_over_at_once(page, play):
    running(page, play.as_uri())
    box = page.locator("#plate").bounding_box()
    page.mouse.move(box["x"] + 0.4 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in range(100):
        page.mouse.move(box["x"] + (0.4 + 0.003 * step) * box["width"], box["y"] + box["height"] / 2)
        page.wait_for_timeout(10)
    said = until(lambda: re.search(r"pointer to force (\d+) ms", page.locator("#rates").text_content()))
    assert int(said[1]) < 100  # 9 ms on a quiet machine


@pytest.mark.parametrize("build", ["fused", "exact"])
def test_a_strict_host_and_a_processor_that_does_not_fuse_will_do(page, play, build):
    if build == "exact":
        page.add_init_script(UNFUSED)
    head = {"content-security-policy": STRICT, "content-type": "text/html"}
    page.route("**/play.html", lambda route: route.fulfill(body=play.read_bytes(), headers=head))
    assert running(page, "http://play.test/play.html") == ["http://play.test/play.html"]
    assert page.evaluate("document.body.dataset.build") == build
    assert page.locator("#verdict").text_content().startswith("The closed loop leaves")


def test_firefox_runs_it_from_a_file_to_the_same_bits(play, tmp_path):
    program = shutil.which("firefox-esr") or shutil.which("firefox") or pytest.skip("no firefox on the PATH")
    with firefox(program, tmp_path) as tab:
        tab.goto(play.as_uri())
        seen(tab, "document.querySelector('[data-number=closed_error_n]')?.textContent.includes('mN')")
        assert tab.evaluate("document.body.dataset.build") in ("fused", "exact")  # proven, or it would not run
        assert tab.evaluate("document.getElementById('trouble').textContent") == ""
        assert tab.evaluate("document.getElementById('verdict').textContent").startswith("The closed loop leaves")


def test_a_wheel_brings_the_page_for_those_without_a_compiler(play, tmp_path, monkeypatch):
    monkeypatch.setattr(opened_studio, "CARRIED", play)
    monkeypatch.setattr(opened_studio, "find_spec", lambda name: None)
    found = fl.studio.export(tmp_path / "out.html")
    assert found.path.read_bytes() == play.read_bytes()
    assert found.runs == found.findings == ()


def test_a_browser_without_the_simulators_bits_says_so(page, play):
    page.add_init_script("WebAssembly.validate = () => false")
    page.goto(play.as_uri())
    seen(page, "document.getElementById('trouble').textContent.includes(\"does not compute the simulator's numbers\")")
    assert static_page.MORE in page.locator("#trouble").text_content()


@pytest.mark.parametrize(("width", "scheme"), [(1280, "light"), (390, "dark")])
def test_axe_finds_nothing_serious_on_the_page(page, play, width, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe-playwright-python is not installed")
    page.set_viewport_size({"width": width, "height": 844})
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    page.goto(play.as_uri())
    seen(page, "document.body.dataset.build !== undefined")
    found = axe.Axe().run(page).response["violations"]
    assert [each["id"] for each in found if each["impact"] in ("serious", "critical")] == []


def test_nothing_moves_by_itself_for_who_wants_no_motion(page, play):
    page.emulate_media(reduced_motion="reduce")
    page.goto(play.as_uri())
    seen(page, "document.body.dataset.build !== undefined")
    assert not page.is_checked("#ghost")
    assert page.locator("#verdict").text_content().startswith("Slide on the plate")
    page.focus("#plate")
    page.keyboard.down("ArrowRight")
    seen(page, "document.querySelector('[data-number=closed_error_n]').textContent.includes('mN')")


def test_a_phone_shows_plate_curves_and_numbers_at_once(page, play):
    page.set_viewport_size({"width": 390, "height": 844})
    running(page, play.as_uri())
    boxes = [page.locator(each).bounding_box() for each in ("#plate", "#scope", "#numbers")]
    assert max(box["y"] + box["height"] for box in boxes) < 844
    assert page.evaluate("document.documentElement.scrollWidth") == 390
