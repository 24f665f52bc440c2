"""The curves over time are a picture that moves on; it shows what uPlot draws of the same data."""

from __future__ import annotations

import numpy as np
import pytest
from live_engines import GRATING
from studio_pages import opened, room_of

from frictionloop.live.live_engines import TwinEngine

pytestmark = pytest.mark.slow
SPANS = """(name) => {
  const canvas = document.querySelector("#scope canvas"), g = canvas.getContext("2d");
  const ink = getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  const [red, green, blue] = [1, 3, 5].map((at) => parseInt(ink.slice(at, at + 2), 16));
  const { data, width, height } = g.getImageData(0, 0, canvas.width, canvas.height), found = [];
  for (let x = 0; x < width; x++) {
    let top = -1, bottom = -1;
    for (let y = 0; y < height; y++) {
      const at = 4 * (y * width + x);
      const far = Math.hypot(data[at] - red, data[at + 1] - green, data[at + 2] - blue);
      if (data[at + 3] < 128 || far > 60) continue;
      if (top < 0) top = y;
      bottom = y;
    }
    found.push([top, bottom]);
  }
  return found;
}"""
"""Of each column of the scope the highest and the lowest pixel of a curve."""
BOTH = f"""async ([name]) => {{
  const spans = {SPANS}, moving = spans(name);
  document.getElementById("pause").click();
  for (let frame = 0; frame < 3; frame++) await new Promise(requestAnimationFrame);
  return [moving, spans(name)];
}}"""
DRAWN = f"([name, least]) => ({SPANS})(name).filter(([top]) => top >= 0).length > least"
"""On a busy machine samples come late: what is looked at is a curve that is there, however long it took."""
WAIT_MS = 120_000


def drawn(page, columns: int) -> None:
    """Wait until the closed loop's curve is in so many columns."""
    page.wait_for_function(DRAWN, arg=["--closed", columns], timeout=WAIT_MS, polling=200)


@pytest.mark.parametrize("span_s", ["1", "4"])
def test_the_moving_picture_is_what_the_data_are(page, serve, span_s):
    """Of each column of the scope the highest and the lowest pixel of a curve: of one that is drawn alone."""
    opened(page, serve(room_of(TwinEngine(GRATING))).url)
    page.select_option("#span", span_s)
    for channel in ("open_n", "asked_n"):
        page.uncheck(f"#legend input[data-channel={channel}]")
    page.wait_for_timeout(1000 * int(span_s))
    drawn(page, 520)
    moving, still = np.array(page.evaluate(BOTH, ["--closed"]))
    columns = [np.flatnonzero(each[:, 0] >= 0) for each in (moving, still)]
    assert min(each.size for each in columns) > 500
    both = np.intersect1d(*columns)
    assert both.size > 0.98 * columns[1].size
    apart = np.abs(moving[both] - still[both])
    assert np.median(apart) <= 1
    assert np.percentile(apart, 90) <= 4  # where the curve is steep, a pixel to the side is several up


def test_the_moving_picture_begins_anew_in_another_look_and_span(page, serve):
    opened(page, serve(room_of(TwinEngine(GRATING))).url)
    drawn(page, 220)
    page.click("#look")  # light, and then dark
    page.click("#look")
    drawn(page, 220)
    moving, still = np.array(page.evaluate(BOTH, ["--closed"]))
    columns = [np.count_nonzero(each[:, 0] >= 0) for each in (moving, still)]
    assert columns[1] > 200
    assert abs(columns[0] - columns[1]) < 0.05 * columns[1]


def test_what_the_skin_pulls_along_at_a_turn_is_a_gap_and_no_spike(page, serve):
    opened(page, serve(room_of()).url)
    found = page.evaluate(
        """async () => {
          const { Ring } = await import("/static/ring.js"), { LEAST_N } = await import("/static/signals.js");
          const force = (row) => (row > 400 && row < 440 ? -0.5 : 0.5 + 1e-3 * (row % 3));
          const channels = [Float32Array.from({ length: 900 }, (_, row) => force(row))];
          const ring = new Ring(["closed_n"], 1, 1000);
          ring.push({ time: 0, spacing: 1e-3, rows: 900, channels });
          return [1800, 90].map((stretches) => ring.envelope(["closed_n"], 0, 0.899, stretches, LEAST_N));
        }"""
    )
    for x, drawn_n in found:
        gap = [at for at, value in zip(x, drawn_n, strict=True) if value is None]
        assert min(value for value in drawn_n if value is not None) == pytest.approx(0.5)
        assert min(gap) == pytest.approx(0.401, abs=0.01)
        assert max(gap) == pytest.approx(0.439, abs=0.01)
