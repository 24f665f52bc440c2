"""A device behind the page: armed and stopped, its faults in words, at rest when the driving page is gone."""

from __future__ import annotations

import contextlib
from pathlib import Path

import numpy as np
import pytest
from studio_pages import opened, seen, until

import frictionloop as fl
from frictionloop.cli.flags import LAW
from frictionloop.device.codec import Message
from frictionloop.device.device import connect
from frictionloop.device.errors import fault_code
from frictionloop.device.recording import ALL
from frictionloop.device.recording import CHANNELS as TOLD
from frictionloop.device.simulated_boards import Simulated
from frictionloop.findings import CATALOGUE
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.live.device_engine import DeviceEngine
from frictionloop.live.device_session import DeviceSession
from frictionloop.live.live_engines import CHANNELS
from frictionloop.live.live_session import recorded
from frictionloop.live.telemetry_channels import Rows
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities.protocol_schema import schema
from frictionloop.studio.commands import obey
from frictionloop.studio.connections import Guest
from frictionloop.studio.live_numbers import numbers_of
from frictionloop.studio.room import Room

SYSTEM = fl.bench().evolve(LAW | {"setpoint": {"kind": "effect"}})
ROW = {name: row for row, name in enumerate(CHANNELS)}
PAGE = Path(__file__).parents[2] / "docs" / "firmware-states.md"


class Clock:
    """Seconds that pass when told to."""

    def __init__(self):
        self.now_s = 0.0

    def __call__(self):
        return self.now_s


@pytest.fixture
def room():
    clock = Clock()
    with connect("sim:", SYSTEM) as device:
        yield Room(DeviceSession(DeviceEngine(device, SYSTEM)), clock)


def pass_s(room, seconds, guest=None):
    """Let time pass, with a driving page that says it is there or one that is silent."""
    for _ in range(round(seconds / 0.02)):
        room.clock.now_s += 0.02
        if guest is not None:
            obey(room, guest, {"do": "here"})
            room.heard(guest)
        room.step()


def joined(room):
    guest = Guest(may_drive=True)
    room.join(guest)
    return guest


def amplitude(room):
    """Return the last amplitude of the plate, um: of the simulated bench itself, not of what the board tells."""
    return room.session.engine._bench._bench.amplitude_um


def test_it_is_idle_until_armed_and_then_follows_the_effect(room):
    guest = joined(room)
    pass_s(room, 0.2, guest)
    assert room.status()["device"]["state"] == "idle"
    assert amplitude(room) == 0.0
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 1.5, guest)
    told = room.status()["device"]
    assert (told["state"], told["armed"], told["fault"], told["lost"]) == ("closed", "closed", "", 0)
    assert told["ceiling_um"] == pytest.approx(2.5, rel=1e-3)
    numbers = numbers_of(room.session.last(1.0), 5000.0, 0.02)
    assert numbers["closed_error_n"] < 0.1
    assert "open_error_n" not in numbers
    assert amplitude(room) > 0.1


def test_open_and_closed_are_told_in_channels_of_their_own(room):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "open"})
    pass_s(room, 0.5, guest)
    rows = room.session.last(0.2)
    assert np.isfinite(rows[ROW["open_n"]]).all()
    assert np.isnan(rows[ROW["closed_n"]]).all()
    run = recorded(room.session)
    assert run.attrs["source"] == "simulated"
    assert not run["saturated"].values.any()


def test_the_space_bar_of_any_page_brings_the_plate_to_rest(room):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.5, guest)
    watching = Guest(may_drive=False)
    room.join(watching)
    obey(room, watching, {"do": "stop"})
    pass_s(room, 0.2, guest)
    assert room.status()["device"]["state"] == "idle"
    assert amplitude(room) < 1e-3
    with pytest.raises(FrictionloopError, match="another page drives"):
        obey(room, watching, {"do": "arm", "state": "closed"})


@pytest.mark.parametrize("how", ["leaves", "falls silent", "is taken over"])
def test_the_plate_is_at_rest_300_ms_after_the_driving_page_has_gone(room, how):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.5, guest)
    assert amplitude(room) > 0.1
    if how == "leaves":
        room.leave(guest)
    elif how == "is taken over":
        obey(room, joined(room), {"do": "take"})
    pass_s(room, 0.3)
    assert room.session.engine.armed == "idle"
    assert amplitude(room) < 1e-3
    assert ("page silent" in room.status()["device"]["trouble"]) == (how == "falls silent")


def test_a_fault_is_told_in_words_and_cleared(room):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.3, guest)
    bench = room.session.engine._bench
    sample = bench._converters.sample
    bench._converters.sample = lambda measured: sample(measured)._replace(load=32767)
    pass_s(room, 0.3, guest)
    told = room.status()["device"]
    assert told["fault"].startswith("sensor_saturated: ") and told["fault"].endswith(": 32767 counts")
    assert told["armed"] == "idle"
    with pytest.raises(FrictionloopError, match="still at fault"):
        obey(room, guest, {"do": "clear"})
    bench._converters.sample = sample
    pass_s(room, 0.3, guest)
    obey(room, guest, {"do": "clear"})
    pass_s(room, 0.2, guest)
    assert (room.status()["device"]["state"], room.status()["device"]["fault"]) == ("idle", "")


def test_a_page_changes_controller_and_effect_and_not_the_bench(room):
    guest = joined(room)
    engine = room.session.engine
    engine.prepare(SYSTEM.evolve({"setpoint.effect": fl.rendering.LIBRARY["bump"]}))  # the server does so beside
    obey(room, guest, {"do": "set", "values": {"controller.kp": 0.05}})
    obey(room, guest, {"do": "effect", "name": "bump"})
    pass_s(room, 0.3, guest)
    assert engine._device.controller.kp == 0.05
    assert engine.system.setpoint.effect == fl.rendering.LIBRARY["bump"]
    assert engine._set_up._plays is engine._set_up._played[(engine.system.setpoint, 255.0)].tables.words
    with pytest.raises(FrictionloopError, match="friction: fixed; accepted: controller, setpoint"):
        obey(room, guest, {"do": "set", "values": {"friction.nominal_n": 1.2}})
    assert room.session.engine.system.friction == SYSTEM.friction


def test_what_the_board_refuses_is_told_and_what_was_in_force_stays(room, monkeypatch):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.3, guest)
    link = room.session.engine._link
    ask = link.ask
    monkeypatch.setattr(
        link, "ask", lambda name, **fields: ask(name, **fields | ({"crc": 1} if name == "commit" else {}))
    )
    obey(room, guest, {"do": "set", "values": {"controller.kp": 0.05}})
    assert room.session.engine.system.controller.kp == 0.05
    guest._waiting.clear()
    pass_s(room, 0.3, guest)
    told = [each for each in guest._waiting if isinstance(each, dict)]
    assert any(each["type"] == "refused" and each["why"].startswith("commit") for each in told)
    assert any(each["type"] == "system" for each in told)
    assert room.session.engine.system == SYSTEM
    assert room.status()["device"]["state"] == "closed"


def test_a_bench_does_not_run_ahead_while_its_board_is_written_to(room):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.5, guest)
    before, begun_s = room.session.ticks, room.clock.now_s
    for kp in np.linspace(0.05, 0.5, 10):
        obey(room, guest, {"do": "set", "values": {"controller.kp": float(kp)}})
        pass_s(room, 0.1, guest)
    assert room.session.ticks - before <= 5000 * (room.clock.now_s - begun_s) + 50
    assert (room.status()["device"]["fault"], room.status()["device"]["state"]) == ("", "closed")


def test_a_board_that_began_anew_is_set_up_again(room):
    guest = joined(room)
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 3.0, guest)
    engine = room.session.engine
    obey(room, guest, {"do": "set", "values": {"controller.kp": 0.05}})
    pass_s(room, 0.3, guest)
    engine._bench.board = Simulated(SYSTEM)
    pass_s(room, 0.6, guest)
    assert (engine.armed, engine.state) == ("idle", "idle")
    assert "began anew" in engine.trouble
    assert engine._device.parameters.hold(firmware_words(engine.system))
    obey(room, guest, {"do": "arm", "state": "closed"})
    pass_s(room, 0.5, guest)
    assert engine.state == "closed"
    assert np.nanstd(room.session.last(0.2)[ROW["asked_n"]]) > 0.02  # the grating plays


def frame(tick, rows, every=1):
    values = np.tile(np.arange(len(TOLD), dtype=np.int16), rows)
    told = {"tick": tick, "decimation": every, "mask": ALL, "dropped": 0, "values": values}
    return Message("telemetry", 0, 0, told)


class Silent:
    """A pipe that knows no force on the finger."""

    def felt(self, first_tick, count, every):
        return None


def test_lost_samples_are_missing_and_counted():
    rows = Rows(2**32 - 6, 5000)
    for tick, count in ((2**32 - 5, 3), (0, 4), (0, 4), (2, 3)):  # a gap of 2 ticks, a repeat, an overlap
        rows.take(frame(tick, count))
    told = rows.taken(Silent())
    assert rows.lost == 2
    assert told.shape == (len(CHANNELS), 10)
    assert np.isnan(told[ROW["measured_n"]]).tolist() == [False] * 3 + [True] * 2 + [False] * 5
    assert not rows.began_anew(5)
    assert rows.began_anew(100_000)


def test_a_sample_in_two_stands_for_the_tick_before_it_as_well():
    rows = Rows(9, 20_000)
    for tick, count in ((10, 3), (18, 2), (18, 2)):  # tick 9 was told of before; 16 is lost, with 15
        rows.take(frame(tick, count, every=2))
    told = rows.taken(Silent())
    assert (rows.lost, rows.next_tick) == (2, 21)
    assert np.isnan(told[ROW["measured_n"]]).tolist() == [False] * 5 + [True] * 2 + [False] * 4


def test_every_fault_has_a_code_and_stands_on_the_page_of_states():
    text = PAGE.read_text()
    for name, number in schema()["faults"].items():
        if name != "none":
            assert fault_code(number).startswith("FAULT-") and fault_code(number) in CATALOGUE
            assert f"- `{name}`: " in text


@pytest.fixture
def live():
    with connect("sim:", SYSTEM) as device:
        yield Room(DeviceSession(DeviceEngine(device, SYSTEM)))


def arming(page, what):
    """Arm until something is true: again where a busy machine kept the page silent, which takes the plate off."""

    def tried():
        page.click("#arm-closed")
        with contextlib.suppress(AssertionError):
            return until(what, timeout_s=3.0)

    until(tried)


def armed(page, room):
    closed = "document.querySelector('#device-state').textContent.startsWith('Closed')"
    arming(page, lambda: amplitude(room) > 0.1 and page.evaluate(closed))


@pytest.mark.slow
def test_a_device_is_armed_stopped_and_told_of_in_the_browser(page, serve, live):
    opened(page, serve(live).url)
    assert page.text_content("#source") == "simulated"
    seen(page, "document.querySelector('#device-told').textContent.includes('ceiling 2.50 µm')")
    armed(page, live)
    page.focus("#load")  # the space bar stops the plate whatever has the focus
    page.keyboard.press("Space")
    seen(page, "document.querySelector('#device-state').textContent.startsWith('Idle')")
    until(lambda: amplitude(live) < 1e-3)
    sample = live.session.engine._bench._converters.sample
    live.session.engine._bench._converters.sample = lambda measured: sample(measured)._replace(load=32767)
    arming(page, lambda: "at an end of its converter" in page.text_content("#device-fault"))
    live.session.engine._bench._converters.sample = sample
    page.click("#clear")
    seen(page, "document.querySelector('#device-fault').hidden")
    page.click("[data-box=friction]")
    assert page.evaluate("document.querySelector('#fields').inert")


@pytest.mark.slow
def test_the_plate_is_at_rest_300_ms_after_the_tab_was_killed(page, serve, live):
    opened(page, serve(live).url)
    armed(page, live)
    with contextlib.suppress(Exception):  # nobody is left to answer
        page.goto("chrome://crash", timeout=2000)
    until(lambda: live.session.engine.armed == "idle", timeout_s=5.0)
    ticks = live.session.ticks
    until(lambda: live.session.ticks >= ticks + 1500)
    rows = live.session.last()[:, -(live.session.ticks - ticks - 1500) - 1 :]
    assert amplitude(live) < 1e-3
    assert np.isnan(rows[ROW["closed_um"]]).all()
