"""``frictionloop design``: what a part of the bench does, and which part does what is wanted."""

from __future__ import annotations

from cyclopts import Group

from frictionloop.cli import design_controller, design_plate, design_sensor
from frictionloop.cli.helptext import group_app

app = group_app(
    "design",
    "Size a part of the bench: from its geometry to what it does, or the other way round.",
    "sensor",
    Group("The bench", sort_key=3),
)
for verb in (design_sensor, design_plate, design_controller):
    name = verb.__name__.rsplit("_", 1)[-1]
    app.command(
        verb.command, name=name, usage=f"frictionloop design {name} {verb.ARGUMENTS}", help_epilogue=verb.EXAMPLES
    )
