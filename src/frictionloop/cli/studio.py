"""``frictionloop studio``: the live page."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

import frictionloop as fl
from frictionloop.cli import file_arguments, flags, screen
from frictionloop.cli.verb import verb
from frictionloop.findings import Finding

if TYPE_CHECKING:
    from frictionloop.studio import Opened

MoreRuns = Annotated[Path, Parameter(name="RUN", help="Recorded runs (.h5) for --export.", group=flags.SYSTEM)]
PORT = 8026


@verb(
    "studio [FILE] [OPTIONS]",
    "",
    "my-bench.toml --effect bump",
    "my-bench.toml --device serial:///dev/ttyACM0",
    "--replay run.h5",
    "--export play.html",
    "--export page.html run.h5 other.h5",
)
def command(
    file: flags.SystemFile = None,
    /,
    *runs: MoreRuns,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    effect: flags.Run[str | None] = None,
    device: flags.Run[str | None] = None,
    seed: flags.Seed = 0,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = PORT,
    replay: flags.Result[Path | None] = None,
    export: flags.Result[Path | None] = None,
    shown: screen.Shown = screen.BRIEFLY,
) -> None:
    """Slide on a virtual plate in the browser, open and closed loop at once.

    Parameters
    ----------
    effect
        What lies on the plate: a name of the library, or a TOML file.
    device
        Drive a device instead: sim:, emulated:IMAGE, tcp://host:port or serial://PORT; its bench is FILE.
    host
        Address to listen at; any but this machine's own needs the token that is printed.
    port
        Port to listen at; 0 takes a free one.
    replay
        Play a recorded run (.h5) beside the live page.
    export
        Write this page, or one that plays the RUNs, as a file (.html) that needs no server.
    """
    if export is not None:
        file_arguments.check_output("export", export, (".html",))
        if file is not None and (runs or file.suffix == ".h5"):
            runs, file = (file, *runs), None
        with fl.progress.waiting("" if runs else "translating the loop"):
            named = not runs and (file or preset or overrides or effect)
            given = _given(file, preset, overrides, effect) if named else None
            found = fl.studio.export(export, runs, given and given.system, seed)
        shown.show(found.with_findings(given.findings if given else ()))
        return
    if runs:
        raise fl.FrictionloopError(f"RUN = {str(runs[0])!r}: goes with --export; --replay RUN plays one")
    file_arguments.check_count("seed", seed, 0)
    file_arguments.check_count("port", port, 0, 65535)
    named = file or preset or overrides or effect or device
    given = _given(file, preset, overrides, effect)
    with ExitStack() as opening:
        opening.enter_context(fl.progress.waiting(f"looking for {device}" if device else "compiling the loop"))

        def opened(found: Opened) -> None:
            opening.close()
            shown.show(found.with_findings(given.findings))

        system = given.system if named else None
        fl.studio.serve(system, device=device, seed=seed, host=host, port=port, replay=replay, opened=opened)


def _given(file: Path | None, preset: Any, overrides: list[str] | None, effect: str | None) -> flags.Given:
    """Return the bench of the page, which has an effect, by itself a grating, and what is to be known of it."""
    named = flags.overrides_of(overrides)
    given = flags.system_given(file, preset, overrides, "bench", closing=True)
    system, found = given.system, given.findings
    if effect is not None:
        system = system.evolve(setpoint={"kind": "effect", "effect": fl.rendering.find(effect)})
    elif system.setpoint.kind != "effect" and "setpoint.kind" not in named:
        found += (Finding("STUDIO-EFFECT", value=system.setpoint.kind),) if file else ()
        system = system.evolve(setpoint={"kind": "effect"})
    return given._replace(system=system, findings=found)
