"""The verbs: the whole command line as one app. Adding a verb is one import and one line here."""

from __future__ import annotations

from cyclopts import Group

import frictionloop as fl
from frictionloop.cli import (
    compare,
    design,
    device,
    effect,
    experiment,
    experiment_sessions,
    explain,
    firmware,
    identify,
    reproduce,
    simulate,
    studio,
    sweep,
)
from frictionloop.cli.verb import HERE, add, add_group, new_app

PAPER, LOOP, BENCH, DEVICE = (
    Group(name, sort_key=1 + place) for place, name in enumerate(("The paper", "The loop", "The bench", "The device"))
)


app = new_app(
    "frictionloop",
    "Closed-loop control of fingertip friction on ultrasonic surfaces.",
    help_epilogue="Examples: frictionloop simulate --help\n\n"
    "A law, friction law, signal or metric of your own: --use FILE.py registers it.",
    version=lambda: f"frictionloop {fl.outputs.cited_version()}",
    suppress_keyboard_interrupt=False,
)
app["--version"].group = HERE
add(app, "frictionloop", [reproduce.command], group=PAPER)
add(app, "frictionloop", [simulate.command, sweep.command, compare.command, studio.command], group=LOOP)
add(app, "frictionloop", [explain.command], group=HERE)
designs = [design.sensor, design.plate, design.controller, design.check, design.limits]
add_group(app, "design", "Find a controller, check one, or size plate and sensor.", "sensor", BENCH, designs)
effects = [effect.list_effects, effect.show, effect.check, effect.play, effect.import_file]
add_group(app, "effect", "Effects, friction by place and time: preview what a finger gets.", "show", LOOP, effects)
analyses = [identify.channels, identify.bench, identify.compare, identify.run]
add_group(app, "identify", "From recordings of a lab to its bench.", "channels", BENCH, analyses)
images = [firmware.export, firmware.build, firmware.law]
add_group(app, "firmware", "The microcontroller: its parameter table, its image.", "export", DEVICE, images)
studies = [experiment.new, experiment.check]
studies += [experiment_sessions.run, experiment_sessions.resume, experiment_sessions.amend]
studies += [experiment.simulate, experiment.report, experiment.export, experiment.power]
add_group(app, "experiment", "Experiments on friction: protocols, sessions, reports.", "simulate", DEVICE, studies)
boards = [device.list_ports, device.info, device.set_parameters, device.run, device.play]
boards += [device.recover, device.clear, device.monitor, device.flash]
add_group(app, "device", "A board on a port, or a simulated one.", "run", DEVICE, boards)
