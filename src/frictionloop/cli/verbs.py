"""The verbs: the whole command line as one app. Adding a verb is one import and one line here."""

from __future__ import annotations

from typing import Any

from cyclopts import Group

import frictionloop as fl
from frictionloop.cli import (
    compare,
    design_check,
    design_controller,
    design_limits,
    design_plate,
    design_sensor,
    device,
    device_flash,
    device_info,
    device_play,
    device_recover,
    device_run,
    device_set,
    effect,
    effect_import,
    experiment,
    explain,
    firmware,
    identify,
    identify_bench,
    identify_compare,
    identify_run,
    reproduce,
    sessions,
    simulate,
    studio,
    study_results,
    sweep,
)
from frictionloop.cli.verb import HERE, Verb, add, group_app, new_app

PAPER, LOOP, BENCH, DEVICE = (
    Group(name, sort_key=1 + place) for place, name in enumerate(("The paper", "The loop", "The bench", "The device"))
)


def _version() -> str:
    """Return what results are cited by, of a clone with the commit."""
    return f"frictionloop {fl.outputs.cited_version()}"


def _verb(module: Any) -> Verb:
    """Return the verb of a module with one; what it computes with is imported inside."""
    return Verb(module.command, module.ARGUMENTS, module.EXAMPLES)


app = new_app(
    "frictionloop",
    "Closed-loop control of fingertip friction on ultrasonic surfaces.",
    help_epilogue="Examples: frictionloop simulate --help\n\n"
    "A law, friction law, signal or metric of your own: --use FILE.py registers it.",
    version=_version,
    suppress_keyboard_interrupt=False,
)
app["--version"].group = HERE
add(app, "frictionloop", {"reproduce": _verb(reproduce)}, group=PAPER)
add(
    app,
    "frictionloop",
    {"simulate": _verb(simulate), "sweep": _verb(sweep), "compare": _verb(compare), "studio": _verb(studio)},
    group=LOOP,
)
add(app, "frictionloop", {"explain": _verb(explain)}, group=HERE)
app.command(
    group_app(
        "design",
        "Find a controller, check one, or size plate and sensor.",
        "sensor",
        BENCH,
        {
            "sensor": _verb(design_sensor),
            "plate": _verb(design_plate),
            "controller": _verb(design_controller),
            "check": _verb(design_check),
            "limits": _verb(design_limits),
        },
    )
)
app.command(
    group_app(
        "effect",
        "Effects, friction by place and time: preview what a finger gets.",
        "show",
        LOOP,
        {
            "list": Verb(effect.list_effects, "[--json]", effect.LIST_EXAMPLES),
            "show": Verb(effect.show, effect.ARGUMENTS, effect.SHOW_EXAMPLES),
            "check": Verb(effect.check, effect.ARGUMENTS, effect.CHECK_EXAMPLES),
            "play": Verb(effect.play, effect.ARGUMENTS, effect.PLAY_EXAMPLES),
            "import": _verb(effect_import),
        },
    )
)
app.command(
    group_app(
        "identify",
        "From recordings of a lab to its bench.",
        "channels",
        BENCH,
        {
            "channels": Verb(identify.channels, "FILE [OPTIONS]", identify.CHANNELS_EXAMPLES),
            "bench": _verb(identify_bench),
            "compare": _verb(identify_compare),
            "run": _verb(identify_run),
        },
    )
)
app.command(
    group_app(
        "firmware",
        "The microcontroller: its parameter table, its image.",
        "export",
        DEVICE,
        {
            "export": Verb(firmware.export, firmware.ARGUMENTS, firmware.EXPORT_EXAMPLES),
            "build": Verb(firmware.build, firmware.ARGUMENTS, firmware.BUILD_EXAMPLES),
            "law": Verb(firmware.law, "[FILE] --out law.c [OPTIONS]", firmware.LAW_EXAMPLES),
        },
    )
)
app.command(
    group_app(
        "experiment",
        "Experiments on friction: protocols, sessions, reports.",
        "simulate",
        DEVICE,
        {
            "new": Verb(experiment.new, "FILE [OPTIONS]", experiment.NEW_EXAMPLES),
            "check": Verb(experiment.check, "PROTOCOL [OPTIONS]", experiment.CHECK_EXAMPLES),
            "run": Verb(sessions.run, "PROTOCOL --participant CODE [OPTIONS]", sessions.RUN_EXAMPLES),
            "resume": Verb(sessions.resume, "FOLDER", sessions.RESUME_EXAMPLES),
            "simulate": Verb(study_results.simulate, "PROTOCOL [OPTIONS]", study_results.SIMULATE_EXAMPLES),
            "report": Verb(study_results.report, "FOLDER [OPTIONS]", study_results.REPORT_EXAMPLES),
            "export": Verb(experiment.export, "FOLDER OUT [OPTIONS]", experiment.EXPORT_EXAMPLES),
            "power": Verb(experiment.power, "PROTOCOL [OPTIONS]", experiment.POWER_EXAMPLES),
        },
    )
)
app.command(
    group_app(
        "device",
        "A board on a port, or a simulated one.",
        "run",
        DEVICE,
        {
            "list": Verb(device.list_ports, "[OPTIONS]", device.LIST_EXAMPLES),
            "info": _verb(device_info),
            "set": _verb(device_set),
            "run": _verb(device_run),
            "play": _verb(device_play),
            "recover": _verb(device_recover),
            "clear": Verb(device.clear, "ADDRESS [OPTIONS]", device.CLEAR_EXAMPLES),
            "monitor": Verb(device.monitor, "ADDRESS [OPTIONS]", device.MONITOR_EXAMPLES),
            "flash": _verb(device_flash),
        },
    )
)
