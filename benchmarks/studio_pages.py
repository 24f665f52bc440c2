"""A studio in a process of its own, a page that shows it, viewers, and a pointer: for `benchmarks/studio.py`."""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress

import numpy as np
from playwright.sync_api import sync_playwright

FIRST_FRAME = """
const Socket = window.WebSocket;
window.WebSocket = class extends Socket {
  constructor(...all) {
    super(...all);
    this.addEventListener("message", ({ data }) => {
      if (window.firstFrame || typeof data === "string" || new DataView(data).getUint32(0, true) !== 1) return;
      requestAnimationFrame(() => { window.firstFrame ??= performance.now(); });
    });
  }
};"""


@contextmanager
def served():
    """Yield address, process and start time of a studio in a process of its own."""
    begun = time.perf_counter()
    command = [sys.executable, "-u", "-m", "frictionloop", "studio", "--port", "0"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        address = next(re.search(r"http://\S+", line)[0] for line in process.stdout if "http://" in line)
        while True:
            try:
                urllib.request.urlopen(address)
                break
            except OSError:
                time.sleep(0.01)
        yield address, process, time.perf_counter() - begun
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(10)


@contextmanager
def opened(address):
    """Yield a page that shows a studio."""
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(FIRST_FRAME)
        page.goto(address)
        while not page.evaluate("window.firstFrame ?? 0"):
            time.sleep(0.01)
        yield page
        browser.close()


@contextmanager
def watched(address, viewers):
    """Let so many viewers take frames and read nothing of them: elsewhere they would not be on our processor."""
    host, stop, sockets = address.split("/")[2], threading.Event(), []
    ask = (
        f"GET /live HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    for _ in range(viewers):
        sockets.append(socket.create_connection(host.split(":")))
        sockets[-1].sendall(ask.encode())

    def take():
        taken = 0
        while not stop.wait(0.05):
            taken += sum(len(each.recv(1 << 20)) for each in sockets)
        if taken < 1000 * viewers:
            raise RuntimeError(f"{viewers} viewers got {taken} bytes")

    with ThreadPoolExecutor(1) as pool:
        taking = pool.submit(take)
        try:
            yield
        finally:
            stop.set()
        taking.result()
    for each in sockets:
        each.close()


def stroke(page, seconds):
    """Move the pointer at 60 Hz, and return the rates that the page told meanwhile."""
    box, told = page.locator("#plate").bounding_box(), []
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    begun = time.perf_counter()
    for step in range(60 * seconds):
        page.mouse.move(x + 200 * np.sin(step / 25), y)
        time.sleep(max(0.0, begun + (step + 1) / 60 - time.perf_counter()))
        if step % 60 == 59:
            told.append(page.text_content("#rates"))
    page.mouse.up()
    return told


def cpu_s(pid):
    """Processor time of a process so far, s."""
    with open(f"/proc/{pid}/stat") as told:
        user, system = told.read().rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def others_s():
    """Processor time so far of all that is not this process and what it has started, s."""
    found = {}
    for name in os.listdir("/proc"):
        with suppress(OSError, ValueError), open(f"/proc/{int(name)}/stat") as told:
            fields = told.read().rpartition(")")[2].split()
            found[int(name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    ours, more = set(), {os.getpid()}
    while more:
        ours |= more
        more = {pid for pid, (parent, _) in found.items() if parent in more}
    with open("/proc/stat") as told:
        user, nice, system, _, _, irq, soft = (int(each) for each in told.readline().split()[1:8])
    own = sum(found[pid][1] for pid in ours if pid in found)
    return (user + nice + system + irq + soft - own) / os.sysconf("SC_CLK_TCK")


def resident_mb(pid):
    """Memory of a process, MB."""
    with open(f"/proc/{pid}/statm") as told:
        return int(told.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
