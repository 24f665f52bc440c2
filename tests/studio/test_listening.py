"""The socket of the server: it sends at once, and says why it cannot listen."""

from __future__ import annotations

import asyncio
import socket
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from frictionloop.quantities import FrictionloopError
from frictionloop.studio.connections import listening, prompt_loop


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
