"""The documentation: what its code blocks do when run, and that it leaves nothing out."""

from __future__ import annotations

import ast
import importlib
import re
import sys
from fnmatch import fnmatch
from pathlib import Path

import matplotlib as mpl
import pytest

import frictionloop as fl
from frictionloop.loop.blocks import forget
from frictionloop.parameters.block import Block
from frictionloop.parameters.plate_design import PlateDesign
from frictionloop.parameters.sensor_design import SensorDesign
from frictionloop.parameters.system import kinds_of
from frictionloop.parameters.wording import known_names

DOCS = Path(__file__).parents[2] / "docs"
FENCE = re.compile(r"^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
WIDEST = 88
"""Characters of a line of code that the pages show without scrolling."""
SLOW = {"sweep-on-a-cluster", "design-a-controller", "controllers", "my-labs-bench"}
"""Pages that start processes or design controllers: only building the documentation runs them."""
BENCH = ("bench", "bench-gains", "controllers", "oracle", "plate", "force-sensor")
PAGES = [DOCS / "tutorial.md", *(DOCS / f"{name}.md" for name in BENCH), *sorted((DOCS / "how-to").glob("*.md"))]


@pytest.fixture
def tools(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_tools"))
    yield
    forget()
    for name in [name for name, module in sys.modules.items() if str(DOCS) in str(getattr(module, "__file__", ""))]:
        del sys.modules[name]


def blocks(page):
    return FENCE.findall(page.read_text(encoding="utf-8"))


def test_pages_that_take_long_run_where_the_documentation_is_built():
    listed = re.search(r"^executed_pages = (.*)$", (DOCS / "conf.py").read_text(encoding="utf-8"), re.MULTILINE)[1]
    names = [path.relative_to(DOCS).with_suffix("").as_posix() for path in PAGES if path.stem in SLOW]
    assert len(names) == len(SLOW)
    assert all(any(fnmatch(name, each) for each in ast.literal_eval(listed)) for name in names)


@pytest.mark.parametrize("path", [path for path in PAGES if path.stem not in SLOW], ids=lambda path: path.stem)
@pytest.mark.usefixtures("tools")
def test_code_blocks_run(path, tmp_path):
    from page import LANGUAGES, Page

    mpl.use("Agg")
    page, ran = Page(tmp_path), 0
    for language, text in blocks(path):
        if language in LANGUAGES:
            page.run(language, text)
            ran += language == "python"
    assert ran > 0


@pytest.mark.usefixtures("tools")
def test_a_block_shows_what_it_prints_and_draws_and_what_is_refused(tmp_path):
    from page import Page

    page = Page(tmp_path)
    page.run("python", "import frictionloop as fl\nimport matplotlib.pyplot as plt")
    text, figures = page.run("python", "print(1)\nplt.plot([1, 2])\nplt.show()")
    assert text == "1\n"
    assert len(figures) == 1
    assert page.run("python", "fl.preset('papre')  # refused")[0].startswith("FrictionloopError: preset")
    with pytest.raises(fl.FrictionloopError):
        page.run("python", "fl.preset('papre')")
    with pytest.raises(AssertionError, match="nothing was refused"):
        page.run("python", "fl.preset('paper')  # refused")
    page.run("toml", '# mine.toml\nschema = 1\npreset = "paper"\n')
    block = "$ frictionloop simulate mine.toml \\\n    --duration-s 0.1 | head -n 1\n"
    assert page.run("console", block)[0].splitlines()[2:] == ["system            mine.toml"]
    assert "r2_identity" in page.run("console", "$ frictionloop simulate mine.toml --duration-s 0.1")[0]
    with pytest.raises(RuntimeError, match="exit code 2"):
        page.run("console", "$ frictionloop simulate yours.toml")


@pytest.mark.parametrize("path", [*PAGES, DOCS / "index.md"], ids=lambda path: path.stem)
def test_code_fits_the_page(path):
    lines = [line for _, text in blocks(path) for line in text.splitlines()]
    assert [line for line in lines if len(line) > WIDEST] == []


def inner(kind):
    """Blocks that a block holds."""
    found = [field.annotation for field in kind.model_fields.values()]
    return [block for block in found if isinstance(block, type) and issubclass(block, Block)]


@pytest.mark.parametrize("design", [PlateDesign, SensorDesign])
@pytest.mark.usefixtures("tools")
def test_the_table_of_a_design_has_every_value(design):
    from tables import design as table_of

    table = table_of(design)
    assert [path for path in known_names(design, design().model_dump()) if f"| `{path}` |" not in table] == []


@pytest.mark.usefixtures("tools")
def test_the_parameters_page_has_every_block_and_field():
    from tables import BLOCKS, VALUELESS, parameters

    page = (DOCS / "parameters.md").read_text(encoding="utf-8")
    kinds = {kind for block in fl.System.model_fields for kind in kinds_of(block)}
    blocks = {block for kind in kinds for block in [kind, *inner(kind)]} - {fl.Touch}
    assert blocks == {*BLOCKS.values(), *VALUELESS}
    for name, block in BLOCKS.items():
        assert f"{{{{ parameters_{name} }}}}" in page
        table = parameters(block)
        for field, about in block.model_fields.items():
            if field not in ("kind", "model"):
                assert f"| `{field}` |" in table
                assert about.description


def reference():
    return "\n".join(path.read_text(encoding="utf-8") for path in sorted((DOCS / "reference").glob("*.md")))


def test_the_reference_has_every_public_name():
    page = reference()
    assert [name for name in dir(fl) if not re.search(rf":: (\S*\.)?{name}$", page, re.MULTILINE)] == []


@pytest.mark.parametrize("room", ["analysis", "design"])
def test_the_reference_has_every_name_of_the_analysis(room):
    page = reference()
    names = importlib.import_module(f"frictionloop.{room}").__all__
    assert [name for name in names if not re.search(rf":: (\S*\.)?{name}$", page, re.MULTILINE)] == []


@pytest.mark.parametrize("room", ["perception", "identification", "identification.rigs"])
def test_the_reference_has_every_name_of_the_room(room):
    page = reference()
    listed = page.split(f".. currentmodule:: frictionloop.{room}\n")[1].split("currentmodule")[0]
    names = importlib.import_module(f"frictionloop.{room}").__all__
    assert [name for name in names if not re.search(rf":: {name}$", listed, re.MULTILINE)] == []


def test_the_contents_have_every_page():
    listed = re.findall(r"^[\w/-]+$", (DOCS / "index.md").read_text(encoding="utf-8"), re.MULTILINE)
    pages = {
        path.relative_to(DOCS).with_suffix("").as_posix() for path in [*DOCS.glob("*.md"), *DOCS.glob("how-to/*.md")]
    }
    assert pages - {"index"} <= set(listed)


@pytest.mark.usefixtures("tools")
def test_the_numbers_of_the_notes_are_all_used():
    from facts import numbers

    pages = "".join(
        (DOCS / name).read_text(encoding="utf-8") for name in ("model.md", "paper-notes.md", "paper-notes-device.md")
    )
    assert set(re.findall(r"\{\{ n\.(\w+) \}\}", pages)) == set(numbers())


LOOKED_UP = {"parameters", "command-line", "protocol", "reference"}
"""Pages that are looked things up in, not read."""


@pytest.mark.parametrize(
    "page", sorted(DOCS.glob("*.md")) + sorted(DOCS.glob("how-to/*.md")), ids=lambda path: path.stem
)
def test_no_page_is_too_long_to_read(page):
    """Some 2,500 words with their figures and outputs are 8,000 pixels at a width of 1280."""
    if page.stem not in LOOKED_UP:
        assert len(page.read_text(encoding="utf-8").split()) < 2500
