"""The studio opened: its page served, the pages of an experiment, and a page that plays runs without a server."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from frictionloop.findings import Finding, Result
from frictionloop.parameters import Constant, System, bench
from frictionloop.quantities import must_be, replacing
from frictionloop.quantities.optional_libraries import needed

if TYPE_CHECKING:
    from frictionloop.experiments.protocol import Protocol
    from frictionloop.live.live_session import Session
    from frictionloop.studio.experiment.experiment_server import Addresses
    from frictionloop.studio.experiment.page_respondent import Desk

PORT = 8026
CARRIED = Path(__file__).with_name("play.html")
"""The page of the `scene`, which a wheel carries for those without a compiler (`make play`)."""


class Opened(Result, schema="studio.serve/1"):
    """A studio that can be looked at."""

    address: str
    """With the token that lets its bearer drive, where other machines may come in."""
    watch_address: str = ""
    law: str
    setpoint: str
    """The effect on the plate, or the kind of another set-point."""
    device: str = ""

    def rows(self) -> list[tuple[str, str]]:
        """Return where it is, and what is on it."""
        found = [("open", self.address), ("watch only", self.watch_address), ("law", self.law)]
        found += [("set-point", self.setpoint), ("device", self.device), ("end", "Ctrl-C")]
        return [row for row in found if row[1]]


def serve(
    system: System | None = None,
    effect: str | None = None,
    *,
    device: str | None = None,
    seed: int = 0,
    host: str = "127.0.0.1",
    port: int = PORT,
    replay: str | os.PathLike[str] | None = None,
    opened: Callable[[Opened], Any] = print,
) -> None:
    """Serve the live page until Ctrl-C.

    Parameters
    ----------
    system
        The bench; `bench` if not given, and `scene` if no effect and no device are given either.
    effect
        What lies on the plate: a name of the library, or a TOML file; the set-point of the system if not given.
    device
        Address of a device to drive instead of a simulation, as of ``fl.connect``.
    seed
        Seed of all noise.
    host, port
        Where to listen; any host but this machine's own needs the tokens in the addresses. Port 0 takes a free one.
    replay
        A recorded run (.h5) to play beside the live page.
    opened
        Called with the addresses before the first page is served.

    Raises
    ------
    FrictionloopError
        For an address that cannot be listened at, a device that is not there, or a file that is no run.
    """
    needed("uvicorn", "uvicorn", "studio")
    needed("starlette", "starlette", "studio")
    from frictionloop.studio.background import starting

    with starting():
        import uvicorn

        from frictionloop.studio.connections import LOOPBACK, Doors, listening, open_to_network
        from frictionloop.studio.parameter_panels import effect_name
        from frictionloop.studio.room import Room
        from frictionloop.studio.server import studio_app

        plain = not (system or effect or device)
        shown = scene() if plain else on_plate(system or bench(), effect)
        rings = () if plain else ringing(shown)
        doors = Doors() if host in LOOPBACK else open_to_network()
        recorded = [] if replay is None else [_read(Path(replay))]
        with _session(shown, seed, device) as session, listening(host, port) as bound:
            room = Room(session)
            room.runs.extend(recorded)
            address = f"http://{host}:{bound.getsockname()[1]}/" + ("replay" if recorded else "")
            found = Opened(
                address=f"{address}?token={doors.token}" if doors.token else address,
                watch_address=f"{address}?token={doors.watch_token}" if doors.token else "",
                law=shown.controller.kind,
                setpoint=effect_name(shown) or shown.setpoint.kind,
                device=device or "",
                findings=rings,
            )
            opened(found)
            # Not deflated: numbers in binary hardly shrink, and each frame would wait for it.
            config = uvicorn.Config(
                studio_app(room, doors), log_level="warning", ws="websockets-sansio", ws_max_size=64 * 1024,
                ws_per_message_deflate=False, loop="frictionloop.studio.connections:prompt_loop",
            )  # fmt: skip
            uvicorn.Server(config).run(sockets=[bound])


def ringing(system: System) -> tuple[Finding, ...]:
    """Return that a loop rings by itself in the middle of its band, if it does: its page opens all the same."""
    from frictionloop.analysis.stability import rings_if_linear
    from frictionloop.loop.run_ringing import of_ringing

    model = system.controller.model
    found = rings_if_linear(system.evolve(setpoint=Constant(offset_n=0.5 * (model.floor_n + model.nominal_n))))
    return tuple(of_ringing(found, alone=True, remedy="on the page: Presets, Gains that hold"))


def on_plate(system: System, effect: str | None) -> System:
    """Return a system with an effect of the library or of a file as its set-point; None leaves it."""
    if effect is None:
        return system
    from frictionloop.rendering.effect_toml import find

    return system.evolve(setpoint={"kind": "effect", "effect": find(effect)})


def scene() -> System:
    """Return what the page begins with: wide detents under a dry finger whose friction the open loop does not know."""
    law = {"controller.kind": "notch_pi", "controller.feedforward": True}
    return on_plate(bench().evolve(law | {"friction.nominal_n": 1.3, "friction.occlusion_ratio": 1.0}), "detents")


@contextmanager
def _session(system: System, seed: int, device: str | None) -> Iterator[Session]:
    """Yield the session, whose device is switched off at its end."""
    if device is None:
        from frictionloop.live.live_engines import TwinEngine
        from frictionloop.live.live_session import Session

        yield Session(TwinEngine(system, seed))
        return
    from frictionloop.device import opened
    from frictionloop.live.device_engine import DeviceEngine
    from frictionloop.live.device_session import DeviceSession

    with opened(device, system, seed) as found:
        yield DeviceSession(DeviceEngine(found, system))


def _read(path: Path) -> dict[str, Any]:
    from frictionloop.studio.replay import read_run

    if path.suffix != ".h5":
        raise must_be("RUN", str(path), "a recorded run (.h5)")
    return read_run(path)


@contextmanager
def desk(
    protocol: Protocol, participant: str, address: str = "bench:", host: str = "127.0.0.1", port: int = 0
) -> Iterator[tuple[Desk, Addresses]]:
    """Yield who answers on a page, for ``fl.experiments.run``, and where the two pages of an experiment are.

    Parameters
    ----------
    protocol, participant, address
        As of ``fl.experiments.run``.
    host, port
        Where to listen; any host but this machine's own lets the pages be on other machines. Port 0 takes a free one.

    Raises
    ------
    FrictionloopError
        For an address that cannot be listened at, or a missing extra.
    """
    needed("starlette", "starlette", "studio")
    from frictionloop.experiments.resumable_session import source_of
    from frictionloop.studio.experiment.experiment_server import served
    from frictionloop.studio.experiment.page_respondent import Desk

    found = Desk(protocol, participant, source_of(address))
    with served(found, host, port) as addresses:
        yield found, addresses


class ExportedPage(Result, schema="studio.export/1"):
    """A page that needs no server."""

    path: Path
    runs: tuple[str, ...]
    """Those that it plays; none of the live page."""
    size_mb: float

    def rows(self) -> list[tuple[str, str]]:
        """Return the page, its size, and what it does."""
        does = ("plays", ", ".join(self.runs)) if self.runs else ("runs", "both loops, live, in a browser")
        return [("page", f"{self.path}, {self.size_mb:.1f} MB"), does]


def export(
    path: str | os.PathLike[str],
    runs: Sequence[str | os.PathLike[str]] = (),
    system: System | None = None,
    seed: int = 0,
) -> ExportedPage:
    """Write a page (.html) that needs no server: the live page, or one that plays recorded runs.

    Both loops of the live page are WebAssembly, bit for bit those of ``fl.simulate``.

    Parameters
    ----------
    path
        The page.
    runs
        Recorded runs (.h5). None: the live page.
    system
        The bench of the live page; the `scene` if not given.
    seed
        Seed of its noise.

    Raises
    ------
    FrictionloopError
        For a file that is no run, a page that cannot be written, or a System that has no C (NO-C).
    """
    if runs:
        from frictionloop.studio.replay import page_of

        found = [_read(Path(run)) for run in runs]
        text = page_of(found)
    elif system is None and not seed and CARRIED.exists() and not find_spec("ziglang"):
        found, text = [], CARRIED.read_text(encoding="utf-8")
    else:
        needed("starlette", "starlette", "studio")
        from frictionloop.studio.static_page import play_page

        found, text = [], play_page(system or scene(), seed)
    with replacing(path) as beside:
        beside.write_text(text, encoding="utf-8")
    names, rings = tuple(each["name"] for each in found), () if runs or system is None else ringing(system)
    return ExportedPage(path=Path(path), runs=names, size_mb=len(text) / 1e6, findings=rings)
