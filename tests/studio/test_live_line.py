"""A line that went away is tried again on a thread of its own."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from studio_pages import until

import frictionloop as fl
from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.live.device_engine import DeviceEngine, LineAgain

SYSTEM = fl.bench().evolve({"setpoint": {"kind": "effect"}})


def test_a_try_that_takes_long_holds_nobody_up_and_is_told_once():
    answers = threading.Event()
    again = LineAgain(answers.wait)
    again.try_on()
    again.end()
    assert not again.opened()  # nothing was lost
    again.lost()
    again.try_on()
    assert again.away and not again.opened()
    answers.set()
    again.end()
    assert not again.away
    assert [again.opened(), again.opened()] == [True, False]


def test_a_line_whose_try_fails_is_away_until_a_later_one_succeeds():
    tries = []

    def reconnect():
        tries.append(1)
        if len(tries) < 2:
            raise DeviceError("serial:///nowhere: no answer")

    again = LineAgain(reconnect)
    again.lost()
    again.try_on()
    again.end()
    assert again.away and not again.opened()
    until(lambda: again.try_on() or not again.away)
    assert again.opened() and len(tries) == 2


def test_a_device_whose_line_is_silent_goes_on_without_it_and_comes_back(monkeypatch):
    answers = threading.Event()
    with fl.connect("sim:", SYSTEM) as device:
        engine = DeviceEngine(device, SYSTEM)
        really = device.reconnect
        monkeypatch.setattr(device, "reconnect", lambda: answers.wait() and really())
        heard, path = engine._heard, np.zeros((25, 3))

        def gone(_):
            raise Unplugged("the line went away")

        monkeypatch.setattr(engine, "_heard", gone)
        assert engine.advance(path).shape[1] == 0
        monkeypatch.setattr(engine, "_heard", heard)
        assert engine.advance(path).shape[1] == 0  # returns although nobody has answered
        assert (engine.armed, engine.trouble) == ("idle", "the line went away; trying again")
        with pytest.raises(fl.FrictionloopError, match="trying again"):
            engine.arm("closed")
        engine.disarm()
        answers.set()
        until(lambda: engine.advance(path).shape[1] > 0)
        assert engine.trouble == "the line went away; back, plate off"
        engine.arm("closed")
        until(lambda: engine.advance(path).size and engine.state == "closed")
