"""How help looks: names and meanings in two columns under plain headings, no boxes."""

from __future__ import annotations

from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

_NO_LINES = Box("    \n" * 8)

HELP_STYLE = DefaultFormatter(panel_spec=PanelSpec(box=_NO_LINES, padding=(0, 3), border_style="bold"))
"""Formatter of every help page."""
