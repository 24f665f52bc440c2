"""The firmware at a simulated bench behind a wire of this machine: a serial port or a TCP connection."""

from __future__ import annotations

import os
import select
import socket
import threading
import time
from collections import deque
from contextlib import contextmanager, suppress

from frictionloop.device.simulated_boards import BenchPipe, Simulated
from frictionloop.live.pointer_motion import Ghost
from frictionloop.loop.stepper import Movement

BLOCK_S = 0.005


class Wired:
    """A board that answers on a descriptor in the time of this machine, under a finger that strokes by itself."""

    def __init__(self, pipe, descriptor):
        self.pipe, self.descriptor, self.on = pipe, descriptor, True
        self.pipe.moves, self.ghost = deque(), Ghost(40.0, 40.0)  # within what the position sensor of the bench reads
        self.thread = threading.Thread(target=self.serve, daemon=True)
        self.thread.start()

    def serve(self):
        begun = time.monotonic() - self.pipe.clock()
        with suppress(OSError):  # nobody is at the other end
            while self.on:
                ahead_s = self.pipe.clock() - (time.monotonic() - begun)
                if ahead_s < -0.1:  # a loaded machine: the board's time is then slower than ours
                    begun -= ahead_s
                if select.select([self.descriptor], [], [], max(ahead_s, 0.0))[0]:
                    self.pipe.write(os.read(self.descriptor, 4096))
                if ahead_s < 0.0:
                    if len(self.pipe.moves) < 25:
                        self.pipe.moves.extend(self.stroke())
                    self.say(self.pipe.read(BLOCK_S))

    def stroke(self):
        for _ in range(25):
            x_m = 1e-3 * self.ghost.move(BLOCK_S / 25)
            yield Movement(x_m, 1e-3 * self.ghost._v_mm_s, 0.5)

    def say(self, data):
        while data:
            data = data[os.write(self.descriptor, data) :]

    def stop(self):
        self.on = False
        self.thread.join(5)


@contextmanager
def wired(way, system):
    """Yield the address of a board, and what pulls its plug: ``serial`` by a pseudo-terminal, ``tcp`` by a socket.

    Over TCP it can be plugged in again, by connecting anew: the board has gone on meanwhile.
    """
    pipe = BenchPipe(Simulated(system), system).opened()
    if way == "serial":
        ours, theirs = os.openpty()
        board = Wired(pipe, ours)
        yield f"serial://{os.ttyname(theirs)}", lambda: None
        board.stop()
        for each in (ours, theirs):
            os.close(each)
        return
    listening, made = socket.create_server(("127.0.0.1", 0)), []

    def accept():
        while True:
            try:
                made.append(listening.accept()[0])
            except OSError:
                return
            made.append(Wired(pipe, made[-1].fileno()))

    def pull():
        made[-1].stop()
        made[-2].close()

    threading.Thread(target=accept, daemon=True).start()
    yield f"tcp://127.0.0.1:{listening.getsockname()[1]}", pull
    pull()
    listening.shutdown(socket.SHUT_RDWR)
    listening.close()
