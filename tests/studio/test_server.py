"""The application without a browser: who may come in, what is told, what is refused."""

from __future__ import annotations

import hashlib
import json
import re
import shlex
import threading
import warnings
from pathlib import Path

import numpy as np
import pytest
from live_engines import GRATING, Echo

import frictionloop as fl
from frictionloop import studio
from frictionloop.cli.flags import LAW
from frictionloop.cli.studio import _given as opened_with
from frictionloop.live.live_engines import CHANNELS, TwinEngine
from frictionloop.live.live_session import Session
from frictionloop.parameters.presets import RETUNED
from frictionloop.studio.commands import WAITS, obey
from frictionloop.studio.connections import MOST_WAITING, WAITING, Doors, Guest
from frictionloop.studio.frames import FRAME, pack_map, unpack
from frictionloop.studio.opened_studio import on_plate, ringing
from frictionloop.studio.parameter_panels import as_command, differences
from frictionloop.studio.room import Room
from frictionloop.studio.server import studio_app

with warnings.catch_warnings():
    warnings.simplefilter("ignore")  # starlette would have another client than httpx
    from starlette.testclient import TestClient
    from starlette.websockets import WebSocketDisconnect

HOME = "http://localhost"
VENDOR = Path(studio.__file__).parent / "static" / "vendor"
LOCKED = Doors((), "open-sesame", "look-only")


def client(room=None, doors=None):
    return TestClient(studio_app(room or Room(Session(Echo())), doors), base_url=HOME)


def at_socket(at, query="", **headers):
    return at.websocket_connect(f"ws://localhost/live{query}", headers=headers)


class Slow(Echo):
    """An engine that compiles another loop until it is let."""

    def __init__(self):
        super().__init__()
        self.compiled = threading.Event()

    def ready(self, system):
        return system.controller.kind == GRATING.controller.kind

    def prepare(self, system):
        self.compiled.wait(10.0)


def heard(live, kind, most=400):
    """Return the next message of a kind: a JSON one by its type, or a frame."""
    for _ in range(most):
        message = live.receive()
        if (text := message.get("text")) is not None:
            told = json.loads(text)
            if told["type"] == kind:
                return told
        elif kind == "frame" and message["bytes"][0] == 1:
            return unpack(message["bytes"])
    raise AssertionError(f"no {kind} in {most} messages")


def ask(live, **what):
    live.send_text(json.dumps(what))


def test_the_page_comes_with_a_policy_that_allows_nothing_from_elsewhere():
    answer = client().get("/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "http" not in policy
    assert "<script>" not in answer.text
    assert " style=" not in answer.text


@pytest.mark.parametrize(
    "path", ["/static/../server.py", "/static/%2e%2e/server.py", "/static//etc/passwd", "/static/x"]
)
def test_nothing_of_the_disk_is_served_but_the_pages_own_files(path):
    assert client().get(path).status_code == 404


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "10.0.0.3:8026"])
def test_another_name_of_this_machine_is_not_answered(host):
    assert client().get("/", headers={"host": host}).status_code == 403


@pytest.mark.parametrize("origin", ["http://evil.example", "http://localhost:1", "null"])
def test_a_page_from_elsewhere_cannot_open_the_socket(origin):
    with client() as at, pytest.raises(WebSocketDisconnect), at_socket(at, origin=origin):
        pass


def test_a_studio_on_the_network_wants_its_token():
    with client(doors=LOCKED) as at:
        assert at.get("/").status_code == 403
        assert at.get("/?token=wrong").status_code == 403
        assert at.get("/save/run.h5").status_code == 403
        assert at.get("/?token=open-sesame").status_code == 200
        with pytest.raises(WebSocketDisconnect), at_socket(at, "?token=wrong"):
            pass


def test_a_token_to_watch_neither_drives_nor_takes_over_but_can_stop():
    room = Room(Session(Echo()))
    with client(room, LOCKED) as at, at_socket(at, "?token=look-only") as live:
        assert not heard(live, "status")["drives"]
        for what in ({"do": "take"}, {"do": "ghost", "on": False}):
            ask(live, **what)
            assert heard(live, "refused")
        live.send_bytes(np.array([[1.0, 0.0, 0.0, 0.5]]).tobytes())
        ask(live, do="stop")
        while heard(live, "status")["state"] != "stopped":
            pass
        assert room.driver is None


def test_frames_come_with_every_channel_and_the_pointer_is_told_back():
    with client() as at, at_socket(at) as live:
        assert list(heard(live, "hello")["channels"]) == list(CHANNELS)
        live.send_bytes(np.array([[1234.0, 7.0, 0.0, 0.5]]).tobytes())
        frames = [heard(live, "frame") for _ in range(40)]
        assert frames[0].rows.shape[0] == len(CHANNELS)
        assert any(frame.rows[0, -1] == pytest.approx(7.0) for frame in frames)
        assert 1234.0 in [pytest.approx(frame.reached_ms) for frame in frames]


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("nonsense", "Expecting value"),
        ("[1]", "do is missing: one of stop, go"),
        ('{"do": "format_disk"}', "must be one of"),
        ('{"do": "effect", "name": "../../etc/passwd"}', "must be one of"),
        ('{"do": "load", "load_n": NaN}', "must be 0.05 to 5"),
        ('{"do": "load", "load_n": 1e9}', "must be 0.05 to 5"),
        ('{"do": "set", "values": {"controller.kpp": 1}}', "kpp"),
        ('{"do": "set", "values": {"motion.kind": "sliding"}}', "motion"),
        ('{"do": "set", "values": {"disturbance.kind": "recording", "disturbance.path": "/etc/passwd"}}', "file"),
        ('{"do": "set", "values": {"setpoint.effect": "/etc/passwd"}}', "file"),
        ('{"do": "set", "values": {}}', "values"),
        ('{"do": "' + "x" * 30000 + '"}', "at most"),
        ("[" * 5000, ""),
    ],
)
def test_what_is_no_command_is_refused_and_the_session_goes_on(text, why):
    with client() as at, at_socket(at) as live:
        live.send_text(text)
        assert why in heard(live, "refused")["why"]
        assert heard(live, "frame")


def test_a_stroke_reads_the_effect_on_the_line_on_which_the_finger_lands():
    room = Room(Session(Echo()))
    guest = Guest(may_drive=True)
    room.join(guest)
    room.touched(guest, np.array([[1.0, 0.0, 2.5, 0.5]]).tobytes())
    assert room.session.engine.system.setpoint.track.y_mm == 0.0  # a grating along x is the same on every line
    room.session.lift()
    room.session.engine.system = GRATING.evolve({"setpoint.effect": fl.rendering.LIBRARY["braille"]})
    room.touched(guest, np.array([[2.0, 0.0, 2.5, 0.5]]).tobytes())
    assert room.session.engine.system.setpoint.track.y_mm == 2.5
    room.touched(guest, np.array([[3.0, 0.0, -2.5, 0.5]]).tobytes())
    assert room.session.engine.system.setpoint.track.y_mm == 2.5  # a stroke stays on its line


def test_one_page_drives_and_another_can_take_over():
    room = Room(Session(Echo()))
    with client(room) as at, at_socket(at) as first, at_socket(at) as second:
        assert heard(first, "status")["drives"]
        assert not heard(second, "status")["drives"]
        ask(second, do="ghost", on=False)
        assert "another page drives" in heard(second, "refused")["why"]
        ask(second, do="take")
        ask(second, do="ghost", on=False)
        while heard(second, "status")["ghost"]:
            pass
        while heard(first, "status")["drives"]:
            pass


@pytest.mark.parametrize("end", ["leaves", "is taken over", "ends it"])
def test_whoever_comes_after_a_tour_finds_the_loop_as_it_was_before(end):
    room = Room(Session(Echo()))
    first, second = Guest(may_drive=True), Guest(may_drive=True)
    room.join(first)
    room.join(second)
    before = room.session.engine.system
    obey(room, first, {"do": "tour", "on": True})
    obey(room, first, {"do": "set", "values": {"friction.nominal_n": 1.3}})
    assert room.session.engine.system != before
    if end == "leaves":
        room.leave(first)
    elif end == "is taken over":
        room.take(second)
    else:
        obey(room, first, {"do": "tour", "on": False})
    assert room.session.engine.system == before
    room.take(second)
    obey(room, second, {"do": "set", "values": {"friction.nominal_n": 0.7}})
    room.leave(second)
    assert room.session.engine.system.friction.nominal_n == 0.7  # what is no tour stays


def test_a_step_of_the_tour_whose_loop_is_compiled_too_late_is_not_put_in_force():
    engine = Slow()
    before = engine.system
    with client(Room(Session(engine))) as at:
        with at_socket(at) as first:
            ask(first, do="tour", on=True)
            ask(first, do="set", values={"controller.kind": "pi"})
            assert heard(first, "said")["why"] == WAITS
        engine.compiled.set()
        with at_socket(at) as second:
            for _ in range(5):  # a second
                heard(second, "status")
    assert engine.system == before


def test_the_engine_that_dies_is_told_to_every_page_with_its_reason():
    with client(Room(Session(Echo(fails_at=500)))) as at, at_socket(at) as live:
        while (told := heard(live, "status"))["state"] != "dead":
            pass
        assert told["why"] == "ValueError: the wheel came off"


def test_a_slow_page_loses_frames_and_nothing_else():
    """A server that stands still while pages join puts a status for each; the map is sent once and must arrive."""
    guest, field = Guest(may_drive=True), pack_map(np.eye(3), 0.0, 1.0, 0.0, 1.0)
    guest.put({"type": "hello"})
    guest.put(field)
    for number in range(1000):
        guest.put(bytes([FRAME, number % 256]))
        guest.put({"type": "status", "pages": number})
        if not number % 100:
            guest.put({"type": "noted", "number": number})
    waiting = list(guest._waiting)
    assert guest.lost == 1000 - WAITING
    assert waiting[:2] == [{"type": "hello"}, field] and waiting[-1] == {"type": "status", "pages": 999}
    assert [each["number"] for each in waiting if isinstance(each, dict) and "number" in each] == [*range(0, 1000, 100)]
    frames = [each[1] for each in waiting if isinstance(each, bytes)][1:]
    assert frames == [number % 256 for number in range(1000 - WAITING, 1000)]


def test_a_page_that_never_reads_is_let_go_with_all_it_missed():
    guest = Guest(may_drive=True)
    for number in range(MOST_WAITING + 1):
        guest.put({"type": "noted", "number": number})
    with pytest.raises(WebSocketDisconnect):
        guest.next().send(None)


@pytest.mark.parametrize("origin", ["http://[::1", "null", "", "http://127.0.0.1:1", "ftp://testserver"])
def test_a_strange_origin_is_shut_out(origin):
    with client(Room(Session(Echo()))) as at:
        assert at.get("/", headers={"origin": origin}).status_code == 403


def test_a_change_is_undone_and_told():
    room = Room(Session(Echo()))
    with client(room) as at, at_socket(at) as live:
        heard(live, "system")
        ask(live, do="set", values={"friction.nominal_n": 1.2})
        assert heard(live, "system")["differs"]["friction.nominal_n"] == 1.2
        ask(live, do="undo")
        assert "friction.nominal_n" not in heard(live, "system")["differs"]
        assert room.session.engine.system == GRATING
        ask(live, do="undo")
        assert "nothing has been changed" in heard(live, "refused")["why"]


@pytest.mark.parametrize(
    "changes",
    [{}, LAW, {"friction.nominal_n": 1.3}, {"controller.kp": 1.0}, {"setpoint.effect": fl.rendering.find("bump")}],
)
def test_the_command_that_is_shared_opens_the_same_system(changes):
    system = fl.bench().evolve({"setpoint": {"kind": "effect"}}).evolve(changes)
    words = shlex.split(as_command(system, differences(system)))
    assert words[:2] == ["frictionloop", "studio"]
    given = dict(zip(words[2::2], words[3::2], strict=True))
    effect = given.pop("--effect", None)
    overrides = [f"{name.removeprefix('--')}={value}" for name, value in given.items()]
    assert opened_with(None, None, overrides, effect).system == system


def test_a_set_point_of_time_gives_way_to_a_grating_with_a_finding(tmp_path):
    (tmp_path / "b.toml").write_text('preset = "bench"\n')
    given = opened_with(tmp_path / "b.toml", None, None, None)
    assert given.system.setpoint.kind == "effect"
    assert [(each.code, each.value) for each in given.findings] == [("STUDIO-EFFECT", "sine")]
    assert opened_with(None, None, None, None).findings == ()


@pytest.mark.parametrize(("values", "codes"), [({}, ["LOOP-UNSTABLE"]), (RETUNED, []), (LAW, [])])
def test_a_page_that_opens_on_a_loop_that_rings_says_so(values, codes):
    found = ringing(on_plate(fl.bench().evolve(values), "detents"))
    assert [each.code for each in found] == codes
    for each in found:
        assert each.severity == "error"
        assert 100.0 < each.value < 300.0  # above the sensor's resonance of 145 Hz
        assert "Gains that hold" in str(each)


@pytest.mark.slow
def test_what_is_saved_loads_as_a_run(tmp_path):
    session = Session(TwinEngine(GRATING))
    session.step(0.0)
    session.step(0.4)
    for name in ("run.h5", "run.csv", "system.toml"):
        answer = TestClient(studio_app(Room(session)), base_url=HOME).get(f"/save/{name}")
        assert answer.status_code == 200
        (tmp_path / name).write_bytes(answer.content)
    run = fl.load(tmp_path / "run.h5")
    assert fl.system_of(run) == GRATING
    assert run["f_a"].size == 2000
    assert fl.rms_error(run) < 0.5
    assert fl.read_toml(tmp_path / "system.toml") == GRATING
    assert (tmp_path / "run.csv").read_text().count("\n") == 2001


def test_what_others_wrote_is_as_they_published_it():
    told = re.findall(r"^\| (\S+) \| ([0-9a-f]{64}) \|$", (VENDOR / "README.md").read_text(), re.MULTILINE)
    assert {name for name, _ in told} == {each.name for each in VENDOR.glob("uPlot.*.*")}
    for name, digest in told:
        assert hashlib.sha256((VENDOR / name).read_bytes()).hexdigest() == digest
