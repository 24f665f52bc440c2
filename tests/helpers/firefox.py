"""A Firefox of the distribution by WebDriver BiDi, which Playwright drives only in a build of its own."""

from __future__ import annotations

import itertools
import json
import subprocess
from contextlib import contextmanager

from websockets.sync.client import connect


class Tab:
    """A tab that opens addresses and evaluates expressions."""

    def __init__(self, socket):
        self._socket, self._numbers = socket, itertools.count(1)
        self._call("session.new", capabilities={})
        self._context = self._call("browsingContext.getTree")["contexts"][0]["context"]

    def _call(self, method, **params):
        number = next(self._numbers)
        self._socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while (told := json.loads(self._socket.recv(60.0))).get("id") != number:
            pass
        assert told["type"] == "success", told
        return told["result"]

    def goto(self, url):
        self._call("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def evaluate(self, expression):
        target, text = {"context": self._context}, f"JSON.stringify({expression})"
        told = self._call("script.evaluate", expression=text, target=target, awaitPromise=True)
        return json.loads(told["result"].get("value", "null"))


@contextmanager
def firefox(program, profile):
    """Yield a tab of a Firefox with a profile of its own."""
    asked = [program, "--headless", "--no-remote", "--profile", str(profile), "--remote-debugging-port", "0"]
    with subprocess.Popen(asked, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True) as running:
        try:
            address = next(line.split()[-1] for line in running.stderr if "WebDriver BiDi listening" in line)
            with connect(f"{address}/session", max_size=None) as socket:
                yield Tab(socket)
        finally:
            running.terminate()
