"""``frictionloop studio``: the live page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.device import connected
from frictionloop.cli.effect import LAW
from frictionloop.quantities.extra import needed
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.device.live_session import Session
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
MoreRuns = Annotated[Path, Parameter(name="RUN", help="Recorded runs (.h5) for --export.", group=flags.SYSTEM)]
EXAMPLES = r"""Examples

  frictionloop studio
  frictionloop studio my-bench.toml --effect bump
  frictionloop studio --friction.nominal_n 1.3 --controller.kind pi --port 8000
  frictionloop studio --device sim:
  frictionloop studio my-bench.toml --device serial:///dev/ttyACM0
  frictionloop studio --host 0.0.0.0
  frictionloop studio --replay run.h5
  frictionloop studio --export page.html run.h5 other.h5
"""
PORT = 8026


def command(
    file: flags.SystemFile = None,
    /,
    *runs: MoreRuns,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    effect: flags.Run[str | None] = None,
    device: flags.Run[str | None] = None,
    seed: flags.Run[flags.Whole] = 0,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = PORT,
    replay: flags.Result[Path | None] = None,
    export: flags.Result[Path | None] = None,
) -> None:
    """Open the studio: slide on a virtual plate in the browser, open and closed loop side by side.

    Parameters
    ----------
    effect
        What lies on the plate: a name of the library, or a TOML file.
    device
        Drive a device instead: sim:, emulated:IMAGE, tcp://host:port or serial://PORT; its bench is FILE.
    seed
        Seed of all noise.
    host
        Address to listen at; any but this machine's own needs the token that is printed.
    port
        Port to listen at; 0 takes a free one.
    replay
        Play a recorded run (.h5) beside the live page.
    export
        Write a page (.html) that plays the RUNs without a server, or ten seconds of the ghost finger without one.
    """
    if export is not None:
        _export(export, [each for each in (file, *runs) if each is not None], preset, overrides, effect, seed)
        return
    if runs:
        raise FrictionloopError(f"RUN = {str(runs[0])!r}: goes with --export alone; --replay RUN plays one")
    checks.check_count("seed", seed, 0)
    checks.check_count("port", port, 0, 65535)
    needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")
    from frictionloop.studio.beside import starting

    with starting():
        _serve(_system(file, preset, overrides, effect), device, seed, host, port, replay)


def _serve(system: System, device: str | None, seed: int, host: str, port: int, replay: Path | None) -> None:
    """Serve the page until Ctrl-C."""
    import uvicorn

    from frictionloop.studio.listening import listening
    from frictionloop.studio.room import Room
    from frictionloop.studio.safe import LOOPBACK, Doors, open_to_network
    from frictionloop.studio.server import studio_app
    from frictionloop.studio.share import effect_name

    doors = Doors() if host in LOOPBACK else open_to_network()
    recorded = [] if replay is None else [_read(replay)]
    with _session(system, seed, device) as session, listening(host, port) as bound:
        room = Room(session)
        room.runs.extend(recorded)
        address = f"http://{host}:{bound.getsockname()[1]}/" + ("replay" if recorded else "")
        told = [("law", system.controller.kind), ("set-point", effect_name(system) or system.setpoint.kind)]
        lines = [("open", f"{address}?token={doors.token}" if doors.token else address)]
        if device is not None:
            told.append(("device", device))
        if doors.token:
            lines.append(("watch only", f"{address}?token={doors.watch_token}"))
        screen.show(screen.columns([*lines, *told]), "", "Ctrl-C ends it.")
        # Not deflated: numbers in binary hardly shrink, and each frame would wait for it.
        config = uvicorn.Config(
            studio_app(room, doors), log_level="warning", ws="websockets-sansio", ws_max_size=64 * 1024,
            ws_per_message_deflate=False, loop="frictionloop.studio.listening:prompt_loop",
        )  # fmt: skip
        uvicorn.Server(config).run(sockets=[bound])


def _read(path: Path) -> dict[str, Any]:
    from frictionloop.studio.replay import read_run

    if path.suffix != ".h5":
        raise FrictionloopError(f"{path}: must be a recorded run (.h5)")
    return read_run(path)


def _export(
    page: Path, runs: list[Path], preset: Any, overrides: list[str] | None, effect: str | None, seed: int
) -> None:
    """Write the page of recorded runs; without one, of a bench under the ghost finger."""
    checks.check_output("export", page, (".html",))
    from frictionloop.studio.export import page_of, stroked
    from frictionloop.studio.replay import played

    if runs:
        told = [_read(run) for run in runs]
    else:
        with screen.waiting("stroking"):
            told = [played(stroked(_system(None, preset, overrides, effect), seed), "ghost finger")]
    text = page_of(told)
    page.write_text(text, encoding="utf-8")
    screen.show(f"saved as {page} ({len(text) / 1e6:.2f} MB)")


@contextmanager
def _session(system: System, seed: int, device: str | None) -> Iterator[Session]:
    """Yield the session, whose device is switched off at its end."""
    if device is None:
        from frictionloop.device.live_engine import TwinEngine
        from frictionloop.device.live_session import Session

        with screen.waiting("compiling the loop, which is done once"):
            session = Session(TwinEngine(system, seed))
        yield session
        return
    from frictionloop.device.device_session import DeviceSession
    from frictionloop.device.live_device import DeviceEngine

    with connected(device, system, seed) as found:
        yield DeviceSession(DeviceEngine(found, system))


def _system(file: Path | None, preset: Any, overrides: list[str] | None, effect: str | None) -> System:
    """Return the bench of the page; the preset has a law that closes its loop well, and every one an effect."""
    chosen = flags.overrides_of(overrides)
    system, _ = flags.noted(file, preset, overrides, "bench")
    if file is None and preset in (None, "bench") and not any(name.startswith("controller.") for name in chosen):
        system = system.evolve(LAW)  # no flag of a person's, so nothing to note
    if effect is not None:
        from frictionloop.rendering.files import find

        return system.evolve(setpoint={"kind": "effect", "effect": find(effect)})
    if system.setpoint.kind != "effect" and "setpoint.kind" not in chosen:
        if file is not None:
            screen.say(f"{file}: its set-point is a function of time; a grating lies on the plate instead")
        return system.evolve(setpoint={"kind": "effect"})
    return system
