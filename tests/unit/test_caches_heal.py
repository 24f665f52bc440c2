"""Caches of compiled code: a damaged file is made anew, and what another user could have put there is not run."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import textwrap

import numba
import pytest

import frictionloop as fl
from frictionloop.firmware import host_compiler
from frictionloop.quantities import FrictionloopError
from frictionloop.quantities import compile_cache as cache_module
from frictionloop.quantities.file_integrity import seal_of

DOUBLED = """
    import sys, warnings
    from numba import types
    from own import doubled
    from frictionloop.quantities.compile_cache import compile_c

    warnings.showwarning = lambda message, *more: print("said:", message)
    for _ in range(int(sys.argv[1])):
        compiled = compile_c(types.float64(types.float64), doubled, "doubled")
        print(compiled.cache_hits, compiled.ctypes(3.0))
"""
posix = pytest.mark.skipif(os.name != "posix", reason="owners and rights as POSIX has them")


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "own.py").write_text("def doubled(x):\n    return 2.0 * x\n")
    return tmp_path


def compiled(folder, times=1, **more):
    """Return what a process of its own says that takes a function from the cache, or compiles it."""
    script = [sys.executable, "-B", "-c", textwrap.dedent(DOUBLED), str(times)]
    paths = os.pathsep.join([str(folder), *sys.path])
    environment = os.environ | {"PYTHONPATH": paths, "NUMBA_CACHE_DIR": str(folder / "cache")} | more
    done = subprocess.run(script, capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def damages(path):
    content = path.read_bytes()
    changed = bytearray(content)
    changed[len(content) // 2] ^= 1
    return {"half": content[: len(content) // 2], "a bit": bytes(changed), "empty": b"", "text": b"no pickle"}


@pytest.mark.parametrize("ending", [".nbi", pytest.param(".nbc", marks=pytest.mark.slow)])
def test_a_damaged_function_is_compiled_anew(folder, ending):
    assert compiled(folder) == ["0 6.0"]
    (path,) = folder.rglob(f"*{ending}")
    for content in damages(path).values():
        path.write_bytes(content)
        assert compiled(folder, times=2) == [f"said: {path}: is damaged; it is made anew", "0 6.0", "1 6.0"]


def test_a_function_whose_index_names_a_class_that_is_gone_is_compiled_anew(folder):
    compiled(folder)
    (path,) = folder.rglob("*.nbi")
    content = pickle.dumps(numba.__version__) + b"cgone.module\nThing\n."
    path.write_bytes(content + seal_of(content))
    assert compiled(folder) == ["0 6.0"]


@pytest.mark.slow
@posix
def test_functions_that_others_could_have_put_there_are_not_run(folder):
    compiled(folder)
    (path,) = folder.rglob("*.nbc")
    path.parent.chmod(0o777)
    said, result = compiled(folder)
    assert said == f"said: others may write to {path.parent}: not used; chmod go-w it"
    assert result == "0 6.0"


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="root alone makes another's file")
def test_a_file_of_another_user_is_not_run(folder, monkeypatch):
    compiled(folder)
    (path,) = folder.rglob("*.nbc")
    os.chown(path, 65534, 65534)
    assert compiled(folder)[0].startswith(f"said: {path} belongs to another user")
    library, build = core(folder, monkeypatch)
    os.chown(library, 65534, 65534)
    with pytest.raises(FrictionloopError, match=f"{library} .*another user.*chmod"):
        build()


def core(folder, monkeypatch):
    monkeypatch.setattr(host_compiler, "cache_folder", lambda: folder / "core")
    source = folder / "answer.c"
    source.write_text("int answer(void);\nint answer(void) { return 42; }\n")

    def build():
        return host_compiler.shared_library("answer", [source])

    return build(), build


def answer(library):
    """Load it in a process of its own: half a library kills the one that loads it."""
    code = f"import ctypes; print(ctypes.CDLL({str(library)!r}).answer())"
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False).stdout.strip()


def test_a_damaged_library_is_built_anew(folder, monkeypatch):
    library, build = core(folder, monkeypatch)
    assert answer(library) == "42"
    for content in damages(library).values():
        library.write_bytes(content)
        with pytest.warns(UserWarning, match=f"{library}: is damaged; it is made anew"):
            assert build() == library
        assert answer(library) == "42"
        assert build() == library  # and nothing more is said


@posix
def test_a_library_that_others_could_have_put_there_is_not_run(folder, monkeypatch):
    library, build = core(folder, monkeypatch)
    for path, usual in ((library, 0o755), (library.parent, 0o700)):
        path.chmod(0o777)
        with pytest.raises(FrictionloopError, match=f"others may write to {path}; delete it, or chmod go-w"):
            build()
        path.chmod(usual)
    assert build() == library


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write anywhere")
def test_beside_the_source_is_kept_what_the_cache_cannot_take(folder):
    (folder / "cache").mkdir(mode=0o500)
    assert compiled(folder)[1:] == ["0 6.0"]
    assert compiled(folder)[1:] == ["1 6.0"]
    assert list((folder / "__pycache__").glob("*.nbc"))


@pytest.mark.slow
def test_a_folder_for_the_cache_that_cannot_be_written_is_named_once(folder):
    (folder / "cache").write_text("in the way")
    says = f"said: NUMBA_CACHE_DIR = {folder / 'cache'}: cannot be written; compiled code is kept in "
    for hits in ("0 6.0", "1 6.0"):
        said, *results = compiled(folder, times=3)
        assert said == says + str(folder / "__pycache__")
        assert results == [hits, "1 6.0", "1 6.0"]


def test_no_place_for_a_cache_is_said_and_the_function_is_compiled(folder):
    (folder / "cache").write_text("in the way")
    (folder / "__pycache__").write_text("in the way")
    (folder / "home").write_text("in the way")
    said, result = compiled(folder, HOME=str(folder / "home"), XDG_CACHE_HOME=str(folder / "home"))
    assert f"NUMBA_CACHE_DIR = {folder / 'cache'}, {folder / '__pycache__'}" in said
    assert result == "0 6.0"


def test_a_step_without_a_place_for_its_cache_runs_from_python(monkeypatch):
    """`keep_compiled` and `compile_c` open the cache at one place, which may find none."""

    def nowhere(*_):
        raise RuntimeError("no locator available")

    doubled = fl.step(lambda value: 2.0 * value)
    monkeypatch.setattr(cache_module, "DigestCache", nowhere)
    with pytest.warns(UserWarning, match=r"no cache of compiled code: .* cannot be written"):
        cache_module.keep_compiled(doubled, "doubled")
    assert doubled(3.0) == 6.0
