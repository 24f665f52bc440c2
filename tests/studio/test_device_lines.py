"""A board behind each kind of line, driven from a room: set up, armed, changed while samples go on, stopped."""

from __future__ import annotations

import time
from contextlib import contextmanager

import numpy as np
import pytest
from wired_board import wired

import frictionloop as fl
from frictionloop.cli.flags import LAW
from frictionloop.device.device import connect
from frictionloop.live.device_engine import DeviceEngine
from frictionloop.live.device_session import DeviceSession
from frictionloop.live.live_engines import CHANNELS
from frictionloop.studio.commands import obey
from frictionloop.studio.connections import Guest
from frictionloop.studio.room import Room

pytestmark = pytest.mark.slow
SYSTEM = fl.bench().evolve(LAW | {"setpoint": {"kind": "effect"}})
SILENT_S = 0.15
"""A board hears nothing for so long when its host stands still; after 0.2 s it switches off."""
ROW = {name: row for row, name in enumerate(CHANNELS)}


@contextmanager
def line(way, folder):
    """Yield the address of a board."""
    if way == "emulated":
        pytest.importorskip("ziglang", reason="the image is built by zig: install frictionloop[image]")
        pytest.importorskip("unicorn", reason="the board is emulated by unicorn: install frictionloop[emulator]")
        yield f"emulated:{fl.firmware.build(SYSTEM, folder).image}"
        return
    with wired(way, SYSTEM) as (address, _):
        yield address


def pass_until(room, guest, there, most_s=60.0):
    """Let time pass with a driving page that is there, until something is so."""
    last = time.monotonic()
    end = last + most_s
    while not there():
        now = time.monotonic()
        assert now < end, room.status()
        if now - last > SILENT_S:
            pytest.skip(f"this machine stood still for {now - last:.2g} s, in which a board switches off by itself")
        last = now
        obey(room, guest, {"do": "here"})
        room.heard(guest)
        room.step()
        time.sleep(0.002)


@pytest.mark.parametrize("way", ["serial", "tcp", "emulated"])
def test_a_board_is_driven_and_changed_while_its_samples_go_on(way, tmp_path):
    with line(way, tmp_path) as address, connect(address, SYSTEM) as device:
        room = Room(DeviceSession(DeviceEngine(device, SYSTEM)))
        guest = Guest(may_drive=True)
        room.join(guest)
        session, engine = room.session, room.session.engine

        def samples(count):
            start = session.ticks
            pass_until(room, guest, lambda: session.ticks > start + count)

        def state():
            return room.status()["device"]["state"]

        samples(300)
        assert (room.status()["source"], state()) == ("emulated" if way == "emulated" else "device", "idle")
        obey(room, guest, {"do": "arm", "state": "closed"})
        pass_until(room, guest, lambda: state() == "closed")
        samples(1000)
        rows = session.last(0.1)
        assert np.nanmax(rows[ROW["closed_um"]]) > 0.1
        assert np.isnan(rows[ROW["closed_n"]]).all() == (way != "emulated")  # no sensor shows the force on the finger
        assert np.isfinite(rows[ROW["measured_n"]]).all()
        session.change(engine.system.evolve({"controller.kp": 0.5}))
        assert device.controller.kp != 0.5  # nobody waits until the table is written
        pass_until(room, guest, lambda: device.controller.kp == 0.5)
        session.change(engine.system.evolve({"setpoint.effect": fl.rendering.LIBRARY["constant"]}))
        pass_until(room, guest, lambda: abs(session.last(0.01)[ROW["asked_n"], -1] - 0.45) < 1e-3)
        samples(500)
        pass_until(room, guest, lambda: np.ptp(session.last(0.05)[ROW["asked_n"]]) < 1e-3)
        assert (engine.device_status()["fault"], engine.refused, engine.device_status()["lost"]) == ("", [], 0)
        obey(room, guest, {"do": "stop"})
        pass_until(room, guest, lambda: state() == "idle")


def test_a_line_that_was_pulled_is_told_and_taken_up_again_with_the_plate_off():
    with wired("tcp", SYSTEM) as (address, pull), connect(address, SYSTEM) as device:
        room = Room(DeviceSession(DeviceEngine(device, SYSTEM)))
        guest = Guest(may_drive=True)
        room.join(guest)
        session, engine = room.session, room.session.engine
        pass_until(room, guest, lambda: session.ticks > 300)
        obey(room, guest, {"do": "arm", "state": "closed"})
        pass_until(room, guest, lambda: engine.state == "closed")
        session.change(engine.system.evolve({"controller.kp": 0.5}))
        pull()
        pass_until(room, guest, lambda: engine.armed == "idle")
        assert engine.trouble.startswith(f"{address}: ")  # closed, or reset where a frame was under way
        pass_until(room, guest, lambda: "back, plate off" in engine.trouble)
        pass_until(room, guest, lambda: device.controller.kp == 0.5)  # what was on its way is written anew
        before = session.ticks
        pass_until(room, guest, lambda: session.ticks > before + 1000)
        assert (engine.refused, engine.armed) == ([], "idle")
        assert engine.state in ("idle", "fault")  # the board switches off, or finds that its host was silent
