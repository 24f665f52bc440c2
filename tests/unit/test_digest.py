"""What a function computes decides its digest, and nothing else does; and what is compiled follows the digest."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap
from collections import namedtuple
from types import ModuleType

import numpy as np
import pytest

from frictionloop.control.laws import LAWS
from frictionloop.quantities.code_version import code_digest

SOURCE = '''
from typing import NamedTuple
from numba import njit

FACTOR = 3.0
TABLE = (1.0, 2.0)

class Pair(NamedTuple):
    first: float
    second: float = 0.5

@njit(error_model="numpy")
def helper(x):
    """Half of it."""
    return 0.5 * x

@njit
def unrelated(x):
    return x + 100.0

def made(offset):
    @njit(error_model="numpy")
    def inner(x, scale=2.0):
        """Equation (7)."""
        pair = Pair(helper(x))
        # a line of thought
        return scale * FACTOR * pair.first + offset + pair.second + TABLE[1] + 7.0
    return inner

f = made(4.0)
'''


def digest(*changes):
    """The digest of ``f``, with pieces of its module replaced."""
    source = SOURCE
    for old, new in changes:
        assert source.count(old) == 1
        source = source.replace(old, new)
    space = {"__name__": "somewhere"}
    exec(compile(source, "<module>", "exec"), space)  # a module of a test's own
    return code_digest(space["f"])


@pytest.mark.parametrize(
    "change",
    [
        ("Equation (7).", "Equation (7) of another edition."),
        ("Half of it.", "A half."),
        ("# a line of thought", "# another\n        # and one more"),
        ("\nFACTOR", "\n\n\n# the paper's\nFACTOR"),
        ("x + 100.0", "x + 200.0"),
        ("\ndef made", "\ndef more(x):\n    return x\n\ndef made"),
        ("FACTOR = 3.0", "UNUSED = 1.0\nFACTOR = 3.0"),
    ],
    ids=["docstring", "of a callee", "comment", "line numbers", "unrelated function", "new function", "new number"],
)
def test_what_changes_nothing_leaves_it(change):
    assert digest(change) == digest()


@pytest.mark.parametrize(
    "change",
    [
        ("+ 7.0", "+ 8.0"),
        ("+ 7.0", "+ 7"),
        ("+ 7.0", "- 7.0"),
        ("FACTOR = 3.0", "FACTOR = 3.5"),
        ("TABLE = (1.0, 2.0)", "TABLE = (1.0, 2.5)"),
        ("TABLE = (1.0, 2.0)", "TABLE = (1, 2.0)"),
        ("return 0.5 * x", "return 0.25 * x"),
        ("return 0.5 * x", "return x * 0.5 * unrelated(x)"),
        ("made(4.0)", "made(5.0)"),
        ("scale=2.0", "scale=2.5"),
        ("second: float = 0.5", "second: float = 0.6"),
        ("first: float", "zeroth: float = 0.0\n    first: float = 1.0"),
        ('@njit(error_model="numpy")\ndef helper', "@njit\ndef helper"),
        ('@njit(error_model="numpy")\n    def inner', '@njit(error_model="numpy", fastmath=True)\n    def inner'),
    ],
    ids=[
        *("constant", "type of a constant", "operator", "number of the module", "tuple of the module"),
        *("type in a tuple", "callee", "a new callee", "closure", "default", "default of a named tuple"),
        *("field of a named tuple", "how a callee is compiled", "how it is compiled"),
    ],
)
def test_what_changes_what_is_computed_changes_it(change):
    assert digest(change) != digest()


def test_a_callees_callee_counts():
    deeper = ("def helper(x):", "def helper(x):\n    x = unrelated(x)")
    assert digest(deeper, ("x + 100.0", "x + 200.0")) != digest(deeper)


HELPERS = """
from numba import njit

FACTOR = 2.0

@njit
def helper(x):
    return FACTOR * x

def of_the_library(x):
    return x + 1.0
"""


def through_a_module(change=("", "")):
    """The digest of a function that takes functions from a module by their dotted names."""
    library, package = ModuleType("library"), ModuleType("package")
    exec(HELPERS.replace(*change), vars(library))
    package.library = library
    space = {"package": package, "library": library}
    exec("def g(x):\n    return library.of_the_library(x)", space)
    exec("def f(x):\n    return g(x) + package.library.helper(x)", space)
    return code_digest(space["f"])


def test_what_is_taken_from_a_module_counts_and_the_rest_of_it_does_not():
    assert through_a_module(("x + 1.0", "x + 2.0")) == through_a_module()
    assert through_a_module(("FACTOR * x", "FACTOR + x")) != through_a_module()
    assert through_a_module(("FACTOR = 2.0", "FACTOR = 3.0")) != through_a_module()


def test_the_order_of_the_fields_of_named_tuples_counts():
    """Rows of the same numbers under other names: compiled code takes each by its name."""

    def reads_first(*fields):
        rows = namedtuple("Gains", fields)(10, 11)
        return lambda values: values[rows.kp]

    assert code_digest(reads_first("kp", "ki")) == code_digest(reads_first("kp", "ki"))
    assert code_digest(reads_first("kp", "ki")) != code_digest(reads_first("ki", "kp"))


def test_what_else_decides_counts():
    assert code_digest(digest, (1, 2)) != code_digest(digest, (1, 3)) != code_digest(digest)


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (np.arange(3), np.arange(1, 4)),
        (np.arange(3), np.arange(3.0)),
        (np.zeros((2, 3)), np.zeros((3, 2))),
        (0.0, -0.0),
        (1, True),
        (len, abs),
        (np, os),
    ],
    ids=["array", "type of an array", "shape of an array", "sign", "truth", "built-in", "library"],
)
def test_values_that_differ(one, other):
    assert code_digest(one) == code_digest(one)
    assert code_digest(one) != code_digest(other)


def test_functions_that_call_themselves_or_one_another():
    def even(n):
        return n == 0 or odd(n - 1)

    def odd(n):
        return n != 0 and even(n - 1)

    assert code_digest(even) == code_digest(even) != code_digest(odd)


IN_ANOTHER = """
    from frictionloop.control.laws import LAWS
    from frictionloop.loop.kernel.bench_tile import build_sense
    from frictionloop.loop.kernel.step_lifting import lifting
    from frictionloop.physics.vibration import GAUSSIAN
    from frictionloop.quantities.code_version import code_digest

    print(*(code_digest(law.step) for law in LAWS.values()))
    print(code_digest(build_sense(lifting("sense", 32), "bristle", GAUSSIAN, True)))
"""


@pytest.mark.slow
def test_it_is_the_same_in_every_process():
    """Whatever the seed of hashes, whether modules are read from their source or from what Python kept of it."""
    found = set()
    for seed, flags in (("1", ()), ("2", ("-B", "-X", "pycache_prefix=/nowhere"))):
        script = [sys.executable, *flags, "-c", textwrap.dedent(IN_ANOTHER)]
        found.add(subprocess.run(script, capture_output=True, text=True, check=True,
                                 env=os.environ | {"PYTHONHASHSEED": seed}).stdout)  # fmt: skip
    assert len(found) == 1
    assert found.pop().split()[: len(LAWS)] == [code_digest(law.step) for law in LAWS.values()]


KEPT = """
    from numba import types
    from own import doubled
    from frictionloop.quantities.compile_cache import compile_c

    compiled = compile_c(types.float64(types.float64), doubled, "doubled")
    print(compiled.cache_hits, compiled.ctypes(3.0))
"""
OWN = '''
def helper(x):
    """A helper."""
    return x


def doubled(x):
    """Twice x."""
    return 2.0 * x
'''


@pytest.mark.slow
def test_what_is_kept_on_the_disk_is_taken_while_the_digest_stays(tmp_path):
    def told(source):
        (tmp_path / "own.py").write_text(source)
        script = [sys.executable, "-B", "-c", textwrap.dedent(KEPT)]
        paths = os.pathsep.join([str(tmp_path), *sys.path])
        run = subprocess.run(script, capture_output=True, text=True, check=True,
                             env=os.environ | {"PYTHONPATH": paths})  # fmt: skip
        return run.stdout.split()

    assert told(OWN) == ["0", "6.0"]
    assert told(OWN) == ["1", "6.0"]
    assert told(OWN.replace("Twice x", "The double").replace("return x\n", "return -x  # back\n")) == ["1", "6.0"]
    assert told(OWN.replace("2.0 * x", "4.0 * x")) == ["0", "12.0"]
    assert told(OWN) == ["1", "6.0"]
