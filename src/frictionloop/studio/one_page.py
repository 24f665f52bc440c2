"""A page in one file: styles, modules and data of the studio's own pages, which then ask for nothing."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

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
        page = page.replace(f'<link rel="stylesheet" href="/static/{style}">', f"<style>{_style(style)}</style>")
    icon = _address("image/svg+xml", (STATIC / "icon.svg").read_text())
    page = page.replace(_ICON, f'<link rel="icon" href="{icon}">')
    page = re.sub("<title>.*</title>", lambda _: f"<title>{_escaped(title)}</title>", page)
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


def _style(name: str) -> str:
    return (STATIC / name).read_text().replace("</", "<\\/")


def _address(kind: str, text: str) -> str:
    return f"data:{kind};base64,{base64.b64encode(text.encode()).decode()}"


def _escaped(text: str) -> str:
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
