"""The page by the rules of axe-core: no serious or critical finding in any state, light and dark, large and small."""

from __future__ import annotations

import pytest
from live_engines import GRATING
from studio_files import png
from studio_pages import opened, until

from frictionloop.live.live_engines import TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.studio.room import Room

pytestmark = pytest.mark.slow
WHY = "axe-playwright-python is not installed; it carries axe-core"


def people(page):
    page.click("#crowd-on")
    until(lambda: "mN open" in (page.get_attribute("#people button", "aria-label") or ""))


def tour(page):
    page.click("#tour")
    until(lambda: page.is_visible("#tour-card"))


def painting(page):
    page.click("[data-tool=brush]")


def scale(page):
    page.click("#scale-open")


def picture(page):
    page.set_input_files("#effect-file", {"name": "a.png", "mimeType": "image/png", "buffer": png([[0, 9], [9, 0]])})
    until(lambda: page.is_visible("#bring"))


def sharing(page):
    page.click("#presets-open")
    page.click("#words summary")


def nothing(page):
    page.wait_for_timeout(500)


@pytest.mark.parametrize(
    ("state", "width", "scheme"),
    [
        (nothing, 1440, "light"),
        (nothing, 390, "dark"),
        (people, 1440, "dark"),
        (tour, 390, "light"),
        (painting, 1440, "light"),
        (scale, 1440, "light"),
        (picture, 390, "dark"),
        (sharing, 1440, "light"),
    ],
)
def test_axe_finds_nothing_serious(page, serve, state, width, scheme):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason=WHY)
    page.set_viewport_size({"width": width, "height": 900})
    page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
    opened(page, serve(Room(Session(TwinEngine(GRATING)))).url)
    state(page)
    found = axe.Axe().run(page).response["violations"]
    serious = [
        (each["id"], [node["html"][:120] for node in each["nodes"]][:4])
        for each in found
        if each["impact"] in ("serious", "critical")
    ]
    assert serious == []
