"""What a progress line says while something is compiled."""

from __future__ import annotations

import io
import re
import threading

from numba import types

from frictionloop.loop import progress
from frictionloop.loop.progress import Bar, progress_bar
from frictionloop.quantities import compile_cache, compile_events


def test_a_bar_says_what_it_waits_for_and_then_again_what_it_does():
    said = []
    bar = Bar("report", lambda: None, said.append)
    bar.doing("Fig. 5a")
    bar.compiling(True)
    bar.compiling(False)
    assert said == [
        "report: Fig. 5a",
        "report: Fig. 5a; compiling for it, once after an installation",
        "report: Fig. 5a",
    ]


def test_a_bar_is_told_of_compilations_only_while_it_stands(capsys):
    with progress_bar("work", 1, show=True):
        assert len(compile_events.on_compiling) == 1
    with progress.waiting("work"):
        assert len(compile_events.on_compiling) == 1
    assert compile_events.on_compiling == []
    capsys.readouterr()


def doubled():
    def function(x):
        return 2.0 * x

    return compile_cache.compile_c(types.float64(types.float64), function, "doubled-for-a-test")


def test_what_is_on_the_disk_is_not_compiled(monkeypatch):
    told = []
    monkeypatch.setattr(compile_events, "on_compiling", [told.append])
    monkeypatch.setattr(
        compile_cache.DigestCache, "load_overload", lambda self, sig, context: compile_events.tell_compiling(True)
    )

    assert doubled().ctypes(1.5) == 3.0 and told == [True, False]
    monkeypatch.undo()
    monkeypatch.setattr(compile_events, "on_compiling", [told.append])
    assert doubled().ctypes(1.5) == 3.0 and told == [True, False]


def test_without_a_terminal_long_work_is_told_in_plain_lines(monkeypatch):
    said, more = [], threading.Event()
    monkeypatch.setattr(progress, "FIRST_S", 0.01)
    monkeypatch.setattr(progress, "LOOK_S", 0.005)

    def write(line):
        said.append(line)
        more.set()

    with progress.plain_lines(write), progress_bar("report", 4) as bar:
        bar.doing("Fig. 5a")
        bar()
        more.clear()
        assert more.wait(10)
    assert re.fullmatch(r"report: Fig\. 5a: 1 of 4 done(, about 0 s left)?, 0 s so far", said[-1])
    assert progress.under_way == []


def test_work_that_is_soon_done_is_not_told(capsys):
    said = []
    with progress.plain_lines(said.append), progress_bar("sweep", 4) as bar:
        bar()
    assert said == [] and capsys.readouterr().err == ""


def test_work_without_parts_is_told_once_it_takes_long(monkeypatch):
    said, more = [], threading.Event()
    monkeypatch.setattr(progress, "FIRST_S", 0.01)
    monkeypatch.setattr(progress, "LOOK_S", 0.005)
    monkeypatch.setattr(progress, "QUIET_S", 0.02)
    monkeypatch.setattr("sys.stderr", io.StringIO())

    def write(line):
        said.append(line)
        more.set()

    with progress.plain_lines(write), progress.waiting("designing notch_pi"):
        assert more.wait(10)
    assert said[0] == "designing notch_pi, 0 s so far"
    assert progress.under_way == []


def test_work_without_parts_that_is_soon_done_is_not_told(monkeypatch):
    said = []
    monkeypatch.setattr(progress, "FIRST_S", 0.01)
    monkeypatch.setattr(progress, "LOOK_S", 0.005)
    monkeypatch.setattr("sys.stderr", io.StringIO())
    with progress.plain_lines(said.append), progress.waiting("designing notch_pi"):
        threading.Event().wait(0.1)
    assert said == []


def test_the_step_of_long_work_is_told_beside_it(monkeypatch):
    monkeypatch.setattr(progress, "QUIET_S", 0.0)
    with progress.waiting("designing"):
        now = progress.under_way[-1]
        assert now() == "designing"
        progress.step("notch 2 of 9")
        assert now() == "designing: notch 2 of 9"
        compile_events.tell_compiling(True)
        assert now() == "designing: notch 2 of 9; compiling for it, once after an installation"
        compile_events.tell_compiling(False)
        assert now() == "designing: notch 2 of 9"
    assert progress.on_step == []
    progress.step("nobody waits for this")


def test_what_is_left_is_told_from_the_parts_that_are_done(monkeypatch):
    monkeypatch.setattr("sys.stderr", io.StringIO())
    with progress_bar("sweep", 4) as bar:
        assert progress.under_way[-1]() == "sweep: 0 of 4 done"
        bar()
        monkeypatch.setattr(progress, "_so_far_s", [progress._so_far_s[0] + 10.0])
        assert progress.under_way[-1]() == "sweep: 1 of 4 done, about 30 s left"
