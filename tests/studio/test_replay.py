"""Recorded runs in one page: what it holds, that it plays without a server, and what a page may open."""

from __future__ import annotations

import base64
import gzip
import re
import warnings

import numpy as np
import pytest
from live_engines import GRATING, Echo
from studio_pages import opened, seen, until

import frictionloop as fl
from frictionloop.live.live_engines import CHANNELS
from frictionloop.live.live_session import Session
from frictionloop.parameters.toml_writer import to_toml
from frictionloop.studio.connections import Guest
from frictionloop.studio.replay import STEPS, needed_by, page_of, played, read_run, stroked
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # starlette would have another client than httpx
    from starlette.testclient import TestClient


@pytest.fixture(scope="module")
def run():
    return stroked(GRATING, 0, 4.0)


@pytest.fixture(scope="module")
def path(run, tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "run.h5"
    fl.save(run, path)
    return path


def values_of(told):
    counts = np.frombuffer(gzip.decompress(base64.b64decode(told["values"])), "<u2").reshape(len(CHANNELS), -1)
    values = np.array(told["least"])[:, None] + np.array(told["step"])[:, None] * counts
    return dict(zip(CHANNELS, np.where(counts > STEPS, np.nan, values), strict=True))


def test_a_run_is_played_as_it_was_recorded(run, path):
    told = read_run(path)
    values = values_of(told)
    assert (told["name"], told["source"], told["rows"]) == ("run.h5", "simulated", 4000)
    for channel, variable in (("closed_n", "f_a"), ("open_n", "f_a_open"), ("asked_n", "f_r"), ("closed_um", "a")):
        span = float(np.ptp(run[variable].values))
        np.testing.assert_allclose(values[channel], run[variable].values[4::5], atol=span / STEPS)
    assert len(told["numbers"]) == 8
    assert told["numbers"][-1]["closed_error_n"] < told["numbers"][-1]["open_error_n"]
    assert told["map"]


def test_what_a_run_does_not_have_is_missing():
    values = values_of(played(fl.simulate(fl.paper(), duration_s=0.5, seed=0), "paper"))
    assert np.isnan(values["open_n"]).all()
    assert np.isnan(values["x_mm"]).all()
    assert np.isfinite(values["closed_n"]).all()


def test_the_page_is_one_small_file_that_asks_for_nothing(path):
    page = page_of([read_run(path)])
    assert len(page) < 1_000_000
    # Nothing is linked: neither styles nor scripts, and no module imports by an address.
    assert not re.search(r'(src|href)="(?!data:|/")', page)
    assert "/static/" not in page
    assert {"replay.js", "scope.js", "plate.js", "vendor/uPlot.esm.js"} <= set(needed_by("replay.js"))
    assert page == page_of([read_run(path)])


def client(room):
    return TestClient(studio_app(room), base_url="http://localhost")


def driven():
    room = Room(Session(Echo()))
    guest = Guest(may_drive=True)
    room.join(guest)
    return room, {"x-studio-page": guest.key}


def test_a_page_opens_a_run_and_a_bench(path):
    room, key = driven()
    at = client(room)
    assert at.get("/runs.json").status_code == 404
    answer = at.post("/open?name=mine.h5", content=path.read_bytes(), headers=key)
    assert answer.json() == {"told": "mine.h5 can be played", "go": "/replay"}
    assert [each["name"] for each in at.get("/runs.json").json()] == ["mine.h5"]
    assert at.get("/replay").status_code == 200
    bench = GRATING.evolve({"friction.nominal_n": 1.23})
    assert at.post("/open?name=my-bench.toml", content=to_toml(bench).encode(), headers=key).status_code == 200
    assert room.session.engine.system == bench


@pytest.mark.parametrize(
    ("name", "content", "why"),
    [
        ("run.exe", b"", "must be .toml or .h5"),
        ("run.h5", b"nonsense", "run.h5"),
        ("run.h5", b"x" * (64 * 1024 * 1024 + 1), "must be smaller"),
        ("b.toml", b"x" * (256 * 1024 + 1), "must be smaller"),
        ("b.toml", b"schema = 1\n[", "is not TOML"),
        ("b.toml", b'preset = "bench"\n[controller]\nkpp = 1', "kpp"),
        ("b.toml", b'preset = "bench"\n[disturbance]\nkind = "recording"\npath = "passwd"', "must not be a file"),
        ("b.toml", b'preset = "bench"\n[setpoint]\nkind = "effect"\neffect = "/etc/passwd"', "must not be a file"),
    ],
)
def test_what_cannot_be_opened_is_refused_in_words(name, content, why):
    room, key = driven()
    answer = client(room).post(f"/open?name={name}", content=content, headers=key)
    assert answer.status_code == 400
    assert why in answer.json()["why"]
    assert "/tmp" not in answer.json()["why"]
    assert room.session.engine.system == GRATING


def test_only_the_driving_page_opens_files(path):
    room, _ = driven()
    answer = client(room).post("/open?name=run.h5", content=path.read_bytes(), headers={"x-studio-page": "guess"})
    assert "another page drives" in answer.json()["why"]
    assert not room.runs


@pytest.mark.slow
@pytest.mark.parametrize("way", ["file", "server"])
def test_a_recorded_run_moves_plate_and_scope_in_the_browser(page, serve, path, tmp_path, way):
    if way == "file":
        (tmp_path / "page.html").write_text(page_of([read_run(path)]), encoding="utf-8")
        page.context.set_offline(True)
        page.goto((tmp_path / "page.html").as_uri())
    else:
        room = Room(Session(Echo()))
        room.runs.append(read_run(path))
        page.goto(serve(room).url + "replay")
    seen(page, "parseFloat(document.querySelector('#at').textContent) > 1")
    seen(page, "document.querySelector('[data-number=closed_error_n]').textContent.endsWith('mN')")
    assert page.is_hidden("#trouble")
    page.click("#play")
    before = page.text_content("#at")
    page.wait_for_timeout(300)
    assert page.text_content("#at") == before


@pytest.mark.slow
def test_the_scope_is_saved_as_a_drawing_and_two_cursors_measure(page, serve):
    room = Room(Session(Echo()))
    opened(page, serve(room).url)
    page.wait_for_timeout(1500)
    page.click("#pause")
    page.locator("#scope").scroll_into_view_if_needed()
    over = page.locator("#scope .u-over").bounding_box()
    page.mouse.click(over["x"] + 0.9 * over["width"], over["y"] + 40)
    page.wait_for_timeout(500)
    page.mouse.click(over["x"] + 0.95 * over["width"], over["y"] + 40)
    seen(page, "document.querySelector('#cursor').textContent.includes('apart')")
    apart = float(re.search(r"apart ([\d.]+) s", page.text_content("#cursor"))[1])
    assert apart == pytest.approx(0.05 * 2.0, abs=0.02)  # of 2 s shown
    with page.expect_download() as download:
        page.click("#save-svg")
    drawing = download.value.path().read_text()
    assert drawing.startswith("<svg")
    assert drawing.count("<path") > 6
    page.focus("#scope")
    page.keyboard.press("Escape")
    until(lambda: page.text_content("#cursor").startswith("Drag"))
