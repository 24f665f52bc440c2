"""What travels over the socket comes back as it was, and nothing else is taken for it."""

from __future__ import annotations

import asyncio
import socket
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from studio_pages import until

import frictionloop as fl
from frictionloop.device.errors import DeviceError, Unplugged
from frictionloop.live.device_engine import DeviceEngine, LineAgain
from frictionloop.quantities import FrictionloopError
from frictionloop.studio.connections import listening, prompt_loop
from frictionloop.studio.frames import Frame, events_in, pack, pack_map, unpack


@given(st.integers(1, 12), st.integers(0, 50), st.integers(0, 2**40), st.floats(0, 1e6))
def test_a_frame_comes_back_as_it_was(channels, rows, number, time_s):
    values = np.arange(channels * rows, dtype=np.float32).reshape(channels, rows)
    back = unpack(pack(Frame(number, time_s, 12.5, 1e-3, values)))
    assert (back.number, back.time_s, back.reached_ms) == (number % 2**32, time_s, 12.5)
    np.testing.assert_array_equal(back.rows, values)


@given(st.binary(max_size=200))
def test_other_bytes_are_no_frame(data):
    if data[:4] != b"\x01\x00\x00\x00":
        with pytest.raises(FrictionloopError):
            unpack(data)


def test_a_map_says_its_edges_and_spans_its_range():
    data = pack_map(np.array([[0.2, 0.4], [0.6, 0.3]]), -1.0, 1.0, -2.0, 2.0)
    assert np.frombuffer(data, "<u4", 3).tolist() == [2, 2, 2]
    np.testing.assert_allclose(np.frombuffer(data, "<f4", 6, offset=12), [-1, 1, -2, 2, 0.2, 0.6], rtol=1e-6)
    assert list(data[36:]) == [0, 128, 255, 64]


def test_a_pointer_without_pressure_has_no_load():
    assert np.isnan(events_in(np.array([[1.0, 2.0, 3.0, np.nan]]).tobytes())[0, 3])


# The socket of the server: it sends at once, and says why it cannot listen.


def test_what_is_written_to_a_page_is_sent_at_once():
    async def accepted():
        told = asyncio.get_running_loop().create_future()

        async def meet(reader, writer):
            told.set_result(writer.get_extra_info("socket").getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
            writer.close()

        async with await asyncio.start_server(meet, sock=listening("127.0.0.1", 0)) as server:
            _, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
            at_once = await told
            writer.close()
            await writer.wait_closed()
        return at_once

    with ThreadPoolExecutor(1) as pool:  # a browser of other tests has a loop in this thread
        assert pool.submit(asyncio.run, accepted()).result() != 0


def test_a_port_that_is_taken_is_named():
    with listening("127.0.0.1", 0) as first:
        first.listen()
        port = first.getsockname()[1]
        with pytest.raises(FrictionloopError, match=f"port {port}: cannot listen there"):
            listening("127.0.0.1", port)


def test_a_block_is_woken_for_sooner_than_a_millisecond_late():
    async def late():
        begun = time.perf_counter()
        await asyncio.sleep(2e-4)
        return time.perf_counter() - begun

    async def least():
        return min([await late() for _ in range(50)])

    def run():
        with asyncio.Runner(loop_factory=prompt_loop) as runner:
            return runner.run(least())

    with ThreadPoolExecutor(1) as pool:
        assert 2e-4 <= pool.submit(run).result() < 8e-4  # epoll takes its wait in whole milliseconds, rounded up


# A line that went away is tried again on a thread of its own.


SYSTEM = fl.bench().evolve({"setpoint": {"kind": "effect"}})


def test_a_try_that_takes_long_holds_nobody_up_and_is_told_once():
    answers = threading.Event()
    again = LineAgain(answers.wait)
    again.try_on()
    again.end()
    assert not again.opened()  # nothing was lost
    again.away = True
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
    again.away = True
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
