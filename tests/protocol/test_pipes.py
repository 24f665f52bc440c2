"""Serial ports and TCP connections: what they carry, and how each thing that goes wrong is called."""

from __future__ import annotations

import errno
import os
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import pytest
import serial

import frictionloop as fl
from frictionloop.device.errors import Unplugged
from frictionloop.device.transport import SerialPipe
from frictionloop.loop.growing_file import Spool


class Served:
    """A board that answers on a file descriptor from a thread."""

    def __init__(self, board: Any, descriptor: int) -> None:
        self.board, self.descriptor, self.on = board, descriptor, True
        self.began, self.first = time.monotonic(), board.tick
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self) -> None:
        while self.on:
            try:
                heard = os.read(self.descriptor, 4096) if select.select([self.descriptor], [], [], 0.002)[0] else b""
                # An answer has this time: after what it answers was sent, before it is received.
                elapsed_s = time.monotonic() - self.began
                self.board.advance(self.first + int(elapsed_s * 5000) - self.board.tick)
                self.board.receive(heard)
                while self.board.out:
                    os.write(self.descriptor, self.board.out.pop(0))
            except OSError:
                return

    def stop(self) -> None:
        self.on = False
        self.thread.join()


@pytest.fixture
def port(boards: Any) -> Iterator[tuple[str, Callable[[], None], Served]]:
    """Yield (name of a port with a board behind it, what pulls it out, the board served)."""
    ours, theirs = os.openpty()
    served = Served(boards.Board(), ours)

    def pull() -> None:
        served.stop()
        os.close(ours)

    yield os.ttyname(theirs), pull, served
    os.close(theirs)
    if served.on:
        pull()


def test_a_run_over_a_serial_port(port: Any) -> None:
    with fl.connect(f"serial://{port[0]}") as device:
        run = device.run(0.5, 0.4)
        assert (run.sizes["time"], run.attrs["lost_samples"], run.attrs["source"]) == (2000, 0, "device")


def test_the_plate_is_off_before_a_run_is_packed_and_saved(port: Any, tmp_path: Any, monkeypatch: Any) -> None:
    """A board whose host is silent for 200 ms while its loop is on is at fault."""

    finish = Spool.finish

    def slowly(*given: Any) -> Any:
        time.sleep(0.3)
        return finish(*given)

    def stopped(rows: int) -> None:
        if rows > 500:
            raise KeyboardInterrupt

    monkeypatch.setattr(Spool, "finish", slowly)
    board = port[2].board
    with fl.connect(f"serial://{port[0]}") as device:
        device.run(0.5, 0.1, path=tmp_path / "run.h5")
        assert (board.state, board.fault) == (0, 0)
        with pytest.raises(KeyboardInterrupt):
            device.run(0.5, 2.0, path=tmp_path / "stopped.h5", progress=stopped)
        whole = (tmp_path / "run.h5").read_bytes()
        with pytest.raises(fl.FrictionloopError, match="exists; name a new file"):
            device.run(0.5, 0.1, path=tmp_path / "run.h5")
        assert (tmp_path / "run.h5").read_bytes() == whole
        assert (board.state, board.fault) == (0, 0)


def test_two_hosts(port: Any) -> None:
    with (
        fl.connect(f"serial://{port[0]}"),
        pytest.raises(fl.DeviceError, match=f"^{port[0]}: in use by another program$"),
    ):
        fl.connect(f"serial://{port[0]}")


def test_pulled_out_in_mid_run(port: Any, tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("frictionloop.device.device_run.PAUSE_S", 0.0)
    device = fl.connect(f"serial://{port[0]}")
    pulled = []

    def progress(rows: int) -> None:
        if rows > 500 and not pulled:
            pulled.append(port[1]())

    with pytest.raises(fl.Interrupted, match=f"^{port[0]}: unplugged .* samples are in"):
        device.run(0.5, 30.0, path=tmp_path / "cut.h5", progress=progress)
    assert fl.load(tmp_path / "cut.h5").sizes["time"] >= 500


def test_a_port_of_another_group(monkeypatch: Any, tmp_path: Any) -> None:
    def denied(*given: Any, **more: Any) -> None:
        raise serial.SerialException(errno.EACCES, "could not open port")

    group = __import__("grp").getgrgid(tmp_path.stat().st_gid).gr_name
    monkeypatch.setattr(serial, "Serial", denied)
    with pytest.raises(fl.DeviceError, match=f"permission denied; sudo usermod -aG {group}"):
        SerialPipe(str(tmp_path))


def test_a_run_over_tcp_and_a_connection_that_ends(boards: Any, tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("frictionloop.device.device_run.PAUSE_S", 0.0)
    listening = socket.create_server(("127.0.0.1", 0))
    address = f"tcp://127.0.0.1:{listening.getsockname()[1]}"
    accepted: list[Any] = []

    def accept() -> None:
        accepted.append(listening.accept()[0])
        accepted.append(Served(boards.Board(), accepted[0].fileno()))
        listening.close()

    threading.Thread(target=accept, daemon=True).start()
    device = fl.connect(address)
    assert device.run(0.5, 0.2).sizes["time"] == 1000

    def progress(rows: int) -> None:
        if rows > 500 and accepted[1].on:
            accepted[1].stop()
            accepted[0].close()

    with pytest.raises(fl.Interrupted, match=f"^{address}: "):
        device.run(0.5, 30.0, path=tmp_path / "cut.h5", progress=progress)
    with pytest.raises(fl.DeviceError, match="cannot be reached"):
        device.reconnect()
    with pytest.raises(Unplugged):
        device.statistics()
