"""A session in a browser: the participant follows and answers by keys and buttons, the experimenter watches blind."""

import json
import threading
import time
from urllib.request import urlopen

import pytest
from studio_pages import until

import frictionloop as fl
from frictionloop.experiments import Protocol, read_trials, run
from frictionloop.experiments.respondent import Aborted, Live
from frictionloop.studio.experiment.experiment_server import served
from frictionloop.studio.experiment.page_respondent import Desk, live_of, trace_of

slow = pytest.mark.slow
PLAN = Protocol(
    title="How small a difference of friction is noticed",
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}, "response_s": 60.0, "cue_s": 0.2, "gap_s": 0.2},
    blocks={"practice": 1},
    stop={"trials": 3},
    masking_db=-26.0,
    validity={"least_response_s": 0.0},
)


class Running:
    """A session in a thread, with its pages."""

    def __init__(self, plan, path):
        self.desk, self.path, self.error = Desk(plan, "P01", "simulated"), path, None
        self._through = served(self.desk)
        self.addresses = self._through.__enter__()

        def session():
            try:
                run(plan, path, "P01", respondent=self.desk)
            except Exception as error:
                self.error = error

        self.thread = threading.Thread(target=session, daemon=True)
        self.thread.start()

    def end(self):
        self.desk.heard.aborted = True
        self.thread.join(20)
        self._through.__exit__(None, None, None)


@pytest.fixture
def session(tmp_path):
    made = []

    def start(plan=PLAN):
        made.append(Running(plan, tmp_path / "P01"))
        return made[-1]

    yield start
    for each in made:
        each.end()


@pytest.fixture
def other(browser):
    """Return a page of another browser context, as of another machine."""
    context = browser.new_context(viewport={"width": 1200, "height": 950})
    yield context.new_page()
    context.close()


def asked(page):
    until(lambda: page.evaluate("document.body.dataset.step === 'answer'"))


def logged(path, event):
    lines = [json.loads(line) for line in (path / "log.jsonl").read_text().splitlines()]
    return [each for each in lines if each["event"] == event]


@slow
def test_a_session_on_two_pages(page, other, session):
    going = session()
    frames = []

    def watched(socket):
        socket.on("framereceived", lambda data: frames.append(str(data)))

    other.on("websocket", watched)
    other.goto(going.addresses.experimenter)
    until(lambda: "not connected" in other.text_content("#status"))
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    page.keyboard.press("Space")
    until(lambda: "Follow the dot: first stroke" in page.text_content("#said"))
    until(lambda: page.evaluate("window.noise.level()") == pytest.approx(-26.0, abs=1.5))
    asked(page)
    page.keyboard.press("1")
    asked(page)
    other.fill("#text", "the finger is dry")
    other.click("#note button")
    until(lambda: "the finger is dry" in other.text_content("#notes"))
    other.click("#pause")
    until(lambda: logged(going.path, "pause"))  # else a trial that has begun waits for an answer
    page.click("[data-choice='2']")
    until(lambda: page.text_content("#said") == "One moment, please")
    held = len(read_trials(going.path))
    time.sleep(0.6)
    assert len(read_trials(going.path)) == held
    other.click("#pause")
    while going.thread.is_alive():
        if page.evaluate("document.body.dataset.step") == "answer":
            page.keyboard.press("1")
        time.sleep(0.05)
    until(lambda: "the end" in page.text_content("#said"))
    assert going.error is None
    trials = read_trials(going.path)
    assert trials["response"].tolist()[:2] == ["1", "2"]
    assert (trials["response"] != "").all(), trials["reason"].tolist()
    assert (trials["rt_s"] < PLAN.timeline.response_s).all()
    assert (trials["rt_uncertainty_s"] > 0).all()
    assert (trials["rt_uncertainty_s"] < 0.05).all()
    assert [each["event"] for each in logged(going.path, "pause") + logged(going.path, "go on")] == ["pause", "go on"]
    assert logged(going.path, "note")[0]["text"] == "the finger is dry"
    told = "".join(frames)
    assert '"live"' in told
    assert '"row"' in told
    for secret in ("requested", "delivered", "condition", "force_n", "setpoint_n", "comparison", "correct", "response"):
        assert f'"{secret}"' not in told
    until(lambda: "over" in other.text_content("#status"))


@slow
def test_a_session_is_paused_and_goes_on_by_two_presses_before_the_page_hears_of_the_first(page, other, session):
    """What the page asks for must not hang on a status that comes late: the second press was a pause too."""
    going = session()
    other.add_init_script(
        "const Plain = WebSocket; window.WebSocket = class extends Plain { set onmessage(take) {"
        " const late = ({ data }) => (String(data).includes('\"status\"') ? 1500 : 0);"
        " super.onmessage = (event) => setTimeout(take, late(event), event); } };"
    )
    other.goto(going.addresses.experimenter)
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    until(lambda: "running" in other.text_content("#status"))
    for said, pressed in (("pause", "Go on"), ("go on", "Pause")):
        other.click("#pause")
        assert other.text_content("#pause") == pressed
        until(lambda said=said: len(logged(going.path, said)) == 1)
    assert going.desk.heard.going.is_set()


@slow
def test_an_answer_that_is_given_while_the_link_is_away_is_not_lost(page, session):
    going = session()
    page.add_init_script(
        "window.sockets = []; const Plain = WebSocket;"
        "window.WebSocket = class extends Plain { constructor(...all) { super(...all); window.sockets.push(this); } };"
    )
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    page.click("#go")
    asked(page)
    page.evaluate("sockets.at(-1).close(); dispatchEvent(new KeyboardEvent('keydown', { key: '1' }))")
    until(lambda: len(read_trials(going.path)) == 1)
    assert page.evaluate("sockets.length") == 2
    found = read_trials(going.path)
    assert found["response"][0] == "1"
    assert 0.0 < found["rt_uncertainty_s"][0] < 0.05


@slow
def test_a_key_that_is_held_since_before_the_question_is_no_answer(page, session):
    going = session()
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    page.click("#go")
    until(lambda: page.evaluate("document.body.dataset.step === 'stroke'"))
    held = ("1", "Enter")
    for key in held:
        page.keyboard.down(key)
    asked(page)
    page.focus("[data-choice='2']")
    for key in held * 2:
        page.keyboard.down(key)  # as a keyboard repeats it
    time.sleep(0.3)
    assert page.evaluate("document.body.dataset.step") == "answer"
    for key in held:
        page.keyboard.up(key)
    page.keyboard.press("Enter")
    until(lambda: len(read_trials(going.path)) == 1)
    assert read_trials(going.path)["response"][0] == "2"


@slow
def test_the_participants_token_does_not_open_the_experimenters_page(session, page):
    going = session()
    page.excused = ("403", "404")  # the second is the icon that a browser asks for beside plain text
    address = going.addresses.participant.replace("/participant", "/experimenter")
    assert page.goto(address).status == 403
    with urlopen(going.addresses.experimenter) as found:
        assert found.status == 200


@slow
def test_an_abort_ends_the_session_and_a_level_that_was_changed_is_in_the_log(page, other, session):
    going = session()
    other.goto(going.addresses.experimenter)
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    page.click("#go")
    other.locator("#masking").fill("-40")
    until(lambda: "40 dB" in page.text_content("#sound"))
    asked(page)
    other.click("#stop")
    other.click("#stop")
    until(lambda: not going.thread.is_alive())
    assert isinstance(going.error, Aborted)
    assert -40 in [each.get("value") for each in logged(going.path, "adjusted") if each["what"] == "masking_db"]
    assert logged(going.path, "stopped")[0]["why"] == "aborted by the experimenter"


@slow
def test_an_answer_that_does_not_come_closes_the_window_and_numbers_are_typed(page, session):
    going = session(PLAN.evolve({
        "task": "magnitude", "question": "How rough did it feel?", "masking_db": None,
        "stimulus": {"field": "level_n", "adds": False},
        "method": {"kind": "constant", "levels": [0.35, 0.45], "repeats": 1},
        "timeline.response_s": 1.0, "blocks.practice": 0,
    }))  # fmt: skip
    page.goto(going.addresses.participant)
    until(lambda: page.is_visible("#go"))
    page.click("#go")
    asked(page)
    until(lambda: len(read_trials(going.path)) == 1)
    assert read_trials(going.path)["reason"][0] == "no answer in time"
    asked(page)
    page.keyboard.type("12,5")
    page.keyboard.press("Enter")
    until(lambda: len(read_trials(going.path)) == 2)
    assert float(read_trials(going.path)["response"][1]) == 12.5


def test_before_the_finger_slides_the_error_does_not_give_the_level_away():
    run_ = fl.simulate(fl.bench(), 0.5)
    assert abs(float(run_["f_a"][0] - run_["f_r"][0])) > 0.1
    shown = [each for each in trace_of(run_, 1, 0.5, True)["error_mn"] if each is not None]
    assert shown
    assert max(map(abs, shown)) <= 100.0
    assert set(trace_of(run_, 1, 0.5, True)) == {"interval", "duration_s", "error_mn"}
    assert live_of(Live(1, 0.1, 0.0, 0.45, 0.0, 0.5), True)["error_mn"] == -100.0
    assert "force_n" in live_of(Live(1, 0.1, 0.0, 0.45, 0.0, 0.5), False)


def test_an_answer_that_claims_to_come_later_than_it_was_heard_counts_as_heard():
    desk = Desk(PLAN, "P01", "simulated")
    before = time.monotonic()
    desk.heard.hear("participant", {"do": "answer", "answer": "1", "trial": 1, "at_s": before + 99.0, "sd_s": 0.001})
    assert before <= desk.heard.answers.get()[2] <= time.monotonic()
