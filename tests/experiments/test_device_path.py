"""A session on a device when something goes wrong: disarmed, late, a clock that jumps, a full disk, two at once."""

import gc
import json
import resource
from contextlib import contextmanager

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.experiments import Protocol, read_trials, resumable_session, resume, run
from frictionloop.experiments.device_strokes import ClockMap
from frictionloop.experiments.protocol import bundled, read_protocol
from frictionloop.experiments.respondent import Presented, Respondent, Response
from frictionloop.experiments.study_run import study_system
from frictionloop.quantities import FrictionloopError

PLAN = Protocol(
    stimulus={"standard": 0.35},
    method={"kind": "staircase", "start": [0.15], "most": 0.2},
    timeline={"stroke": {"length_mm": 10.0}},
    stop={"trials": 3},
    validity={"contact_share": 0.0, "saturated_share": 1.0, "speed_mm_s": (0.1, 99.0), "load_n": (0.01, 9.0)},
    fit_to_finger=False,
)


class Person(Respondent):
    """Answers 1, after 0.7 s but where told otherwise; does something at the first sample of a trial's interval."""

    def __init__(self, late=(), does=None):
        self.late, self.does, self.trial = late, does or {}, 0

    def before(self, trial):
        self.trial = trial.number

    def live(self, sample):
        if action := self.does.pop((self.trial, sample.interval), None):
            action()

    def respond(self, trial, presented):
        return Response("1", 9.0 if trial.number in self.late else 0.7)


@pytest.fixture
def engines(monkeypatch):
    """Return a list that every engine made is put into."""
    made, real = [], resumable_session.engine_at

    def kept(*given):
        made.append(real(*given))
        return made[-1]

    monkeypatch.setattr(resumable_session, "engine_at", kept)
    return made


@pytest.mark.slow
def test_a_device_that_is_disarmed_in_mid_trial_loses_that_trial_alone(tmp_path, engines):
    path = tmp_path / "P01"
    disarm = {(2, 2): lambda: engines[0]._device.mode("idle")}
    with pytest.raises(FrictionloopError, match=r"trial 2: state: idle.*experiment resume") as caught:
        run(PLAN, path, "P01", address="sim:", respondent=Person(does=disarm))
    assert "\n" not in str(caught.value)
    assert read_trials(path)["trial"].tolist() == [1]
    assert fl.load(path / "raw" / "interrupted-1.h5").sizes["time"] > 0
    resume(path, respondent=Person())
    assert read_trials(path)["trial"].tolist() == [1, 2, 3]
    whole = run(PLAN, tmp_path / "whole", "P01", address="sim:", respondent=Person()).folder
    same = ["trial", "condition", "phase", "comparison", "requested", "response"]
    assert read_trials(path)[same].equals(read_trials(whole)[same])


@pytest.mark.slow
def test_an_answer_outside_its_window_does_not_count_and_the_trial_is_repeated(tmp_path):
    trials = read_trials(
        run(PLAN, tmp_path / "P01", "P01", address="sim:", respondent=Person(late=(2,)), trials=3).folder
    )
    assert trials["reason"].tolist() == ["", "no answer in time", ""]
    assert trials["again"].tolist() == [0, 1, 0]
    assert trials["repeat_of"].tolist() == [0, 0, 2]
    assert trials["requested"][1] == trials["requested"][2]


@pytest.mark.slow
def test_a_trial_in_which_a_clock_jumps_does_not_count_and_says_so(tmp_path, engines):
    def jump():
        device = engines[0]._device
        real = device.clock
        device.clock = lambda: tuple(np.add(real(), (0.5, 0.0, 0.0)))

    path = run(PLAN, tmp_path / "P01", "P01", address="sim:", respondent=Person(does={(2, 1): jump}), trials=3).folder
    trials = read_trials(path)
    assert trials["reason"].tolist() == ["", "clock_jump=0.5", ""]
    assert trials["counted"].tolist() == [1, 0, 1]
    logged = [json.loads(line) for line in (path / "log.jsonl").read_text().splitlines()]
    assert [each["trial"] for each in logged if each["event"] == "clock jumped"] == [2]


def test_an_answer_is_mapped_to_the_clock_of_the_device_with_its_uncertainty(engines):
    """A clock 30 ppm fast and 100 s ahead, read over a line of 1 to 3 ms."""
    rng, clock = np.random.default_rng(0), ClockMap(2e-4)
    for host in np.arange(0.0, 60.0, 0.5):
        trip, share = rng.uniform(1e-3, 3e-3), rng.uniform()
        true = 100.0 + (1 + 30e-6) * (host + (share - 0.5) * trip)
        assert clock.add(np.floor(true / 2e-4) * 2e-4, host, trip) == 0.0
    errors = [clock.device_s(host)[0] - 100.0 - (1 + 30e-6) * host for host in (10.0, 61.0)]
    sd = clock.device_s(61.0)[1]
    assert 1e-4 < sd < 1e-3
    assert np.abs(errors).max() < 2 * sd
    assert clock.add(100.0 + 61.0 + 0.02, 61.0, 1e-3) == pytest.approx(0.02, abs=3e-3)
    assert clock.device_s(61.0)[0] == pytest.approx(161.02, abs=1e-6)  # the line starts afresh
    engine = resumable_session.engine_at("sim:", study_system())
    engine._waits, engine._clock = True, clock
    engine._device.clock = lambda: (161.02, 61.0, 1e-3)
    given, jump = engine.answered(Response("1", 0.0, 0.003, at_s=61.0), [Presented(None, 159.0, 160.5)])
    engine.close()
    assert jump == 0.0
    assert given.rt_s == pytest.approx(0.52, abs=1e-4)
    assert 0.003 < given.uncertainty_s < 0.004


@contextmanager
def files_of(most_bytes):
    """Let no file grow over a size; a write that would is refused by the system, as on a full disk."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most_bytes, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.slow
@pytest.mark.parametrize("address", ["bench:", "sim:"])
def test_a_disk_without_room_for_traces_ends_the_session_with_whole_rows(address, tmp_path):
    path = run(PLAN, tmp_path / "P01", "P01", respondent=Person(), address=address, trials=1).folder
    before = (path / "trials.tsv").read_bytes()
    with files_of(4000), pytest.raises(FrictionloopError, match="cannot be written"):
        resume(path, respondent=Person())
    gc.collect()  # a file that was left open warns here
    assert [each.name for each in (path / "raw").iterdir()] == ["trial-00001.h5"]
    assert (path / "trials.tsv").read_bytes() == before
    resume(path, respondent=Person())
    assert read_trials(path)["trial"].tolist() == [1, 2, 3]


@pytest.mark.slow
def test_a_second_run_of_a_session_that_goes_on_is_refused(tmp_path):
    path, refused = tmp_path / "P01", []

    def again():
        for second in (lambda: resume(path, respondent=Person()), lambda: run(PLAN, path, "P01")):
            with pytest.raises(FrictionloopError) as caught:
                second()
            refused.append(str(caught.value))

    run(PLAN, path, "P01", address="sim:", respondent=Person(does={(1, 2): again}))
    assert "another run goes on" in refused[0]
    assert refused[1].startswith(f"{path}: ") and "experiment resume" in refused[1]
    assert read_trials(path)["valid"].all()


def short(name):
    plan = read_protocol(name)
    changes = {"stop.trials": 1, "timeline.stroke.length_mm": 10.0, "blocks.practice": 0, "fit_to_finger": False}
    if plan.method.kind == "constant":
        changes |= {"method.repeats": 1}
    if plan.method.kind == "psi":
        changes |= {"method.thresholds": 12, "method.spreads": 4, "method.levels": 8}
    return plan.evolve(changes)


@pytest.fixture(scope="module")
def image(tmp_path_factory):
    return fl.firmware.build(study_system(), tmp_path_factory.mktemp("image")).image


@pytest.mark.slow
@pytest.mark.parametrize("name", bundled())
def test_every_bundled_protocol_runs_on_the_emulated_board(name, image, tmp_path):
    path = run(short(name), tmp_path / "P01", "P01", address=f"emulated:{image}", trials=1).folder
    trials = read_trials(path)
    assert json.loads((path / "session.json").read_text())["source"] == "emulated"
    assert trials["contact_share_1"][0] > 0.5
    assert np.isfinite(trials["delivered"][0])
    traces = fl.load(path / trials["raw"][0])
    assert (traces.attrs["source"], traces.attrs["board"]) == ("emulated", "teensy41")
    assert trials["onset_s"][0] > 0


def test_the_bench_told_by_a_device_has_the_reach_of_its_finger(engines):
    system = study_system()
    engine = resumable_session.engine_at("sim:", system)
    found = engine.reach(system, 0)
    engine.close()
    bench = resumable_session.engine_at("bench:", system).reach(system, 0)
    assert found.reach.high_n == pytest.approx(bench.reach.high_n, rel=0.15)
    assert found.reach.low_n == pytest.approx(bench.reach.low_n, rel=0.25)
