"""One owner of a loop, as its hosts see it: a second client, a table changed under way, a board that began anew."""

from __future__ import annotations

import contextlib
import select
import socket
import threading
from collections.abc import Iterator
from typing import Any

import pytest

import frictionloop as fl
from frictionloop.device.device import Device
from frictionloop.device.errors import Refused

REFUSED = "the device refuses, another host's loop is on$"


class Hub:
    """A TCP server that passes what any client says to one board, and what the board says to all of them.

    Its time goes on by three ticks with every message, so that no test depends on the load of this machine.
    """

    def __init__(self, board: Any) -> None:
        self.board, self.listening, self.on = board, socket.create_server(("127.0.0.1", 0)), True
        self.address = f"tcp://127.0.0.1:{self.listening.getsockname()[1]}"
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self) -> None:
        clients: list[socket.socket] = []
        while self.on:
            for ready in select.select([self.listening, *clients], [], [], 0.01)[0]:
                if ready is self.listening:
                    clients.append(self.listening.accept()[0])
                elif data := received(ready):
                    self.board.receive(data)
                    self.board.advance(3)
                else:
                    clients.remove(ready)
                    ready.close()
            while self.board.out:
                frame = self.board.out.pop(0)
                for client in clients:
                    with contextlib.suppress(ConnectionError):
                        client.sendall(frame)
        for client in [*clients, self.listening]:
            client.close()

    def stop(self) -> None:
        self.on = False
        self.thread.join()


def received(client: socket.socket) -> bytes:
    """Return what a client said, nothing when it has gone."""
    try:
        return client.recv(4096)
    except ConnectionError:
        return b""


@pytest.fixture
def hub(boards: Any) -> Iterator[Hub]:
    found = Hub(boards.Firmware())
    yield found
    found.stop()


def test_a_second_tcp_client_may_stop_the_plate(hub: Hub) -> None:
    with fl.connect(hub.address) as first, fl.connect(hub.address) as second:
        first.mode("closed")
        second.mode("idle")
        second.clear()  # the loop is off, and nobody's: what it commands is taken


def test_a_second_tcp_client_looks_on_and_commands_nothing(hub: Hub) -> None:
    with fl.connect(hub.address) as first, fl.connect(hub.address) as second:
        first.mode("closed")
        for command in (
            lambda: second.mode("closed"),
            second.clear,
            lambda: second.set("setpoint.hold_n", 0.5),
            lambda: second.play([0.5], spacing_s=1e-3),
        ):
            with pytest.raises(Refused, match=REFUSED):
                command()
        assert second.statistics()["ticks"] > 0
        first.mode("idle")
        first.mode("open")
    with fl.connect(hub.address) as third:
        third.mode("closed")


def test_a_second_client_stops_the_loop_when_it_is_asked_to_and_not_by_leaving(hub: Hub) -> None:
    def is_refused(device: fl.Device) -> bool:
        try:
            device.set("setpoint.hold_n", 0.5)
        except Refused:
            return True
        return False

    with fl.connect(hub.address) as first, fl.connect(hub.address) as other:
        first.mode("closed")
        with fl.connect(hub.address) as second:
            with pytest.raises(Refused, match=REFUSED):
                second.mode("closed")
            with pytest.raises(Refused, match=REFUSED):
                second.run(0.5, 0.1)
        assert is_refused(other)  # the loop is on
        other.mode("idle")
        assert not is_refused(other)


def test_who_was_there_before_is_told_that_another_host_has_said_hello(hub: Hub) -> None:
    with fl.connect(hub.address) as first, fl.connect(hub.address) as second:
        first.mode("idle")
        second.mode("idle")
        with pytest.raises(Refused, match="session ended"):
            first.mode("closed")
        first.reconnect()
        first.mode("closed")
        second.reconnect()
        with pytest.raises(Refused, match=REFUSED):
            second.mode("closed")


def test_a_reconnected_owner_is_the_owner_still(hub: Hub) -> None:
    with fl.connect(hub.address) as device:
        device.mode("closed")
        device.reconnect()
        device.mode("open")


@pytest.mark.parametrize("rows", [1000, 4990])
def test_a_table_changed_in_mid_run_ends_the_run_and_the_file_says_so(tmp_path: Any, rows: int) -> None:
    changed = []

    def change(reached: int) -> None:
        if reached >= rows and not changed:
            changed.append(device.set("setpoint.hold_n", 0.4))
            device.commit()

    why = r"table: changed before tick \d+, commit 1"
    with fl.connect("sim:") as device:
        with pytest.raises(fl.Interrupted, match=f"^{why}; "):
            device.run(0.5, 1.0, path=tmp_path / "run.h5", progress=change)
        assert fl.load(tmp_path / "run.h5").attrs["ended"].startswith("table: changed")
        assert device.run(0.5, 0.1).attrs["ended"] == "complete"


def test_a_board_that_begins_anew_ends_the_run(boards: Any, tmp_path: Any) -> None:
    board, lines = boards.Firmware(), []

    def opened() -> Any:
        lines.append(boards.Line(board))
        return lines[-1]

    def restart(reached: int) -> None:
        if reached > 1000 and lines[-1].board is board:
            anew = boards.Firmware()
            anew.tick = board.tick
            lines[-1].board = anew

    device = Device(opened)
    with pytest.raises(fl.Interrupted, match=r"^session: ended, device began anew; "):
        device.run(0.5, 1.0, path=tmp_path / "run.h5", progress=restart)
    assert "began anew" in fl.load(tmp_path / "run.h5").attrs["ended"]
