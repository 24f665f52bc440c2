"""Where the templates of the report and of the certificate are."""

from __future__ import annotations

from jinja2 import Environment, PackageLoader, StrictUndefined


def templates() -> Environment:
    """Return the templates: a name that they are not given is an error."""
    return Environment(
        loader=PackageLoader("frictionloop.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
