"""Recorded runs as a page plays them: channels, map and numbers; and a page of the studio without a server.

Such a page is one file: it holds styles, modules and data of the studio's own pages, and asks for nothing.
"""

from __future__ import annotations

import base64
import gzip
import json
import os
import re
from collections.abc import Mapping
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from frictionloop.live.live_engines import CHANNELS, TwinEngine
from frictionloop.live.live_session import BESIDE, RUN, Session, recorded
from frictionloop.loop.record import load, system_of
from frictionloop.parameters import System
from frictionloop.quantities import FrictionloopError
from frictionloop.rendering.effect_setpoint import EffectSource
from frictionloop.studio.effect_pictures import HEIGHT_MM, map_of
from frictionloop.studio.live_numbers import WINDOW_S, numbers_of

if TYPE_CHECKING:
    import xarray as xr


LONGEST_S = 60.0
"""What of a run is played at most, from its beginning."""
SHOWN_HZ = 1000.0
"""Samples a second of the scope: above it a run is thinned, as live frames are."""
STEPS = 65534
"""Steps of a channel from its least to its largest value, in 16 bits; one more number means missing."""
NUMBERS_S = 0.5
"""How often numbers are told (assumed)."""
LEVEL = 9


def read_run(path: str | os.PathLike[str], name: str = "") -> dict[str, Any]:
    """Return what a page plays of a recorded run."""
    with load(path, until_s=LONGEST_S) as run:
        return played(run, name or Path(path).name)


def played(run: xr.Dataset, name: str) -> dict[str, Any]:
    """Return what a page plays of a run, as plain data: texts, numbers, and compressed channels in base 64."""
    time_s = np.asarray(run["time"].values, float)
    if time_s.size < 2 or not {"f_r", "f_a", "f_m"} & set(run):
        raise FrictionloopError(f"{name}: holds no run")
    rate = 1.0 / float(time_s[1] - time_s[0])
    rows, system = channels_of(run), _system(run)
    source = system.setpoint if system and isinstance(system.setpoint, EffectSource) else None
    every = max(round(rate / SHOWN_HZ), 1)
    shown = rows[:, every - 1 :: every]
    least, most = _ends(shown)
    return {
        "name": name,
        "about": about(run, time_s),
        "source": str(run.attrs.get("source", "simulated")),
        "spacing_s": every / rate,
        "rows": shown.shape[1],
        "channels": {each: list(told) for each, told in CHANNELS.items()},
        "least": least.tolist(),
        "step": ((most - least) / STEPS).tolist(),
        "values": packed(_counts(shown, least, most).tobytes()),
        "numbers": _numbers(rows, rate, system),
        "numbers_s": NUMBERS_S,
        "map": packed(map_of(system)) if system and source else None,
        "line_mm": source.track.y_mm if source else 0.0,
        "plate_mm": [system.touch.load.length_mm if system else 255.0, HEIGHT_MM],
    }


def packed(content: bytes) -> str:
    """Return bytes compressed and as text; the same bytes give the same text."""
    return base64.b64encode(gzip.compress(content, LEVEL, mtime=0)).decode()


def channels_of(run: xr.Dataset) -> np.ndarray:
    """Return the `CHANNELS` of a run, NaN where it has none, shape (channels, samples)."""
    named = {channel: variable for variable, channel in {**RUN, **BESIDE}.items()}
    rows = np.full((len(CHANNELS), run.sizes["time"]), np.nan)
    for row, channel in enumerate(CHANNELS):
        if (variable := named.get(channel)) in run:
            rows[row] = run[variable].values
    if "position" in run:
        rows[list(CHANNELS).index("x_mm")] = 1e3 * run["position"].values
    return rows


def about(run: xr.Dataset, time_s: np.ndarray) -> str:
    """Return in a line what a run is."""
    length_s = time_s[-1] - time_s[0]
    whole_s = float(run.attrs.get("duration_s", length_s))
    told = f"{length_s:.1f} s" if whole_s <= length_s + 1.0 else f"the first {length_s:.0f} of {whole_s:.0f} s"
    system = _system(run)
    law = f", law {system.controller.kind}" if system else ""
    return f"{run.attrs.get('source', 'simulated')}, {told}{law}"


def _system(run: xr.Dataset) -> System | None:
    try:
        return system_of(run)
    except FrictionloopError:  # a device that was set up by hand
        return None


def _ends(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the largest value of each channel; 0 and 1 of one that is missing."""
    there = np.isfinite(rows)
    least = np.where(there.any(axis=1), np.where(there, rows, np.inf).min(axis=1), 0.0)
    most = np.where(there.any(axis=1), np.where(there, rows, -np.inf).max(axis=1), 1.0)
    return least, np.where(most > least, most, least + 1.0)


def _counts(rows: np.ndarray, least: np.ndarray, most: np.ndarray) -> np.ndarray:
    share = (rows - least[:, None]) / (most - least)[:, None]
    return np.where(np.isfinite(share), np.rint(STEPS * np.nan_to_num(share)), STEPS + 1).astype("<u2")


def _numbers(rows: np.ndarray, rate_hz: float, system: System | None) -> list[dict[str, float | None]]:
    """Return the numbers of the last seconds at even times; none where the finger is not known."""
    if system is None or not np.isfinite(rows[0]).any():
        return []
    touches, step, back = system.touch.load.touch_n, round(NUMBERS_S * rate_hz), round(WINDOW_S * rate_hz)
    ends = range(step, rows.shape[1] + 1, step)
    return [numbers_of(rows[:, max(end - back, 0) : end], rate_hz, touches) for end in ends]


STEP_S = 0.02


def page_of(runs: list[dict[str, Any]]) -> str:
    """Return a page that plays runs, as HTML in one piece."""
    return one_page("replay.html", "frictionloop: recorded runs", "runs", runs)


def stroked(system: System, seed: int = 0, seconds: float = 10.0) -> xr.Dataset:
    """Return what the ghost finger of a studio does on a System, open and closed loop side by side, as a run."""
    session = Session(TwinEngine(system, seed))
    session.step(0.0)
    for block in range(round(seconds / STEP_S)):
        session.step((block + 1) * STEP_S)
    return recorded(session, seconds)


STATIC = Path(__file__).parent / "static"
_NEEDED = re.compile(r"""^import [^"']*?from "\./([\w./-]+\.js)";$""", re.MULTILINE)
_LINKED = re.compile(r'^<link rel="stylesheet" href="/static/([\w./-]+)">\n', re.MULTILINE)
_STARTED = re.compile(r'<script type="module" src="/static/([\w-]+\.js)"></script>')
_THEME = '<script src="/static/theme.js"></script>'
_ICON = '<link rel="icon" href="/static/icon.svg">'
_WORKLET = '"/static/sound-worklet.js"'


def one_page(name: str, title: str, key: str, data: Any, instead: Mapping[str, str] | None = None) -> str:
    """Return a page of the studio as HTML in one piece.

    Modules keep their text: an import map names each by an address that holds it.

    Parameters
    ----------
    name
        Its HTML.
    title
        Of the page.
    key, data
        What its modules find in the element of this id, as JSON.
    instead
        Modules by the one in whose place they stand.
    """
    page = (STATIC / name).read_text()
    for style in _LINKED.findall(page):
        text = (STATIC / style).read_text().replace("</", "<\\/")
        page = page.replace(f'<link rel="stylesheet" href="/static/{style}">', f"<style>{text}</style>")
    icon = _address("image/svg+xml", (STATIC / "icon.svg").read_text())
    page = page.replace(_ICON, f'<link rel="icon" href="{icon}">')
    page = re.sub("<title>.*</title>", lambda _: f"<title>{escape(title, quote=False)}</title>", page)
    page = page.replace(_THEME, f"<script>{(STATIC / 'theme.js').read_text()}</script>")
    main = _STARTED.findall(page)[0]
    modules = {each: _address("text/javascript", text) for each, text in _modules(main, instead or {}).items()}
    content = json.dumps(data, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    head = f'<script type="importmap">{json.dumps({"imports": modules})}</script>'
    told = f'<script type="application/json" id="{key}">{content}</script>'
    return _STARTED.sub(lambda _: f'{head}\n{told}\n<script type="module">import "{main}";</script>', page)


def _modules(main: str, instead: Mapping[str, str]) -> dict[str, str]:
    """Return a module and all that it imports by name, each with its imports looked up in the import map."""
    worklet = json.dumps(_address("text/javascript", (STATIC / "sound-worklet.js").read_text()))
    texts = {name: (STATIC / instead.get(name, name)).read_text() for name in needed_by(main, instead)}
    bare = {name: _NEEDED.sub(lambda found: found[0].replace('"./', '"'), text) for name, text in texts.items()}
    return {name: text.replace(_WORKLET, worklet) for name, text in bare.items()}


def needed_by(name: str, instead: Mapping[str, str] | None = None) -> list[str]:
    """Return a module and all that it imports, each once, by their places in the folder of the page's files."""
    found, waiting = [], [name]
    while waiting:
        each = waiting.pop()
        if each not in found:
            found.append(each)
            waiting += _NEEDED.findall((STATIC / (instead or {}).get(each, each)).read_text())
    return found


def _address(kind: str, text: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"
