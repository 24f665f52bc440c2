"""The package as others meet it: what importing costs, which names there are, what they say about themselves."""

from __future__ import annotations

import ast
import doctest
import importlib
import inspect
import itertools
import pickle
import pkgutil
import pydoc
import subprocess
import sys
from pathlib import Path

import pytest

import frictionloop as fl

FOLDER = Path(fl.__file__).parent
EXPLAINED = [name for name in dir(fl) if callable(getattr(fl, name))]
MODULES = sorted(info.name for info in pkgutil.walk_packages([str(FOLDER)], "frictionloop."))


def test_importing_the_package_imports_nothing_slow():
    script = "import sys, frictionloop; print(*sorted({name.split('.')[0] for name in sys.modules}))"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    assert "frictionloop" in loaded
    slow = "numba numpy scipy xarray matplotlib pandas joblib pydantic h5py control dask"
    assert not set(slow.split()) & set(loaded)


def test_parameters_need_no_compiler():
    script = "import sys, frictionloop as fl; fl.paper(); print(*{name.split('.')[0] for name in sys.modules})"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True).stdout.split()
    assert not {"numba", "scipy", "xarray", "matplotlib", "pandas"} & set(loaded)


def test_every_public_name_exists():
    assert len(set(dir(fl))) == len(dir(fl))
    for name in dir(fl):
        assert getattr(fl, name) is not None
    assert fl.__version__


def test_the_contract_of_names():
    contract = """paper feasible simulate sweep Stepper r2_identity r2_regression rms_error saturation_index r2_bound
    save load System FrictionloopError"""
    assert set(contract.split()) <= set(dir(fl))
    names = {}
    exec("from frictionloop import *", names)
    assert set(dir(fl)) <= set(names)


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'smulate'"):
        fl.smulate  # noqa: B018


def public_nodes(body, prefix=""):
    for node in body:
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
            yield prefix + node.name, node
            if isinstance(node, ast.ClassDef):
                yield from public_nodes(node.body, f"{node.name}.")


def test_every_module_and_every_public_function_and_class_says_what_it_is():
    trees = {str(path.relative_to(FOLDER)): ast.parse(path.read_text()) for path in sorted(FOLDER.rglob("*.py"))}
    assert [name for name, tree in trees.items() if not ast.get_docstring(tree)] == []
    nodes = [(path, *each) for path, tree in trees.items() for each in public_nodes(tree.body)]
    assert [(path, name) for path, name, node in nodes if not ast.get_docstring(node)] == []
    assert len(trees) > 300 and len(nodes) > 1000


def test_a_public_docstring_begins_with_a_sentence():
    first = {name: inspect.getdoc(getattr(fl, name)).split("\n\n")[0] for name in EXPLAINED}
    assert [name for name, said in first.items() if not said.endswith((".", ":"))] == []


def test_a_public_function_says_what_it_takes_and_what_it_raises():
    functions = [getattr(fl, name) for name in dir(fl) if inspect.isfunction(getattr(fl, name))]
    for function in [*functions, fl.Stepper, fl.Stepper.tick, fl.System.evolve]:
        if inspect.signature(function).parameters:
            lines = inspect.getdoc(function).splitlines()
            # Every argument can be wrong.
            assert "FrictionloopError" in " ".join(lines[lines.index("Raises") :]), function
            section = lines[lines.index("Parameters") + 2 :]
            section = itertools.takewhile(lambda line: line not in ("Returns", "Raises"), section)
            listed = [name for line in section if line and line[0] != " " for name in line.split(" : ")[0].split(", ")]
            taken = [name for name in inspect.signature(function).parameters if name != "self"]
            assert [name.lstrip("*") for name in listed] == taken, function


@pytest.mark.slow
@pytest.mark.parametrize("name", ["frictionloop", *MODULES])
def test_examples_in_docstrings_run(name):
    try:
        module = importlib.import_module(name)
    except ModuleNotFoundError as missing:
        assert not missing.name.startswith("frictionloop"), missing
        pytest.skip(f"needs {missing.name}")
    assert doctest.testmod(module).failed == 0


def test_types_are_shipped():
    assert (FOLDER / "py.typed").exists()


SCREEN, LONGER = 66, {"Device": 101, "System": 72, None: 67}
"""Lines of a tall terminal; what has many methods or many fields scrolls once."""


def test_help_fits_a_screen():
    for name in [*EXPLAINED, None]:
        told = pydoc.render_doc(fl if name is None else getattr(fl, name), renderer=pydoc.plaintext)
        assert len(told.splitlines()) <= LONGER.get(name, SCREEN), name
        assert "pydantic.BaseModel" not in told, name


@pytest.mark.parametrize("name", ["Measurement", "Movement", "Sample", "Clamp", "ForceCommand", "Vibration"])
def test_help_of_a_record_shows_its_fields_alone(name):
    record = getattr(fl, name)
    assert {each for each in dir(record) if not each.startswith("__")} == set(record._fields)
    assert pickle.loads(pickle.dumps(record(*range(len(record._fields))))) == record(*range(len(record._fields)))
