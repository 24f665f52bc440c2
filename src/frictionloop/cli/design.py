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
app.command(
    design_sensor.command,
    name="sensor",
    usage=f"frictionloop design sensor {design_sensor.ARGUMENTS}",
    help_epilogue=design_sensor.EXAMPLES,
)
app.command(
    design_plate.design_plate,
    name="plate",
    usage=f"frictionloop design plate {design_plate.ARGUMENTS}",
    help_epilogue=design_plate.EXAMPLES,
)
app.command(
    design_controller.command,
    name="controller",
    usage=f"frictionloop design controller {design_controller.ARGUMENTS}",
    help_epilogue=design_controller.EXAMPLES,
)
