"""How help looks: names and meanings in two columns under plain headings, no boxes."""

from __future__ import annotations

from cyclopts import App, Group, Parameter
from cyclopts.help import DefaultFormatter, PanelSpec
from rich.box import Box

_NO_LINES = Box("    \n" * 8)

HELP_STYLE = DefaultFormatter(panel_spec=PanelSpec(box=_NO_LINES, padding=(0, 3), border_style="bold"))
"""Formatter of every help page."""


def group_app(name: str, text: str, example: str, group: Group) -> App:
    """Return the app of a verb whose commands are parts of one job; ``example`` is one of them."""
    app = App(
        name=name,
        help=text,
        usage=f"frictionloop {name} COMMAND [OPTIONS]",
        help_epilogue=f"Each command has its own help with examples: frictionloop {name} {example} --help",
        help_format="plaintext",
        help_formatter=HELP_STYLE,
        group=group,
        default_parameter=Parameter(negative=()),
    )
    app["--help"].group = Group("About", sort_key=9)
    return app
