"""A board on this machine with a host beside it: frames go over in memory, ticks come when the test wants."""

from __future__ import annotations

from functools import cache
from itertools import count
from typing import Any

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.device.codec import Decoder, Message, encode
from frictionloop.device.simulated_boards import Drive, HostBoard, Sample
from frictionloop.firmware.compiled_core import law_of_table
from frictionloop.firmware.image import Image, build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.parameters.presets import RETUNED
from frictionloop.quantities.protocol_schema import parameter_words, schema

TICK_US = 200
MOST = 8.0
"""The most that a limit of a table may be."""
TALK = ("fault", "telemetry")
TELLING = ("identify", "heartbeat", "statistics", "get", "hello")
NONCES = count(1000, 1000)


class Rig:
    """A host, a board and the time, which only `tick` moves on."""

    def __init__(self, words: np.ndarray, **changed: Any) -> None:
        self.words = words.copy()
        for name, values in changed.items():
            self.change(name.replace("__", "."), values)
        self.board = HostBoard(self.words)
        self.decoder, self.sequence, self.now_us, self.ticks = Decoder(), 0, 0, 0
        self.told: list[Message] = []
        self.session = 0
        self.drive = Drive(0, 0.0)

    def change(self, name: str, values: Any) -> None:
        """Change words of the table that a board starts with or that `commit` sends."""
        word = parameter_words()[name]
        self.words[word.first : word.first + word.count] = values

    def listen(self) -> list[Message]:
        """Take what the board has to send; what it says by itself is kept in ``told``."""
        messages = self.decoder.feed(self.board.transmit(self.now_us))
        self.told += [message for message in messages if message.name in TALK]
        return [message for message in messages if message.name not in TALK]

    def ask(self, name: str, **fields: Any) -> Message:
        """Send one frame and return the one answer to it; a first command says hello before."""
        if not self.session and name not in TELLING:
            self.greet()
        self.sequence += 1
        self.board.receive(encode(name, self.sequence, self.session, **fields), self.now_us)
        (answer,) = self.listen()
        return answer

    def greet(self) -> None:
        """Begin a session."""
        self.session = self.ask("hello", major=schema()["protocol"]["major"], nonce=next(NONCES))["session"]

    def reason(self, name: str, **fields: Any) -> str:
        """Send one frame and return "done", or why it is refused."""
        answer = self.ask(name, **fields)
        assert answer["sequence"] == self.sequence
        reasons = {number: reason for reason, number in schema()["refusals"].items()}
        return "done" if answer.name == "done" else reasons[answer["reason"]]

    def tick(self, ticks: int = 1, sample: Sample | None = None, late: bool = False) -> Drive:
        """Run ticks, of a finger that slides at 20 mm/s under 0.5 N where no sample is given; nobody speaks."""
        for _ in range(ticks):
            self.ticks += 1
            self.now_us += TICK_US
            self.drive = self.board.tick(sample or self.slides(), self.now_us, late)
        return self.drive

    def run(self, ticks: int, sample: Sample | None = None) -> Drive:
        """Run ticks with a host that is there."""
        while ticks:
            self.ask("heartbeat")
            self.tick(some := min(ticks, 500), sample)
            ticks -= some
        return self.drive

    def slides(self, force: int = 8000) -> Sample:
        """Return a sample of that finger, with noise of more than a step."""
        return Sample(force + self.ticks % 3, 0, 4 * self.ticks, round(0.5 * 2**16 / 10))

    @property
    def state(self) -> str:
        """Name of the state."""
        return names("states")[self.ask("heartbeat")["state"]]

    @property
    def fault(self) -> str:
        """Name of the fault."""
        return names("faults")[self.ask("heartbeat")["fault"]]

    def mode(self, state: str) -> str:
        """Ask for a state, let a tick take it, and return what was answered."""
        answer = self.reason("mode", state=schema()["states"][state])
        self.tick()
        return answer

    def telemetry(self) -> dict[str, np.ndarray]:
        """Return all samples told so far, by channel in its unit, and their ticks; every frame has all channels."""
        self.listen()
        frames = [message for message in self.told if message.name == "telemetry"]
        channels, rows, ticks = schema()["channel"], [], []
        for frame in frames:
            assert frame["mask"] == 2 ** len(channels) - 1
            rows.append(frame["values"].reshape(-1, len(channels)))
            ticks.append(frame["tick"] + frame["decimation"] * np.arange(len(rows[-1])))
        values = np.concatenate(rows)
        told = {channel["name"]: values[:, k] * channel["scale"] for k, channel in enumerate(channels)}
        return {"tick": np.concatenate(ticks), **told}

    def stream(self, decimation: int = 1) -> None:
        """Ask for all channels."""
        assert self.reason("stream", decimation=decimation, mask=2 ** len(schema()["channel"]) - 1) == "done"


def names(group: str) -> dict[int, str]:
    """Return the names of a group of the schema by number."""
    return {number: name for name, number in schema()[group].items()}


@pytest.fixture(scope="session")
def words() -> np.ndarray:
    """Return the parameter table of the bench with gains that hold, but no limit to the jumps of a force."""
    words = firmware_words(fl.bench().evolve(RETUNED))
    words[parameter_words()["safety.force_jump_n"].first] = MOST
    return words


@pytest.fixture
def rig(words: np.ndarray) -> Rig:
    """Return a board of that table, idle, and its host."""
    return Rig(words)


@pytest.fixture
def make_rig(words: np.ndarray) -> Any:
    """Return what makes a board of that table with some words changed: ``make_rig(safety__stuck_ticks=9)``."""
    return lambda **changed: Rig(words, **changed)


LAWS: dict[str, dict[str, Any]] = {
    "pi": RETUNED,
    "lookup": {"controller.kind": "lookup"},
    "notch_pi": {
        "controller.kind": "notch_pi", "controller.kp": 0.05, "controller.ki": 100.0, "controller.feedforward": True,
        "controller.overdrive": True,
    },
    "filtered_pi": {
        "controller.kind": "filtered_pi", "controller.kp": 0.05, "controller.ki": 100.0, "controller.feedforward": True,
        "controller.overdrive": True, "controller.sections": [(0.5, 0.1, 0.1, -0.4, 0.1)] * 6,
    },
    "limit_observer": {"controller.kind": "limit_observer"},
}  # fmt: skip


@pytest.fixture(scope="session")
def law_words() -> dict[str, np.ndarray]:
    """Return a parameter table of the bench with each law; the notch PI is the default law, with all it can have.

    No jump and no contradiction is a fault: the loop stays on whatever it is fed.
    """
    tables = {name: firmware_words(fl.bench().evolve(overrides)) for name, overrides in LAWS.items()}
    for words in tables.values():
        for name in ("force_jump_n", "position_jump_m", "load_jump_n", "contrary_n"):
            words[parameter_words()[f"safety.{name}"].first] = MOST
    return tables


@pytest.fixture(scope="session")
def images(law_words: dict[str, np.ndarray], tmp_path_factory: pytest.TempPathFactory) -> Any:
    """Return what builds an image of a law, once: ``images("pi")``, ``images("pi", board="mps2", optimise="0")``."""
    pytest.importorskip("ziglang", reason="the images are built by zig: install frictionloop[image]")

    @cache
    def built(law: str, board: str = "teensy41", optimise: str | None = None, axes: int = 1) -> Image:
        folder = tmp_path_factory.mktemp(f"{board}-{law}-{optimise or 'default'}-{axes}")
        table = law_words[law].copy()
        table[parameter_words()["force.axes"].first] = axes
        own = board_law(law_of_table(table))
        return build(board, table.tolist(), own, folder, rate_hz=5000, optimise=optimise)

    return built
