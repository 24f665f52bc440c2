"""One source: simulator, C of this machine and an emulated Cortex-M7 agree in every bit of commands and states.

What a law does that is no force ends in a fault, and nothing on the plate.
"""

from __future__ import annotations

import math
import zlib
from typing import Any, Literal, NamedTuple

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.law import CLOSING, switched_clamp
from frictionloop.control.laws import LAWS, law_of
from frictionloop.device.codec import Decoder, encode
from frictionloop.device.simulated_boards import HostBoard, Sample
from frictionloop.firmware.compiled_core import host_library
from frictionloop.firmware.image import build
from frictionloop.firmware.image_law import board_law
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.loop.kernel.lowering import lower
from frictionloop.loop.kernel.slab import law_rows
from frictionloop.loop.registered_blocks import forget
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.protocol_schema import schema
from frictionloop.sensing.finger_tracking import TouchState, board_touch, touch_step
from frictionloop.sensing.measurement import Measurement
from tests.helpers.host_frames import SESSION, heartbeat, hello
from tests.helpers.own_laws import register_both

TICKS, OPEN_S = 50_000, 0.2
MORE: dict[str, dict[str, Any]] = {
    "pi": fl.RETUNED,
    "notch_pi": {"controller.feedforward": True, "controller.overdrive": True},
    "filtered_pi": {
        "controller.kp": 0.05, "controller.ki": 100.0, "controller.feedforward": True,
        "controller.sections": [(0.5, 0.1, 0.1, -0.4, 0.1)] * 6,
    },
}  # fmt: skip
KINDS = [*LAWS, "dead_band_pi"]


@pytest.fixture(autouse=True)
def own_laws():
    register_both()
    yield
    forget()


def bench(kind: str, **more: Any) -> fl.System:
    return fl.bench().evolve({"controller.kind": kind} | MORE.get(kind, {}) | more)


class Ran(NamedTuple):
    """What each tick of `simulate` read, was asked, commanded and kept."""

    measured: np.ndarray
    setpoint: np.ndarray
    commands: np.ndarray
    """u, saturated, amplitude command."""
    states: np.ndarray


def simulated(system: fl.System, ticks: int) -> Ran:
    """Return it from the rows of the simulator's own kernel, period by period."""
    tile, (state, _, _) = lower([system], [3]), law_rows(law_of(system.controller))
    rows = [tile.slab.view(name) for name in ("measurement", "setpoint", "u", "saturated", "command")]
    kept = []
    for k in range(ticks):
        tile.advance(k, k + 1, tile.setpoint(k, k + 1), tile.disturbance(k, k + 1), k)
        kept.append(np.concatenate([each[:, 0] for each in [*rows, tile.slab.view(state)]]))
    found = np.array(kept)
    return Ran(found[:, :5].copy(), found[:, 5].copy(), found[:, 6:9].copy(), found[:, 9:].copy())


def differing(a: np.ndarray, b: np.ndarray) -> int:
    return int(np.count_nonzero(np.ascontiguousarray(a).view(np.int64) != np.ascontiguousarray(b).view(np.int64)))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("table_size", [0, pytest.param(257, marks=pytest.mark.slow)])
def test_the_core_has_the_bits_of_simulate(kind: str, table_size: int):
    """Opened, closing and closed, from the same readings, and its amplitudes too."""
    system = bench(kind, **{"controller.open_until_s": OPEN_S, "controller.model.table_size": table_size})
    ran, law = simulated(system, TICKS), law_of(system.controller)
    ffi, library = host_library(law, 5000)
    states, out = np.zeros((TICKS, flat_tuples.size(law.state))), np.zeros((TICKS, 3))
    pointers = [ffi.from_buffer("double[]", each) for each in (ran.measured, ran.setpoint, states, out)]
    library.fl_host_run(ffi.from_buffer("double[]", firmware_words(system)), TICKS, round(5000 * OPEN_S), *pointers)
    assert np.ptp(ran.commands[:, 0]) > 0.02 and np.ptp(ran.measured[:, 4]) == 1.0
    assert differing(out[:, [0, 2]], ran.commands[:, [0, 2]]) == differing(states, ran.states) == 0
    assert differing(out[1000:, 1], ran.commands[1000:, 1]) == 0


@pytest.mark.parametrize("kind", [*KINDS[:1], *(pytest.param(kind, marks=pytest.mark.slow) for kind in KINDS[1:])])
def test_an_emulated_cortex_m7_has_the_bits_of_the_step(kind: str, tmp_path):
    pytest.importorskip("unicorn", reason="install frictionloop[emulator]")
    from tests.helpers.emulated_core import EmulatedLaw

    system = bench(kind)
    ran, law = simulated(system, TICKS), law_of(system.controller)
    image = build("teensy41", firmware_words(system).tolist(), board_law(law), tmp_path, rate_hz=5000)
    core, model = EmulatedLaw(image.elf), system.controller.model
    state, differ = flat_tuples.flat(law.start_for(system.controller)), 0
    for measured, setpoint_n, (u, saturated, _), after in zip(*ran, strict=True):
        found = core.step(state, measured, setpoint_n, model.floor_n, model.nominal_n)
        differ += found != np.array([*after, u, saturated]).tobytes()
        state = after
    assert differ == 0


class Beside:
    """A board in memory, and its host."""

    def __init__(self, system: fl.System) -> None:
        self.rate_hz = system.controller.rate_hz
        self.board = HostBoard(firmware_words(system), law_of(system.controller), self.rate_hz)
        self.decoder, self.said, self.k, self.tick_us = Decoder(), [], 0, round(1e6 / self.rate_hz)
        self.tell(hello())

    def tell(self, frame: bytes) -> None:
        self.board.receive(frame, self.k * self.tick_us)
        self.said += self.decoder.feed(self.board.transmit(self.k * self.tick_us))

    def ask(self, name: str, **fields: Any) -> str:
        self.tell(encode(name, self.k + 1, SESSION, **fields))
        return self.said[-1].name

    def tick(self, sample: Sample) -> np.ndarray:
        if self.k % (self.rate_hz // 10) == 0:
            self.tell(heartbeat((self.k + 1) % 2**16))
        self.k += 1
        self.drive = self.board.tick(sample, self.k * self.tick_us)
        return self.board.last()

    @property
    def faults(self) -> list[tuple[str, float]]:
        self.said += self.decoder.feed(self.board.transmit(self.k * self.tick_us))
        names = {number: name for name, number in schema()["faults"].items()}
        return [(names[each["fault"]], each["value"]) for each in self.said if each.name == "fault"]


def strokes(rate_hz: float, ticks: int, seed: int = 0):
    """Yield counts of a finger that strokes over 40 mm at 20 mm/s, is lifted now and then, and rubs with noise."""
    rng = np.random.default_rng(seed)
    for k in range(ticks):
        t = k / rate_hz
        place_mm, lifted = abs(20.0 * t % 40.0 - 20.0), t % 3.0 > 2.8
        pressed = np.clip(min(t % 3.0, 2.8 - t % 3.0) / 0.01, 0.0, 1.0)
        force = pressed * (7000 + 900 * math.sin(9.0 * t))
        noise = rng.integers(-80, 81, 3)
        yield Sample(
            int(force + noise[0]), 0, round(1e3 * place_mm + noise[1] % 3), int((0 if lifted else 3277) + noise[2] // 8)
        )


@pytest.mark.parametrize("rate_hz", [1000.0, 5000.0, 20_000.0])
def test_counts_become_readings_and_readings_commands_as_in_the_simulators_steps(rate_hz: float):
    """Touch, clamp and law of the whole tick, at any rate of an image: the steps in Python on what the board read."""
    system = bench("dead_band_pi", **{"controller.rate_hz": rate_hz})
    board, law, controller = Beside(system), law_of(system.controller), system.controller
    assert board.ask("mode", state=schema()["states"]["closed"]) == "done"
    felt, model, dt = board_touch(system), controller.model, 1.0 / rate_hz
    touch, gains = TouchState(0.0, 0.0, 0.0, felt.developed_m, 0.0, 1.0, 0.0), law.gains_for(controller)
    state, since, differ, count = law.start_for(controller), -1, 0, int(4 * rate_hz)
    for k, sample in enumerate(strokes(rate_hz, count)):
        found = board.tick(sample)
        position_m = system.board.position_m_per_count * sample.position
        load_n = system.board.load_n_per_count * (sample.load - system.board.load_zero_counts)
        touch = touch._replace(position=position_m) if k == 0 else touch
        touch, seen = touch_step(touch, position_m, load_n, 0.0, 0.0, felt)
        since = min(since + 1, CLOSING)
        low, high = switched_clamp(0.6, model.floor_n, model.nominal_n, since)
        gains = gains._replace(low=low, high=high)
        state = law.begin(state, low, 0.6, gains) if since == 0 else state
        state, command = law.step(state, Measurement(found[0], *seen), 0.6, gains, dt)
        differ += [*found[1:5], found[6], *found[9:]] != [*seen, command.u, *flat_tuples.flat(state)]
    assert differ == 0 and board.faults == []


class BrokenController(fl.Timing):
    kind: Literal["broken"] = "broken"
    given: float = 0.5


class BrokenState(NamedTuple):
    kept: float


class BrokenGains(NamedTuple):
    given: float
    low: float
    high: float


def slid(step: Any, state: str = "closed", **given: float) -> tuple[Beside, list[float], list[list[tuple[str, float]]]]:
    """Return a board with a law after strokes, the amplitude at each tick, and the faults told until then."""
    fl.register(fl.Law("broken", step, BrokenState, BrokenGains), BrokenController)
    board = Beside(bench("broken", **{f"controller.{name}": value for name, value in given.items()}))
    assert board.ask("mode", state=schema()["states"][state]) == "done"
    amplitudes, told = [], []
    for sample in strokes(5000.0, 3000):
        board.tick(sample)
        amplitudes.append(board.drive.amplitude_um)
        told.append(board.faults)
    return board, amplitudes, told


@fl.step
def commands(state, measured, setpoint_n, gains, dt):
    """A force far from the clamp once the finger slides; of 1e30 it makes infinity."""
    slides = measured.valid > 0.5
    return state, fl.ForceCommand(gains.given * gains.given * 1e250 * 1e-250 if slides else gains.low, 0.0)


@pytest.mark.parametrize(
    ("given", "told"),
    [(1.5, 2.25), (1e-160, 1e-320), (1e30, math.inf), (0.0, 0.0)],
    ids=["beyond", "denormal", "infinite", "none"],
)
def test_a_command_that_is_no_force_is_told_and_the_plate_goes_to_rest(given: float, told: float):
    board, amplitudes, faults = slid(commands, given=given)
    assert board.faults == [("law_wrong", pytest.approx(told, rel=1e-3))]
    since = next(k for k, each in enumerate(faults) if each)
    down = amplitudes[since:]
    assert 0.0 < amplitudes[since - 1] <= fl.bench().plate.max_amplitude_um
    assert down == sorted(down, reverse=True) and down[60] == down[-1] == 0.0


def test_a_law_that_is_wrong_leaves_the_open_loop_alone():
    """Until the loop closes nothing of it reaches the plate."""
    board, amplitudes, _ = slid(commands, "open", given=1e30)
    model = fl.bench().controller.model
    asked_um = math.sqrt(math.log(model.nominal_n / 0.6) / model.susceptibility_per_um2)
    assert board.faults == [] and amplitudes[-1] == pytest.approx(asked_um)
    assert board.ask("mode", state=schema()["states"]["closed"]) == "done"
    for sample in [*strokes(5000.0, 5500)][3000:]:
        board.tick(sample)
    assert [name for name, _ in board.faults] == ["law_wrong"]


@fl.step
def overflows(state, measured, setpoint_n, gains, dt):
    kept = state.kept * 1e200 + 1.0 if measured.valid > 0.5 else 0.0
    return BrokenState(kept), fl.ForceCommand(min(max(setpoint_n, gains.low), gains.high), 0.0)


@fl.step
def fades(state, measured, setpoint_n, gains, dt):
    kept = max(state.kept * 0.5, 5e-324) if state.kept > 0.0 else 1.0
    return BrokenState(kept), fl.ForceCommand(min(max(setpoint_n + kept, gains.low), gains.high), 0.0)


def test_a_state_that_is_no_number_is_a_fault_and_one_that_fades_into_denormals_is_none():
    """Whatever its command is: NaN stays for ever, and a filter at rest ends in denormals, as in the simulator."""
    board, amplitudes, _ = slid(overflows)
    assert [name for name, _ in board.faults] == ["law_wrong"] and amplitudes[-1] == 0.0
    forget()
    board, amplitudes, _ = slid(fades)
    assert board.faults == [] and amplitudes[-1] > 0.5
    assert 0.0 < board.board.last()[-1] < 2.3e-308


def test_a_cable_pulled_while_gains_are_written_leaves_all_of_them_or_none():
    """Cut after any byte of a new table and its commit: the device has the old gains, or the new ones."""
    old, new = (firmware_words(bench("pi", **gains)) for gains in ({}, {"controller.kp": 0.03, "controller.ki": 90.0}))
    frames = [encode("set", 2 + k, SESSION, first=k, values=new[k : k + 32]) for k in range(0, len(new), 32)]
    frames.append(encode("commit", 500, SESSION, crc=zlib.crc32(new.astype("<f8").tobytes())))
    sent, seen = b"".join(frames), []
    for cut in [*range(0, len(sent), 97), len(sent) - 1, len(sent)]:
        board = Beside(bench("pi"))
        board.tell(sent[:cut])
        board.tick(Sample(7000, 0, 0, 3277))
        board.tell(b"\0" + encode("get", 600, 0, first=1, count=2))
        (told,) = [each["values"].tolist() for each in board.said if each.name == "words"]
        seen.append(told)
    assert seen == [old[1:3].tolist()] * (len(seen) - 1) + [[0.03, 90.0]]


def test_the_hash_of_a_law_is_of_what_it_does():
    """Not of what is said of it: a board goes on with the tables of a version whose docstrings are others."""

    @fl.step
    def doubled(state, measured, setpoint_n, gains, dt):
        """Twice the wish."""
        return state, fl.ForceCommand(min(max(2.0 * setpoint_n, gains.low), gains.high), 0.0)

    @fl.step
    def halved(state, measured, setpoint_n, gains, dt):
        return state, fl.ForceCommand(min(max(0.5 * setpoint_n, gains.low), gains.high), 0.0)

    laws = [board_law(fl.Law("own", each, BrokenState, BrokenGains)) for each in (doubled, halved)]
    doubled.py_func.__doc__ = "Two times it."
    again = board_law.__wrapped__(fl.Law("own", doubled, BrokenState, BrokenGains))
    assert again.text != laws[0].text and again.hash == laws[0].hash != laws[1].hash
