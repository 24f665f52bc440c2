"""``frictionloop studio``: the live page."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.cli import checks, flags, screen
from frictionloop.cli.device import connected
from frictionloop.cli.effect import LAW
from frictionloop.quantities.extra import needed
from frictionloop.quantities.units import FrictionloopError

if TYPE_CHECKING:
    from frictionloop.device.live_session import Session
    from frictionloop.parameters import System

ARGUMENTS = "[FILE] [OPTIONS]"
EXAMPLES = r"""Examples

  frictionloop studio
  frictionloop studio my-bench.toml --effect bump
  frictionloop studio --friction.nominal_n 1.3 --controller.kind pi --port 8000
  frictionloop studio --device sim:
  frictionloop studio my-bench.toml --device serial:///dev/ttyACM0
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
    device: flags.Run[str | None] = None,
    seed: flags.Run[flags.Whole] = 0,
    host: flags.Run[str] = "127.0.0.1",
    port: flags.Run[flags.Whole] = PORT,
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
    """
    checks.check_count("seed", seed, 0)
    checks.check_count("port", port, 0, 65535)
    uvicorn = needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")
    system = _system(file, preset, overrides, effect)
    from frictionloop.studio.room import Room
    from frictionloop.studio.safe import LOOPBACK, Doors, open_to_network
    from frictionloop.studio.server import studio_app
    from frictionloop.studio.share import effect_name

    doors = Doors() if host in LOOPBACK else open_to_network()
    with _session(system, seed, device) as session, _listening(host, port) as listening:
        address = f"http://{host}:{listening.getsockname()[1]}/"
        told = [("law", system.controller.kind), ("set-point", effect_name(system) or system.setpoint.kind)]
        lines = [("open", f"{address}?token={doors.token}" if doors.token else address)]
        if device is not None:
            told.append(("device", device))
        if doors.token:
            lines.append(("watch only", f"{address}?token={doors.watch_token}"))
        screen.show(screen.columns([*lines, *told]), "", "Ctrl-C ends it.")
        config = uvicorn.Config(studio_app(Room(session), doors), log_level="warning", ws="websockets-sansio")
        config.ws_max_size = 64 * 1024
        uvicorn.Server(config).run(sockets=[listening])


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
