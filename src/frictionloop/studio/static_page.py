"""One page that holds recorded runs and all that plays them: no server, no network."""

from __future__ import annotations

import base64
import json
import re
from pathlib import Path
from typing import Any

import xarray as xr

from frictionloop.live.engines import TwinEngine
from frictionloop.live.session import Session, recorded
from frictionloop.parameters import System

STEP_S = 0.02
STATIC = Path(__file__).parent / "static"
_NEEDED = re.compile(r"""^import [^"']*?from "\./([\w./-]+\.js)";$""", re.MULTILINE)
_LINKED = re.compile(r'^<link rel="stylesheet" href="/static/([\w./-]+)">\n', re.MULTILINE)
_STARTS = '<script type="module" src="/static/replay.js"></script>'
_THEME = '<script src="/static/theme.js"></script>'
_ICON = '<link rel="icon" href="/static/icon.svg">'


def page_of(runs: list[dict[str, Any]], title: str = "frictionloop: recorded runs") -> str:
    """Return a page that plays runs, as HTML in one piece.

    Modules keep their text: an import map names each by an address that holds it.

    Parameters
    ----------
    runs : list
        What `read_run` returns of each.
    title : str
        Title of the page.
    """
    page = (STATIC / "replay.html").read_text()
    for name in _LINKED.findall(page):
        page = page.replace(f'<link rel="stylesheet" href="/static/{name}">', f"<style>{_style(name)}</style>")
    page = page.replace(
        _ICON, f'<link rel="icon" href="{_address("image/svg+xml", (STATIC / "icon.svg").read_text())}">'
    )
    page = page.replace("<title>frictionloop replay</title>", f"<title>{_escaped(title)}</title>")
    page = page.replace(_THEME, f"<script>{(STATIC / 'theme.js').read_text()}</script>")
    data = json.dumps(runs, allow_nan=False).replace("<", "\\u003c")
    modules = {name: _address("text/javascript", _bare(name)) for name in needed_by("replay.js")}
    head = f'<script type="importmap">{json.dumps({"imports": modules})}</script>'
    main = (
        f'<script type="application/json" id="runs">{data}</script>\n<script type="module">import "replay.js";</script>'
    )
    return page.replace(_STARTS, f"{head}\n{main}")


def stroked(system: System, seed: int = 0, seconds: float = 10.0) -> xr.Dataset:
    """Return what the ghost finger of a studio does on a System, open and closed loop side by side, as a run."""
    session = Session(TwinEngine(system, seed))
    session.step(0.0)
    for block in range(round(seconds / STEP_S)):
        session.step((block + 1) * STEP_S)
    return recorded(session, seconds)


def needed_by(name: str) -> list[str]:
    """Return a module and all that it imports, each once, by their places in the folder of the page's files."""
    found, waiting = [], [name]
    while waiting:
        each = waiting.pop()
        if each not in found:
            found.append(each)
            waiting += _NEEDED.findall((STATIC / each).read_text())
    return found


def _bare(name: str) -> str:
    """Return a module whose imports are looked up in the import map."""
    return _NEEDED.sub(lambda found: found[0].replace('"./', '"'), (STATIC / name).read_text())


def _style(name: str) -> str:
    return (STATIC / name).read_text().replace("</", "<\\/")


def _address(kind: str, text: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
