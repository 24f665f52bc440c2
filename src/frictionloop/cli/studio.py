"""``frictionloop studio``: the live page."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.effect import LAW
from frictionloop.quantities.extra import needed
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop studio
  frictionloop studio my-bench.toml --effect bump
  frictionloop studio --friction.nominal_n 1.3 --controller.kind pi --port 8000
  frictionloop studio --host 0.0.0.0
"""
PORT = 8026


def command(
    file: flags.SystemFile = None,
    /,
    *,
    preset: flags.BenchPreset = None,
    overrides: flags.Overrides = None,
    effect: flags.Run[str | None] = None,
    seed: flags.Run[flags.Whole] = 0,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = PORT,
) -> None:
    """Open the studio: slide on a virtual plate in the browser, open and closed loop side by side.

    Parameters
    ----------
    effect
        What lies on the plate: a name of the library, or a TOML file.
    seed
        Seed of all noise.
    host
        Address to listen at; any but this machine's own needs the token that is printed.
    port
        Port to listen at; 0 takes a free one.
    """
    checks.check_count("seed", seed, 0)
    checks.check_count("port", port, 0, 65535)
    uvicorn = needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")
    system = _system(file, preset, overrides, effect)
    from frictionloop.device.live_engine import TwinEngine
    from frictionloop.device.live_session import Session
    from frictionloop.studio.room import Room
    from frictionloop.studio.safe import LOOPBACK, Doors, open_to_network
    from frictionloop.studio.server import studio_app
    from frictionloop.studio.share import effect_name

    doors = Doors() if host in LOOPBACK else open_to_network()
    with screen.waiting("compiling the loop, which is done once"):
        room = Room(Session(TwinEngine(system, seed)))
    with _listening(host, port) as listening:
        address = f"http://{host}:{listening.getsockname()[1]}/"
        told = [("law", system.controller.kind), ("set-point", effect_name(system) or system.setpoint.kind)]
        lines = [("open", f"{address}?token={doors.token}" if doors.token else address)]
        if doors.token:
            lines.append(("watch only", f"{address}?token={doors.watch_token}"))
        screen.show(screen.columns([*lines, *told]), "", "Ctrl-C ends it.")
        config = uvicorn.Config(studio_app(room, doors), log_level="warning", ws="websockets-sansio")
        config.ws_max_size = 64 * 1024
        uvicorn.Server(config).run(sockets=[listening])


def _listening(host: str, port: int) -> Any:
    """Return a socket that listens, so that the address is known before the server is up."""
    import socket

    listening = socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET)
    listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        listening.bind((host.strip("[]"), port))
    except OSError as error:
        raise FrictionloopError(f"host {host}, port {port}: cannot listen there ({error.strerror})") from None
    return listening


def _system(file: Path | None, preset: Any, overrides: list[str] | None, effect: str | None) -> System:
    """Return the bench of the page; the preset has a law that closes its loop well, and every one an effect."""
    chosen = flags.overrides_of(overrides)
    system, _ = flags.given(file, preset, overrides, "bench")
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
