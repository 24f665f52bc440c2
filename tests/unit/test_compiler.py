"""Building a shared library: once, undisturbed by others, and with one line when it cannot be done."""

from __future__ import annotations

import ctypes
import os
import sys
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context

import pytest

from frictionloop.firmware import host_compiler
from frictionloop.firmware.host_compiler import shared_library
from frictionloop.quantities import FrictionloopError, compile_events


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder for sources, with a cache of its own."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(host_compiler, "cache_folder", lambda: tmp_path / "cache")
    return tmp_path


def source(folder, text):
    path = folder / "answer.c"
    path.write_text(text)
    return [path]


def answer(library):
    return ctypes.CDLL(str(library)).answer()


def test_a_library_is_built_once_for_the_same_sources_headers_and_flags(folder, monkeypatch):
    told = []
    monkeypatch.setattr(compile_events, "on_compiling", [told.append])
    (folder / "answer.h").write_text("#define ANSWER 42\n")
    sources = source(folder, '#include "answer.h"\nint answer(void);\nint answer(void) { return ANSWER; }\n')
    first = shared_library("answer", sources, [folder])
    stamp = first.stat().st_mtime_ns
    assert answer(first) == 42
    assert shared_library("answer", sources, [folder]) == first
    assert first.stat().st_mtime_ns == stamp and told == [True, False]
    assert shared_library("answer", sources, [folder], ("-O0",)) != first
    (folder / "answer.h").write_text("#define ANSWER 43\n")
    assert answer(shared_library("answer", sources, [folder])) == 43
    assert not list(first.parent.glob("*.part"))


@pytest.mark.skipif(sys.platform != "linux", reason="the cache is moved by XDG_CACHE_HOME, which Linux alone reads")
def test_processes_may_build_it_at_the_same_time(folder):
    sources = source(folder, "int answer(void);\nint answer(void) { return 7; }\n")
    with ProcessPoolExecutor(4, get_context("spawn")) as pool:
        paths = set(pool.map(partial(shared_library, "answer"), [sources] * 8))
    assert len(paths) == 1
    assert answer(paths.pop()) == 7


def test_a_complaint_of_the_compiler_is_one_line(folder):
    sources = source(folder, "int answer(void) { return nothing; }\nint more(void) { return nothing; }\n")
    with pytest.raises(FrictionloopError, match=r"^answer: does not compile with .*answer\.c:1:.*error") as refusal:
        shared_library("answer", sources)
    assert "\n" not in str(refusal.value)
    assert not list((folder / "cache").iterdir())


def test_no_compiler_says_what_to_install(folder, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(host_compiler, "find_spec", lambda name: None)
    with pytest.raises(FrictionloopError, match=r"install frictionloop\[image\]"):
        shared_library("answer", source(folder, "int answer;\n"))


def test_without_cc_zig_is_taken(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    monkeypatch.setattr(host_compiler, "find_spec", lambda name: object())
    assert host_compiler.compiler() == (sys.executable, "-m", "ziglang", "cc")


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_a_cache_that_cannot_be_written_is_named(folder):
    (folder / "cache").mkdir(mode=0o500)
    with pytest.raises(FrictionloopError, match="cannot be written"):
        shared_library("answer", source(folder, "int answer;\n"))
